#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/windows/sample.hpp"

namespace tactile {

/// One run of a dataset: its slice of the events, and what it was made from.
struct DatasetRun {
  std::string object;
  std::string run;
  std::string folder;  ///< as given to `windows`: relative to the dataset's own folder where it lies below it
  std::uint64_t first_event = 0;
  std::uint64_t events = 0;
  std::string events_sha256;
  std::string labels_sha256;
};

struct DatasetInterval {
  std::uint32_t run_index = 0;
  TouchInterval interval;
};

/// A rendering stored in a dataset.
struct StoredHeatmaps {
  std::string name;         ///< "th_040", "th_040-1a2b3c4d"
  nlohmann::json settings;  ///< the renderer's
  int width = 0, height = 0;
};

/// A dataset opened for reading: tables are in memory, events and heatmaps are read as they are asked for.
class Dataset {
 public:
  /// @throws Error  if the file is missing, no HDF5, not a dataset of ours, or the events beside it are not its own
  explicit Dataset(std::filesystem::path file);
  ~Dataset();
  Dataset(Dataset&&) noexcept;
  Dataset& operator=(Dataset&&) noexcept;

  const std::filesystem::path& file() const;
  SensorSize sensor() const;
  bool simulated() const;
  std::span<const DatasetRun> runs() const;
  std::span<const DatasetInterval> intervals() const;
  std::span<const Sample> samples() const;
  const nlohmann::json& settings()
      const;  ///< the manifest: "sampling" as SamplingOptions, "mix", "include_flagged", the runs' hashes
  const SamplingOptions& sampling() const;
  const std::string& manifest_hash() const;
  std::filesystem::path run_folder(std::uint32_t run_index) const;

  std::vector<Event> events(std::uint32_t run_index) const;  ///< ascending in time
  /// `count` of the run's events from the one with number `first` on. @throws Error also if it has not so many
  std::vector<Event> events(std::uint32_t run_index, std::uint64_t first, std::uint64_t count) const;
  std::vector<StoredHeatmaps> heatmaps() const;  ///< every history that is listed

  /// That history; nothing if it is not listed, or its file is missing, damaged or of another dataset, so that it is rendered
  /// anew.
  std::optional<StoredHeatmaps> find_heatmaps(const std::string& name) const;

  /// @return [sample_indexes, height, width], one after the other
  std::vector<std::uint8_t> read_heatmaps(const std::string& name, std::span<const std::uint32_t> sample_indexes) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// @throws Error  that names the run, if its events or its labels are not those that the dataset was made from
void check_unchanged(const Dataset& dataset, std::uint32_t run_index);

/// Renderings on their way into a dataset: a file of their own beside it, which the dataset links to once it is whole. The
/// dataset's file is never written under its name; whatever happens, it is there and readable.
class HeatmapsWriter {
 public:
  /// @throws Error  if the file cannot be made
  HeatmapsWriter(const Dataset& dataset, const StoredHeatmaps& description);
  ~HeatmapsWriter();
  HeatmapsWriter(const HeatmapsWriter&) = delete;
  HeatmapsWriter& operator=(const HeatmapsWriter&) = delete;

  /// @param heatmaps  [any number, height, width], in the order of the dataset's samples
  void append(std::span<const std::uint8_t> heatmaps);

  /// @throws Error  if there are not as many heatmaps as samples, or the dataset has been replaced since it was opened
  void commit();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile
