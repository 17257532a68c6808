#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/evaluation/detection_delay.hpp"
#include "tactile/experiments/step_runner.hpp"
#include "tactile/experiments/study/train_models.hpp"

namespace tactile::study {

/// The trainings of a setting, each evaluated on every tick of its own set of runs.
struct EvaluatedModels {
  std::string id;                             ///< "reported", "all_test": also the name of the sets of runs
  std::vector<StudyModel> models;             ///< one for each training
  std::filesystem::path json_file, csv_file;  ///< as `tactile eval` writes them
};

/// The models of a study over full runs.
struct JudgedModels {
  std::vector<EvaluatedModels> evaluations;
  std::string full_run;  ///< "water-bottle/03", a run that is shown over time
  std::filesystem::path full_run_file;

  const EvaluatedModels& evaluation(const std::string& id) const;  ///< one that exists
};

/// The index of the run that is shown over time: the first of the water bottle, as in the paper, that has a press and a slip, by
/// its truth if it is simulated; else the first of any object that has both; else the first. @param runs  not empty
/// @throws Error  if labels or truth of a run are damaged
std::size_t run_to_show(const std::vector<RunFolder>& runs);

/// Fourth stage of a study: evaluates each training with its chosen history on its reported runs, and with the paper's on all its
/// test runs, and predicts one run over time as in the paper's figure 10. @throws Error  if a step fails
JudgedModels judge_models(const StudyPlan& plan, const TrainedModels& trained, experiments::StepRunner& runner);

/// The detections of each run: "runs" of an evaluation. @throws Error, naming `where`, if it has none
std::vector<results::RunDetections> detections_in(const nlohmann::json& evaluation, const std::string& where);

/// The objects whose slips were all detected at the first tick: none missed, none early, and a mean delay of one tick.
std::map<std::string, bool> detected_at_first_tick(const std::map<std::string, results::DelaySummary>& delays, double tick_ms);

}  // namespace tactile::study
