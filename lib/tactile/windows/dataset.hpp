#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/events/event.hpp"
#include "tactile/windows/sample.hpp"

namespace tactile::windows {

/// What one pass over a recording's events finds.
struct RecordingFacts {
  CameraTime first{}, last{};  ///< events
  std::string digest;          ///< `events::EventDigest`
};

/// One run of a dataset: its events, and the files it was made from.
struct DatasetRun {
  std::string object;
  std::string run;
  std::string folder;  ///< relative to the dataset's folder if it lies below it, otherwise absolute
  std::uint64_t first_event = 0;
  std::uint64_t events = 0;
  std::string events_sha256;
  std::string labels_sha256;                ///< `labels::touches_sha256`; in datasets of version 0.1, of the file
  std::optional<RecordingFacts> recording;  ///< datasets of earlier versions have none
};

struct DatasetInterval {
  std::uint32_t run_index = 0;
  TouchInterval interval;
};

/// A rendering stored in a dataset.
struct StoredHeatmaps {     // NOLINT(bugprone-exception-escape): moving nlohmann::json does not throw
  std::string name;         ///< "th_040", "th_040-1a2b3c4d"
  nlohmann::json settings;  ///< the renderer's
  int width = 0, height = 0;
};

/// A dataset, open for reading. Tables are in memory; events and heatmaps are read on request.
class Dataset {
 public:
  /// @throws Error  if the file is missing or not a dataset, or its file of events belongs to another dataset
  explicit Dataset(std::filesystem::path file);
  ~Dataset();
  Dataset(Dataset&&) noexcept;
  Dataset& operator=(Dataset&&) noexcept;

  const std::filesystem::path& file() const;
  events::SensorSize sensor() const;
  bool simulated() const;
  std::span<const DatasetRun> runs() const;
  std::span<const DatasetInterval> intervals() const;
  std::span<const Sample> samples() const;
  /// The manifest: "sampling" as the fields of SamplingOptions, "mix", "include_flagged", the runs' hashes.
  const nlohmann::json& settings() const;
  const SamplingOptions& sampling() const;
  const std::string& manifest_hash() const;
  std::filesystem::path run_folder(std::uint32_t run_index) const;

  std::vector<events::Event> events(std::uint32_t run_index) const;  ///< ascending in time
  /// `count` events of the run, from number `first` on. @throws Error  also if the run has fewer
  std::vector<events::Event> events(std::uint32_t run_index, std::uint64_t first, std::uint64_t count) const;
  std::vector<StoredHeatmaps> heatmaps() const;  ///< all listed histories

  /// One history; nothing if it is not listed, or its file is missing, damaged or of another dataset.
  std::optional<StoredHeatmaps> find_heatmaps(const std::string& name) const;

  /// Compares a listed history with what was written: file, shape, settings, and the SHA-256 of all values.
  /// @return  what is wrong; empty if it is intact
  std::string what_is_wrong_with(const std::string& name) const;
  std::vector<std::string> heatmap_names() const;  ///< all listed histories, readable or not

  /// @return  [sample_indexes, height, width]
  std::vector<std::uint8_t> read_heatmaps(const std::string& name, std::span<const std::uint32_t> sample_indexes) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// @throws Error  that names the run, if its events or labels differ from those that the dataset was made from
void check_unchanged(const Dataset& dataset, std::uint32_t run_index);

/// Whether the labels of the run in `folder` are those that the dataset was made from. @throws Error  if they cannot be read
bool has_labels(const DatasetRun& run, const RunFolder& folder);

/// "fan/01"
std::string name_of(const DatasetRun& run);

/// "fan/03" of each run, in the given order.
/// @param runs  indexes into `Dataset::runs`
std::vector<std::string> names_of(const Dataset& dataset, std::span<const std::uint32_t> runs);

/// Writes the heatmaps of one history to a separate file next to the dataset. When that is complete, the dataset links to it.
/// The dataset's file is replaced in one step, so it is readable at every moment.
class HeatmapsWriter {
 public:
  /// @throws Error  if the file cannot be made
  HeatmapsWriter(const Dataset& dataset, const StoredHeatmaps& description);
  ~HeatmapsWriter();
  HeatmapsWriter(const HeatmapsWriter&) = delete;
  HeatmapsWriter& operator=(const HeatmapsWriter&) = delete;

  /// Heatmaps [any number, height, width] and, of each, the bytes that the file stores.
  struct Packed {
    std::vector<std::uint8_t> heatmaps;
    std::vector<std::vector<std::uint8_t>> chunks;
  };
  /// Several threads may pack at the same time, also while another one appends.
  Packed packed(std::vector<std::uint8_t> heatmaps) const;

  /// Heatmaps that another file stores as these chunks. @param chunks  as `hdf5::packed_chunk` packs them
  /// @throws Error  if they hold other heatmaps than of this history's size
  Packed unpacked(std::vector<std::vector<std::uint8_t>> chunks) const;

  /// Call each in the order of the samples. Two threads may call the two at the same time.
  void add_to_digest(std::span<const std::uint8_t> heatmaps);
  void append(std::span<const std::vector<std::uint8_t>> chunks);

  /// @throws Error  if the number of heatmaps differs from that of the samples, or the dataset was replaced meanwhile
  void commit();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::windows
