#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/evaluation/evaluation.hpp"
#include "tactile/experiments/slurm.hpp"
#include "tactile/experiments/stress/stress_series.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/model/definition/engine_kind.hpp"
#include "tactile/results/whole_runs.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::stress {

/// What to worsen, and which models to judge on it.
struct StressOptions {
  std::optional<std::filesystem::path> dataset{};  ///< a dataset file; nothing: only recordings without a touch
  std::filesystem::path out = "stress";            ///< folder of results
  std::vector<std::filesystem::path> models{};     ///< folders of model bundles, at least one
  std::vector<StressSeries> series{};              ///< at least one
  std::vector<std::filesystem::path> quiet{};      ///< recordings without a touch: every alarm is false
  std::optional<unsigned> runs{};                  ///< at most this many of each object
  evaluation::EvaluationOptions judging{};         ///< `threads` too
  model::EngineKind engine = model::EngineKind::fast;
  std::uint64_t seed = 1;                            ///< as that of the recipes of `series`
  bool force = false;                                ///< do again what is done
  std::filesystem::path program = "/proc/self/exe";  ///< takes the words of `task`
  std::optional<experiments::SlurmOptions> slurm{};  ///< judge on a cluster; nothing: in this process
  /// On a cluster: the words of a process that does one step by `do_step`, with these options and this model alone.
  std::function<std::vector<std::string>(const std::string& step, const std::filesystem::path& model)> task{};
};

/// A run that models are judged on.
struct StressedRun {
  RunFolder folder;
  std::optional<std::uint32_t> index{};  ///< in the dataset; nothing: it has no samples
};

/// A training, and the runs that it is judged on: those of `tactile eval`.
struct StressTraining {
  model::ModelBundle bundle;
  model::ModelDescription description;
  std::vector<StressedRun> runs;  ///< those with samples first
  std::vector<results::LeftOutRun> left_out{};

  std::vector<RunFolder> folders() const;
  std::vector<std::string> names() const;
};

/// Trainings of one setting: they differ in seed and runs learned from.
struct StressGroup {
  std::string name;  ///< of the first training
  std::vector<StressTraining> trainings;
};

struct StressPlan {
  StressOptions options;
  std::optional<windows::Dataset> dataset;
  std::vector<StressGroup> groups;
};

/// Opens the dataset, groups the models, and chooses the runs.
/// @throws Error  if a model does not fit the dataset, models have different ticks, a model is given twice, there is nothing to
///                judge on, or a run differs from the dataset's
StressPlan plan_stress(const StressOptions& options);

/// The first `most` of the runs of each object, in their order.
std::vector<StressedRun> first_of_each_object(std::vector<StressedRun> runs, unsigned most);

/// Whether the models are trainings of one setting.
bool are_trainings_of_one(const model::ModelDescription& a, const model::ModelDescription& b);

}  // namespace tactile::stress
