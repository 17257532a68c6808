#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/windows/dataset.hpp"
#include "tactile/windows/older_dataset.hpp"
#include "tactile/windows/without_samples.hpp"
#include "tactile/windows/write_dataset.hpp"

// The planned contents of a dataset, derived from run folders. Writing and verifying a dataset both use it.
namespace tactile::windows {

/// Camera time in [begin, end).
struct TimeSpan {
  CameraTime begin{}, end{};
};

/// A run of the planned dataset.
struct PlannedRun {
  RunFolder folder;
  RunInfo info;
  WindowedRun outcome;
  std::string events_sha256, labels_sha256;
  events::SensorSize sensor;
  CameraTime first_event{}, last_event{};
  std::string event_digest;
  bool was_read = false;                 ///< its events were read; else an older dataset knows of them
  std::uint64_t recorded_events = 0;     ///< in the recording, if it was read; the dataset stores some of them
  std::vector<TouchInterval> intervals;  ///< those with used labels
  std::vector<Sample> samples;           ///< `run_index` counts planned runs
};

struct DatasetPlan {             // NOLINT(bugprone-exception-escape): moving nlohmann::json does not throw
  std::vector<PlannedRun> runs;  ///< in the dataset
  std::vector<WindowedRun> left_out;
  std::size_t passed_over = 0;                     ///< left out because they are simulated and others are real
  std::vector<RunWithoutSamples> without_samples;  ///< except those passed over; by object, then run
  std::vector<std::string> misnamed;               ///< a sentence for each folder that is left out for its name
  std::vector<std::string> warnings;               ///< those of `misnamed` too
  std::vector<std::string> errors;                 ///< a sentence for each run or folder that cannot be read
  std::vector<std::string> read_runs;              ///< whose recordings were read, those left out too
  events::SensorSize sensor;
  bool simulated = false;

  nlohmann::json settings;
  std::vector<DatasetRun> rows;  ///< of `runs`, without the numbers of events
  nlohmann::json manifest;
};

/// Opens a run's recording at its event stream.
struct OpenRun {
  explicit OpenRun(const RunFolder& run) : recording(run.events()), stream_id(events::event_stream(recording).id) {}
  events::RecordingReader recording;
  std::int32_t stream_id;
};

/// Reads every run below `data` once, except for recordings that the older dataset knows. The plan lists runs that cannot
/// be read. @param older  null: there is none  @throws Error  as `write_dataset`
DatasetPlan plan_dataset(const std::filesystem::path& data, const std::filesystem::path& file, const WindowsOptions& options,
                         unsigned threads, const ProgressCallback& progress, const OlderDataset* older = nullptr);

/// The union of [t - history, t) over a run's samples, as separate spans, ascending.
std::vector<TimeSpan> histories_of(std::span<const Sample> samples, microseconds history);

/// Whether a packet has events of a run's stream from the first history to the last one.
bool may_be_stored(const OpenRun& open, const events::PacketRecord& packet, std::span<const TimeSpan> histories);

/// Passes those events of the packets to `use` that lie in a run's histories. @param packets  of `open`, in file order
void for_stored_events(OpenRun& open, std::span<const events::PacketRecord> packets, std::span<const TimeSpan> histories,
                       const std::function<void(std::span<const events::Event>)>& use);

}  // namespace tactile::windows
