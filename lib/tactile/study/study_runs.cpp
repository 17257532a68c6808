#include "tactile/study/study_runs.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <set>

#include "tactile/core/error.hpp"
#include "tactile/model/train_model.hpp"

namespace tactile {

StudyRuns study_runs(const Dataset& dataset, const std::string& train_run, std::span<const std::string> choice_runs) {
  std::set<std::uint32_t> with_samples;
  for (const Sample& sample : dataset.samples()) with_samples.insert(sample.run_index);
  StudyRuns runs;
  for (const std::uint32_t run : with_samples) {
    const std::string& id = dataset.runs()[run].run;
    if (id == train_run) {
      runs.train.push_back(run);
      continue;
    }
    runs.all_test.push_back(run);
    const bool is_choice = std::find(choice_runs.begin(), choice_runs.end(), id) != choice_runs.end();
    (is_choice ? runs.choice : runs.reported).push_back(run);
  }
  if (runs.all_test.empty()) {
    throw Error(fmt::format("{}: no run with samples but those trained on (run {}); expected one to test on at least",
                            dataset.file().string(), train_run));
  }
  if (runs.reported.empty()) std::swap(runs.choice, runs.reported);
  return runs;
}

std::vector<std::string> names_of(const Dataset& dataset, std::span<const std::uint32_t> runs) {
  std::vector<std::string> names;
  for (const std::uint32_t run : runs) names.push_back(name_of(dataset.runs()[run]));
  return names;
}

}  // namespace tactile
