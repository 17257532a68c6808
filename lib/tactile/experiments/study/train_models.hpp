#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tactile/evaluation/accuracy.hpp"
#include "tactile/experiments/step_runner.hpp"
#include "tactile/experiments/study/history_choice.hpp"
#include "tactile/experiments/study/plan_study.hpp"

namespace tactile::study {

/// Histories compared on one set of runs.
struct HistoryComparison {
  std::map<microseconds, std::vector<results::RunConfusion>> confusions;  ///< of each run, all trainings summed
  AccuracyByHistory accuracies;
  HistoryChoice choice;
};

/// The models of a study, and the history chosen by them.
struct TrainedModels {
  std::map<microseconds, std::vector<StudyModel>> by_history;  ///< one for each seed
  std::map<std::string, HistoryComparison> comparisons;        ///< by the name of the set of runs; empty sets have none
  microseconds history{0};                                     ///< chosen on the runs to choose on
  microseconds paper_history{0};                               ///< chosen on all test runs, as in the paper
  std::vector<StudyModel> held_out;  ///< with `history`, without `StudyPlan::held_out`: one for each seed; may be empty
  std::vector<StudyModel> splits;    ///< with `history`, one for each of `StudyPlan::splits`

  const StudyModel& chosen() const { return by_history.at(history).front(); }
};

/// Third stage of a study: trains a model for each history and seed, chooses a history, and trains models without held-out
/// objects. Each model is judged on its samples, which the choice depends on.
/// @throws Error  if a step fails
TrainedModels train_models(const StudyPlan& plan, experiments::StepRunner& runner);

/// The file with a model's confusion on each of its runs.
std::filesystem::path samples_file(const StudyPlan& plan, const StudyModel& model);

/// The confusion of models, summed, on each of these runs. @throws Error  if one of the models was not judged on all of them
std::vector<results::RunConfusion> confusions_of(const StudyPlan& plan, const std::vector<StudyModel>& models,
                                                 const std::vector<std::string>& runs);

}  // namespace tactile::study
