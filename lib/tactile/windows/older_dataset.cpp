#include "tactile/windows/older_dataset.hpp"

#include <algorithm>
#include <string_view>

#include "tactile/windows/run_samples.hpp"

namespace tactile::windows {

UnusableDataset::UnusableDataset(const Error& why)
    : Error(std::string(why.what()).substr(0, std::string_view(why.what()).find("; expected"))) {}

OlderDataset::OlderDataset(const Dataset& dataset) : dataset_(&dataset), samples_(dataset.runs().size()) {
  for (std::uint32_t index = 0; index < dataset.runs().size(); ++index)
    runs_of_recording_.emplace(dataset.runs()[index].events_sha256, index);
  for (const RunSamples& run : samples_by_run(dataset)) samples_[run.run_index] = dataset.samples().subspan(run.first, run.count);
}

std::optional<RecordingFacts> OlderDataset::facts_of(const std::string& events_sha256) const {
  const auto found = runs_of_recording_.find(events_sha256);
  return found == runs_of_recording_.end() ? std::nullopt : dataset_->runs()[found->second].recording;
}

const DatasetRun* OlderDataset::run_of(const RunFolder& run, const std::string& events_sha256) const {
  const auto [begin, end] = runs_of_recording_.equal_range(events_sha256);
  const auto found =
      std::find_if(begin, end, [&](const auto& one) { return name_of(dataset_->runs()[one.second]) == run.name(); });
  return found == end ? nullptr : &dataset_->runs()[found->second];
}

std::optional<std::uint32_t> OlderDataset::with_same_events(const std::string& events_sha256, std::span<const Sample> samples,
                                                            microseconds history) const {
  if (dataset_->sampling().history != history) return std::nullopt;
  const auto [begin, end] = runs_of_recording_.equal_range(events_sha256);
  for (auto run = begin; run != end; ++run) {
    const std::span<const Sample> older = samples_[run->second];
    const auto same_time = [](const Sample& a, const Sample& b) { return a.t == b.t; };
    if (std::equal(samples.begin(), samples.end(), older.begin(), older.end(), same_time)) return run->second;
  }
  return std::nullopt;
}

std::vector<events::Event> OlderDataset::events(std::uint32_t run_index, std::uint64_t first, std::uint64_t count) const {
  try {
    return dataset_->events(run_index, first, count);
  } catch (const Error& e) {
    throw UnusableDataset(e);
  }
}

DatasetChanges changes_between(const Dataset& older, std::span<const DatasetRun> runs, const std::vector<bool>& same_events) {
  std::map<std::string, const DatasetRun*> before;
  for (const DatasetRun& run : older.runs()) before.emplace(name_of(run), &run);
  DatasetChanges changes;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const auto found = before.find(name_of(runs[i]));
    if (found == before.end()) {
      changes.added.push_back(name_of(runs[i]));
      continue;
    }
    const DatasetRun& run = *found->second;
    const bool same = same_events[i] && run.events_sha256 == runs[i].events_sha256 && run.labels_sha256 == runs[i].labels_sha256;
    (same ? changes.kept : changes.changed).push_back(name_of(runs[i]));
    before.erase(found);
  }
  for (const auto& [name, run] : before) changes.dropped.push_back(name);
  return changes;
}

}  // namespace tactile::windows
