#include "tactile/windows/dataset_split.hpp"

namespace tactile::windows {

Split split_runs(const Dataset& dataset, const SplitOptions& options) {
  std::vector<RunName> names;
  for (const DatasetRun& run : dataset.runs()) names.push_back({run.object, run.run, false});
  for (const Sample& sample : dataset.samples()) names[sample.run_index].has_samples = true;
  return split_runs(names, options);
}

}  // namespace tactile::windows
