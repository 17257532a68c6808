#include "tactile/experiments/run_division.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <set>

#include "tactile/model/training/split_remarks.hpp"
#include "tactile/model/training/train_model.hpp"

namespace tactile::experiments {

RunDivision divide_runs(const windows::Dataset& dataset, const std::string& train_run, std::span<const std::string> choice_runs) {
  RunDivision runs;
  runs.train = model::split_of(dataset, {.kind = windows::SplitKind::single_run, .train_run = train_run}).train_runs;
  std::set<std::uint32_t> others;
  for (const windows::Sample& sample : dataset.samples()) others.insert(sample.run_index);
  for (const std::uint32_t run : runs.train) others.erase(run);
  for (const std::uint32_t run : others) {
    runs.all_test.push_back(run);
    const bool is_choice = std::find(choice_runs.begin(), choice_runs.end(), dataset.runs()[run].run) != choice_runs.end();
    (is_choice ? runs.choice : runs.reported).push_back(run);
  }
  if (runs.reported.empty()) std::swap(runs.choice, runs.reported);
  return runs;
}

std::string rotated_run(const windows::Dataset& dataset, const std::string& run, std::size_t steps) {
  std::set<std::string> ids;
  for (const windows::Sample& sample : dataset.samples()) ids.insert(dataset.runs()[sample.run_index].run);
  if (ids.empty() || steps == 0) return run;
  const std::vector<std::string> ring(ids.begin(), ids.end());
  const auto found = std::find(ring.begin(), ring.end(), run);
  const std::size_t place = found == ring.end() ? 0 : static_cast<std::size_t>(found - ring.begin());
  return ring[(place + steps) % ring.size()];
}

RunDivision rotated_division(const windows::Dataset& dataset, const std::string& train_run,
                             std::span<const std::string> choice_runs, std::size_t training) {
  std::vector<std::string> choice;
  for (const std::string& run : choice_runs) choice.push_back(rotated_run(dataset, run, training));
  return divide_runs(dataset, rotated_run(dataset, train_run, training), choice);
}

std::vector<std::string> remarks_on(const windows::Dataset& dataset, const RunDivision& runs) {
  const std::vector<std::string> untested = model::objects_only_in(dataset, runs.train, runs.all_test),
                                 unreported = model::objects_only_in(dataset, runs.all_test, runs.reported),
                                 unchosen = model::objects_only_in(dataset, runs.reported, runs.choice);
  std::vector<std::string> remarks;
  for (const std::uint32_t run : runs.train) {
    const windows::DatasetRun& trained_on = dataset.runs()[run];
    const auto is_in = [&](const std::vector<std::string>& objects) {
      return std::find(objects.begin(), objects.end(), trained_on.object) != objects.end();
    };
    if (is_in(untested)) {
      remarks.push_back(fmt::format("{}: not tested, none of its runs but {} has samples", trained_on.object, trained_on.run));
    } else if (is_in(unreported)) {
      remarks.push_back(
          fmt::format("{}: not reported on, its other runs with samples are there to choose settings on", trained_on.object));
    } else if (!runs.choice.empty() && is_in(unchosen)) {
      remarks.push_back(fmt::format("{}: no run of it is left to choose settings on", trained_on.object));
    }
  }
  return remarks;
}

}  // namespace tactile::experiments
