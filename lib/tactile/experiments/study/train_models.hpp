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
  std::map<microseconds, std::vector<results::RunConfusion>> confusions;  ///< of each training on each of its runs
  AccuracyByHistory accuracies;
  results::HistoryChoice choice;
};

/// The models of a study, and the histories chosen by them.
struct TrainedModels {
  std::map<microseconds, std::vector<StudyModel>> by_history;  ///< one for each training
  std::map<std::string, HistoryComparison> comparisons;        ///< by the name of the set of runs; empty sets have none
  std::vector<microseconds> chosen;  ///< of each training, on its own runs to choose on: what is reported never chose it
  microseconds history{0};           ///< chosen on the runs to choose on of all trainings: the one to use
  microseconds paper_history{0};     ///< chosen on all test runs, as in the paper
  std::vector<std::vector<StudyModel>> held_out;  ///< without each of `StudyPlan::held_out`, one for each training
  std::vector<StudyModel> splits;                 ///< one for each of `StudyPlan::splits`, of one training after another

  const StudyModel& to_use() const { return by_history.at(history).front(); }
  const StudyModel& reported(std::size_t training) const { return by_history.at(chosen[training])[training]; }
};

/// Third stage of a study: trains models for each history, chooses histories, and trains models without held-out objects. Such a
/// model has the history that is best for the other objects. Each model is judged on its samples, which the choice depends on.
/// @throws Error  if a step fails
TrainedModels train_models(const StudyPlan& plan, experiments::StepRunner& runner);

/// The file with a model's confusion on each of its runs.
std::filesystem::path samples_file(const StudyPlan& plan, const StudyModel& model);

/// The confusion of a model on each of these runs. @throws Error  if it was not judged on all of them
std::vector<results::RunConfusion> confusions_of(const StudyPlan& plan, const StudyModel& model,
                                                 const std::vector<std::string>& runs);

}  // namespace tactile::study
