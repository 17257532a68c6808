#include "tactile/model/training/split_remarks.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>
#include <set>

#include "tactile/model/training/train_model.hpp"
#include "tactile/windows/without_samples.hpp"

namespace tactile::model {
namespace {

std::set<std::string> objects_with_samples_in(const windows::Dataset& dataset, std::span<const std::uint32_t> runs) {
  std::set<std::string> objects;
  for (const std::uint32_t sample : samples_of_runs(dataset, runs))
    objects.insert(dataset.runs()[dataset.samples()[sample].run_index].object);
  return objects;
}

}  // namespace

std::vector<std::string> objects_only_in(const windows::Dataset& dataset, std::span<const std::uint32_t> runs,
                                         std::span<const std::uint32_t> others) {
  const auto in_runs = objects_with_samples_in(dataset, runs), in_others = objects_with_samples_in(dataset, others);
  std::vector<std::string> objects;
  std::set_difference(in_runs.begin(), in_runs.end(), in_others.begin(), in_others.end(), std::back_inserter(objects));
  return objects;
}

SplitRemarks remarks_on(const windows::Dataset& dataset, const windows::SplitOptions& options, const windows::Split& split) {
  SplitRemarks remarks;
  const std::vector<windows::RunWithoutSamples> left_out = windows::runs_of_objects_left_out(dataset);
  remarks.left_out = windows::objects_left_out(left_out, {});
  for (const windows::RunWithoutSamples& run : left_out) {
    if (run.reason.flagged && !remarks.flagged) remarks.flagged = windows::run_of(dataset, run.object, run.run);
  }
  const std::vector<std::string> untested = options.kind == windows::SplitKind::single_run
                                                ? objects_only_in(dataset, split.train_runs, split.test_runs)
                                                : std::vector<std::string>{};
  for (const std::uint32_t index : split.train_runs) {
    const windows::DatasetRun& run = dataset.runs()[index];
    if (std::find(untested.begin(), untested.end(), run.object) != untested.end())
      remarks.untested.push_back(fmt::format("{}: not tested, none of its runs but {} has samples", run.object, run.run));
    if (run.run == options.train_run) continue;
    const RunFolder wanted = windows::run_of(dataset, run.object, options.train_run);
    const windows::NoSamples reason = windows::why_no_samples(dataset, wanted).value_or(windows::has_no("samples"));
    if (reason.flagged) remarks.flagged = wanted;
    remarks.substitutes.push_back(
        fmt::format("{}: trained on run {} in place of {}{}", run.object, run.run, options.train_run, reason.clause));
  }
  return remarks;
}

}  // namespace tactile::model
