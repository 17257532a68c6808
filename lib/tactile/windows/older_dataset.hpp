#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/windows/dataset.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile::windows {

/// The older dataset cannot give what it lists. The message has no remedy: the dataset is made again.
class UnusableDataset : public Error {
 public:
  explicit UnusableDataset(const Error& why);
};

/// What a dataset keeps of the one that it replaces. Runs are found by the hash of their recording.
///
/// The samples of a run follow from its labels, the times of its first and last event, and the settings. They are drawn again,
/// which costs little. Its events follow from its recording, the times of its samples, and the history.
class OlderDataset {
 public:
  /// @param dataset  that outlives this one
  explicit OlderDataset(const Dataset& dataset);

  events::SensorSize sensor() const { return dataset_->sensor(); }

  /// What is known of a recording; nothing if the dataset has not read it.
  std::optional<RecordingFacts> facts_of(const std::string& events_sha256) const;

  /// The run with the same recording, history and times of samples, so also with the same events.
  std::optional<std::uint32_t> with_same_events(const std::string& events_sha256, std::span<const Sample> samples,
                                                microseconds history) const;

  /// The run of this name with the same recording; null if there is none.
  const DatasetRun* run_of(const RunFolder& run, const std::string& events_sha256) const;

  std::uint64_t events_of(std::uint32_t run_index) const { return dataset_->runs()[run_index].events; }

  /// `count` events of a run, from number `first` on. @throws UnusableDataset  if they cannot be read
  std::vector<events::Event> events(std::uint32_t run_index, std::uint64_t first, std::uint64_t count) const;

  const Dataset& dataset() const { return *dataset_; }

 private:
  const Dataset* dataset_;
  std::multimap<std::string, std::uint32_t> runs_of_recording_;
  std::vector<std::span<const Sample>> samples_;  ///< of each run
};

/// The runs of a new dataset, compared with those of the older one: "fan/01".
/// @param same_events  of each of `runs`: whether the older dataset has its events
DatasetChanges changes_between(const Dataset& older, std::span<const DatasetRun> runs, const std::vector<bool>& same_events);

}  // namespace tactile::windows
