#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tactile/core/confirmation.hpp"
#include "tactile/core/progress.hpp"
#include "tactile/evaluation/detection_delay.hpp"
#include "tactile/model/inference/classifier.hpp"
#include "tactile/model/inference/two_thresholds.hpp"
#include "tactile/results/cell.hpp"
#include "tactile/results/evaluation.hpp"
#include "tactile/results/unseen_comparison.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::evaluation {

struct EvaluationOptions {
  Confirmation confirmation{};
  std::optional<model::TwoThresholds> thresholds = std::nullopt;  ///< which then replace the confirmation
  bool onset_visible = false;  ///< touches begin when the events show them by eye (`with_visible_onsets`)
  DelayOptions delay{};
  results::BootstrapOptions bootstrap{};
  unsigned threads = 0;  ///< 0: as many as the machine has cores; no figure depends on it

  /// Whether the model may be of another dataset, such as one with corrected labels or more runs.
  bool of_another_dataset = false;
};

/// A trained model, and the runs that it is judged on: indexes into a dataset's runs, none of them trained on.
struct ModelOnRuns {
  const model::Classifier* classifier = nullptr;
  std::vector<std::uint32_t> runs;
};

/// Removes the runs that the model's temperature was fitted on. @throws Error  if none with samples is left
void leave_out_calibration_runs(std::vector<std::uint32_t>& runs, const windows::Dataset& dataset,
                                const model::Classifier& classifier);

/// What `evaluate` gives.
struct Evaluated {
  results::Evaluation evaluation;
  std::vector<results::Cell> cells;  ///< that its figures of whole runs are made from
};

/// Evaluates trainings of one setting by one pass over every tick of run folders. A balanced sample takes the verdict at its
/// tick. Intervals are over trainings, objects and runs.
///
/// Accuracy and delays from labels are of runs of the dataset, which have a press and a slip without a flag. `whole_runs` has all
/// runs beside them in the data folder, of the same objects, that the training did not learn from: also flagged ones, and those
/// without a press or a slip.
///
/// @param trainings  at least one, of the same tick
/// @throws Error  if a model is of another dataset and must not be, or takes heatmaps of another size; if the models have
///                different ticks; if events or labels of a run have changed since the dataset was made; if a sample is at no
///                tick of the model; or if a recording cannot be read
Evaluated evaluate(const windows::Dataset& dataset, std::span<const ModelOnRuns> trainings, const EvaluationOptions& options = {},
                   const ProgressCallback& progress = {});

/// The same of one model.
Evaluated evaluate(const windows::Dataset& dataset, const model::Classifier& classifier, std::span<const std::uint32_t> test_runs,
                   const EvaluationOptions& options = {}, const ProgressCallback& progress = {});

/// What one training says on its runs.
struct JudgedTraining {
  std::vector<results::Cell> cells;
  std::vector<results::LeftOutRun> left_out;
};

/// Judges a training on whole runs, as `Evaluation::whole_runs`: the cells of each run as they were decided and along the curve
/// of thresholds, and with `baselines` those of the baselines. Only these have a setting, their name. @throws Error as `evaluate`
JudgedTraining judge_whole_runs(const windows::Dataset& dataset, const ModelOnRuns& training, bool baselines,
                                const EvaluationOptions& options = {}, const ProgressCallback& progress = {});

/// Judges a training on the balanced samples of its runs: a cell for each run that has nothing else. They are read from the
/// dataset's heatmaps, or from every tick of the run folders where verdicts are confirmed or by thresholds.
/// @throws Error as `evaluate`
std::vector<results::Cell> judge_samples(const windows::Dataset& dataset, const ModelOnRuns& training,
                                         const EvaluationOptions& options = {}, const ProgressCallback& progress = {});

/// One training with some objects and one without them, and runs of these objects that neither model was trained on.
struct UnseenPair {
  const model::Classifier* seen = nullptr;
  const model::Classifier* held_out = nullptr;
  std::vector<std::uint32_t> runs;
};

/// Differences are paired over runs and trainings. @param pairs  at least one. @throws Error  as `evaluate`
results::UnseenComparison compare_unseen(const windows::Dataset& dataset, std::span<const UnseenPair> pairs,
                                         const EvaluationOptions& options = {}, const ProgressCallback& progress = {});

/// The runs of the objects held out that neither model was trained on. @throws Error  if none has samples
std::vector<std::uint32_t> runs_neither_saw(const windows::Dataset& dataset, const model::ModelDescription& seen,
                                            const model::ModelDescription& held_out);

}  // namespace tactile::evaluation
