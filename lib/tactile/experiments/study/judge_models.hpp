#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/experiments/step_runner.hpp"
#include "tactile/experiments/study/plan_study.hpp"
#include "tactile/results/cell.hpp"
#include "tactile/results/study.hpp"

namespace tactile::study {

/// The table of a model's cells.
std::filesystem::path cells_file(const StudyPlan& plan, const StudyModel& model);

/// Whether a model's judgement has published detectors too: those of streams, since they learn from the same runs as a LeNet.
bool judges_baselines(const StudyModel& model);

/// "event_rate-unseen": what the cells of a baseline have as their setting.
std::string setting_of_baseline(const std::string& name, const StudyModel& model);

/// Third stage of a study: trains all models, and judges each one in a process of its own. @throws Error  if a step fails
void train_and_judge(const StudyPlan& plan, experiments::StepRunner& runner);

/// The cells of all models, with their worlds, trainings and settings. @throws Error  if a table is missing or damaged
std::vector<results::Cell> cells_of(const StudyPlan& plan);

/// What one such process does.
struct Judgement {
  std::filesystem::path dataset, bundle, out;
  std::vector<std::string> runs;  ///< "fan/03"
  bool whole = false, baselines = false;
  model::EngineKind engine = model::EngineKind::fast;
  unsigned threads = 1;
};

/// @throws Error  if a run is not of the dataset, or as `evaluate`
void judge(const Judgement& judgement, const ProgressCallback& progress);

/// Predicts runs over time, as in the paper's figure 10: a press and a slip by the LeNet and by the stream of the first training,
/// and a firm lift by the stream. @throws Error  if a step fails
std::vector<results::ReportedRun> predict_runs(const StudyPlan& plan, experiments::StepRunner& runner);

}  // namespace tactile::study
