#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tactile/evaluation/detection_delay.hpp"
#include "tactile/experiments/step_runner.hpp"
#include "tactile/experiments/study/train_models.hpp"

namespace tactile::study {

/// A model evaluated on every tick of a set of runs.
struct EvaluatedModel {
  std::string id;  ///< "reported", "reported-s2" of the second seed, "all_test"
  StudyModel model;
  std::string runs;                           ///< name of the set
  std::filesystem::path json_file, csv_file;  ///< as `tactile eval` writes them
};

/// The models of a study over full runs.
struct JudgedModels {
  std::vector<EvaluatedModel> evaluations;
  std::string full_run;  ///< "water-bottle/03", a run that is shown over time
  std::filesystem::path full_run_file;

  const EvaluatedModel& evaluation(const std::string& id) const;  ///< one that exists
};

/// Fourth stage of a study: evaluates the models of the chosen history on the reported runs, and the paper's on all test runs,
/// and predicts one run over time as in the paper's figure 10. @throws Error  if a step fails
JudgedModels judge_models(const StudyPlan& plan, const TrainedModels& trained, experiments::StepRunner& runner);

/// The detections of each run: "runs" of an evaluation. @throws Error, naming `where`, if it has none
std::vector<results::RunDetections> detections_in(const nlohmann::json& evaluation, const std::string& where);

/// The objects whose slips were all detected at the first tick: none missed, none early, and a mean delay of one tick.
std::map<std::string, bool> detected_at_first_tick(const std::map<std::string, results::DelaySummary>& delays, double tick_ms);

}  // namespace tactile::study
