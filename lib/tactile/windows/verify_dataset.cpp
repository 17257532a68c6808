#include "tactile/windows/verify_dataset.hpp"

#include <algorithm>
#include <map>
#include <mutex>
#include <optional>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/windows/dataset.hpp"
#include "tactile/windows/dataset_layout.hpp"
#include "tactile/windows/dataset_plan.hpp"
#include "tactile/windows/shared_events.hpp"

namespace tactile::windows {
namespace fs = std::filesystem;

namespace {

constexpr double chance_share = 0.01;  // of the events in windows: fewer may be equal by chance

using Differences = std::vector<std::string>;

/// A run's events in the dataset, read block by block.
class StoredEvents {
 public:
  StoredEvents(const Dataset& dataset, std::uint32_t run_index) : dataset_(dataset), run_index_(run_index) {}

  /// Whether the next events are these.
  bool continue_with(std::span<const events::Event> events) {
    while (!events.empty()) {
      if (next_ == block_.size() && !read_block()) return false;
      const std::size_t count = std::min(events.size(), block_.size() - next_);
      if (!std::equal(events.begin(), events.begin() + static_cast<std::ptrdiff_t>(count),
                      block_.begin() + static_cast<std::ptrdiff_t>(next_)))
        return false;
      next_ += count;
      events = events.subspan(count);
    }
    return true;
  }
  bool at_end() { return next_ == block_.size() && !read_block(); }

 private:
  bool read_block() {
    constexpr std::uint64_t events_in_block = 1 << 18;
    const std::uint64_t left = dataset_.runs()[run_index_].events - read_;
    block_ = dataset_.events(run_index_, read_, std::min(left, events_in_block));
    read_ += block_.size();
    next_ = 0;
    return !block_.empty();
  }

  const Dataset& dataset_;
  std::uint32_t run_index_;
  std::uint64_t read_ = 0;
  std::vector<events::Event> block_;
  std::size_t next_ = 0;
};

void compare_samples(const Dataset& dataset, std::uint32_t stored_index, const PlannedRun& run, Differences& differences) {
  std::vector<Sample> samples;
  for (Sample sample : dataset.samples()) {
    if (sample.run_index != stored_index) continue;
    sample.run_index = run.samples.empty() ? 0 : run.samples.front().run_index;
    samples.push_back(sample);
  }
  if (samples == run.samples) return;
  const auto [a, b] = std::mismatch(samples.begin(), samples.end(), run.samples.begin(), run.samples.end());
  const auto text_of = [](const std::vector<Sample>& of, auto at) {
    return at == of.end() ? std::string("nothing")
                          : std::string(name_of(at->touch)) + " at " + std::to_string(us_of(at->t)) + " us";
  };
  differences.push_back(run.folder.name() + ": sample " + std::to_string(a - samples.begin()) + " is " + text_of(samples, a) +
                        ", its runs and labels give " + text_of(run.samples, b));
}

void compare_intervals(const Dataset& dataset, std::uint32_t stored_index, const PlannedRun& run, Differences& differences) {
  std::vector<TouchInterval> intervals;
  for (const DatasetInterval& interval : dataset.intervals()) {
    if (interval.run_index == stored_index) intervals.push_back(interval.interval);
  }
  const bool same = std::equal(
      intervals.begin(), intervals.end(), run.intervals.begin(), run.intervals.end(),
      [](const TouchInterval& a, const TouchInterval& b) { return a.touch == b.touch && a.start == b.start && a.end == b.end; });
  if (!same) differences.push_back(run.folder.name() + ": its intervals differ from its labels");
}

/// The differences between one run of a dataset and its folder.
Differences compare_run(const Dataset& dataset, std::uint32_t stored_index, const PlannedRun& run) {
  Differences differences;
  const DatasetRun& stored = dataset.runs()[stored_index];
  const std::string name = run.folder.name();
  if (stored.events_sha256 != run.events_sha256)
    differences.push_back(name + ": events.aedat4 has changed since the dataset was made");
  if (!has_labels(stored, run.folder)) differences.push_back(name + ": labels.json has changed since the dataset was made");
  compare_samples(dataset, stored_index, run, differences);
  compare_intervals(dataset, stored_index, run, differences);
  StoredEvents events(dataset, stored_index);
  bool same = true;
  if (const auto histories = histories_of(run.samples, dataset.sampling().history); !histories.empty()) {
    OpenRun open(run.folder);
    for_stored_events(open, open.recording.packets(), histories,
                      [&](std::span<const events::Event> expected) { same = same && events.continue_with(expected); });
  }
  if (!same || !events.at_end()) differences.push_back(name + ": its events differ from those in the histories of its samples");
  return differences;
}

void check_histories(const Dataset& dataset, DatasetCheck& check) {
  for (const std::string& name : dataset.heatmap_names()) {
    if (const std::string wrong = dataset.what_is_wrong_with(name); wrong.empty()) {
      check.histories.push_back(name);
    } else {
      std::string& difference = check.differences.emplace_back(name);
      difference.append(": ").append(wrong).append("; remove ");
      difference.append(dataset_layout::file_beside(dataset.file(), name).string()).append(" and run 'tactile heatmaps' again");
    }
  }
}

/// Adds the runs that share a recording or a piece of one, which the runs of a dataset must not.
void compare_recordings(const DatasetPlan& plan, microseconds history, unsigned threads, const ProgressCallback& progress,
                        DatasetCheck& check) {
  std::map<std::string, std::string> run_of_file;
  for (const PlannedRun& run : plan.runs) {
    const auto [same_file, is_new] = run_of_file.emplace(run.events_sha256, run.folder.name());
    if (is_new) continue;
    check.differences.push_back(run.folder.name() + ": has the same recording as " + same_file->second +
                                ", so training windows share events with test windows");
  }
  const auto text_of = [](std::uint64_t count) { return std::to_string(count); };
  for (const SharedEvents& pair : shared_events(plan.runs, history, threads, progress)) {
    const PlannedRun &run = plan.runs[pair.run_index], &other = plan.runs[pair.other_index];
    check.pairs_at_one_time += pair.run_index < pair.other_index ? 1 : 0;
    if (static_cast<double>(pair.shared) <= chance_share * static_cast<double>(pair.events)) {
      check.equal_by_chance += pair.shared;
    } else if (run.events_sha256 != other.events_sha256) {
      check.differences.push_back(run.folder.name() + ": " + text_of(pair.shared) + " of the " + text_of(pair.events) +
                                  " events in its windows during the recording of " + other.folder.name() +
                                  " are in that recording too, so training windows share events with test windows");
    }
  }
}

}  // namespace

DatasetCheck verify_dataset(const fs::path& data, const fs::path& file, unsigned threads, const ProgressCallback& progress) {
  std::optional<Dataset> opened;
  try {
    opened.emplace(file);
  } catch (const Error& e) {
    if (!fs::exists(file)) throw;
    DatasetCheck damaged;
    damaged.differences.emplace_back(e.what());
    return damaged;
  }
  const Dataset& dataset = *opened;
  const WindowsOptions options{.sampling = dataset.sampling(),
                               .mix = member<bool>(dataset.settings(), "mix", file.string()),
                               .include_flagged = member<bool>(dataset.settings(), "include_flagged", file.string())};
  DatasetCheck check;
  check_histories(dataset, check);
  DatasetPlan plan;
  try {
    plan = plan_dataset(data, file, options, threads, progress);
  } catch (const Error& e) {
    if (!fs::exists(data)) throw;
    check.differences.emplace_back(e.what());  // for example invalid labels: these runs give no dataset
    return check;
  }
  if (dataset.sensor() != plan.sensor) check.differences.emplace_back("the sensor's size differs from that of the runs");
  if (dataset.simulated() != plan.simulated) check.differences.emplace_back("the dataset's mark for simulated runs is wrong");
  std::map<std::string, std::uint32_t> stored;
  for (std::uint32_t index = 0; index < dataset.runs().size(); ++index) {
    stored.emplace(dataset.runs()[index].object + "/" + dataset.runs()[index].run, index);
  }
  std::vector<Differences> of_runs(plan.runs.size());
  std::mutex guard;
  std::uint64_t done = plan.runs.size();
  parallel_for(plan.runs.size(), threads, [&](std::size_t i) {
    const std::string name = plan.runs[i].folder.name();
    try {
      if (const auto found = stored.find(name); found != stored.end()) {
        of_runs[i] = compare_run(dataset, found->second, plan.runs[i]);
      } else {
        of_runs[i].push_back(name + ": is among the runs but not in the dataset");
      }
    } catch (const Error& e) {
      of_runs[i].push_back(name + ": cannot be compared, " + e.what());
    }
    const std::scoped_lock lock(guard);
    report_progress(progress, ++done, 2 * plan.runs.size(), name);
  });
  for (std::size_t i = 0; i < plan.runs.size(); ++i) {
    check.differences.insert(check.differences.end(), of_runs[i].begin(), of_runs[i].end());
    stored.erase(plan.runs[i].folder.name());
  }
  for (const auto& [name, index] : stored) {
    const auto is_it = [&name = name](const WindowedRun& run) { return run.object + "/" + run.run == name; };
    const auto left_out = std::find_if(plan.left_out.begin(), plan.left_out.end(), is_it);
    check.differences.push_back(name + ": is in the dataset but no longer among the runs to use" +
                                (left_out == plan.left_out.end() ? ", there is no such run" : ": " + left_out->remark));
  }
  compare_recordings(plan, dataset.sampling().history, threads, progress, check);
  return check;
}

}  // namespace tactile::windows
