#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "tactile/experiments/run_division.hpp"
#include "tactile/experiments/study/held_out_splits.hpp"
#include "tactile/experiments/study/study_options.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/model/definition/model_settings.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::study {

/// A set of runs.
struct RunSet {
  std::vector<std::uint32_t> runs;
  std::vector<std::string> names;  ///< "fan/03" of each run
};

/// What one training of every setting learns from, and what it is judged on.
struct PlannedTraining {
  std::uint64_t seed = 0;
  std::string train_run;  ///< id of each object's training run
  RunSet train;
  RunSet choice;    ///< to choose a history on; empty if no run would be left to report on
  RunSet reported;  ///< neither trained nor chosen on
  RunSet all_test;  ///< all but those trained on
};

/// The sets of runs that figures are computed on.
struct NamedRunSet {
  const char* name;
  RunSet PlannedTraining::*runs;
};
inline constexpr std::array<NamedRunSet, 3> run_sets{
    {{"choice", &PlannedTraining::choice}, {"reported", &PlannedTraining::reported}, {"all_test", &PlannedTraining::all_test}}};

/// What a study does with its dataset.
struct StudyPlan {
  StudyOptions options;                            ///< as `completed` returns them
  const windows::Dataset& dataset;                 ///< must outlive the plan
  std::vector<PlannedTraining> trainings;          ///< at least one; the runs rotate from one to the next
  std::vector<std::string> objects;                ///< that are trained on, by name
  std::vector<std::vector<std::string>> held_out;  ///< objects held out together, by name; empty if there are none to hold out
  std::vector<HeldOutSplit> splits;                ///< drawn at random
  std::vector<std::string> remarks;                ///< sentences on runs that are not as requested

  bool has_choice() const { return !trainings.front().choice.runs.empty(); }
};

/// Second stage of a study: divides the runs, and selects the objects to hold out.
/// @param options  as `completed` returns them
/// @param warn     receives each remark, and a sentence if runs have no samples
/// @throws Error   if held-out objects have no training run or none would be left, splits are requested and nothing can be held
///                 out, an object has no samples and `options.strict` is set, or as `divide_runs`
StudyPlan plan_study(const StudyOptions& options, const windows::Dataset& dataset, const WarningCallback& warn);

/// A model that the study trains.
struct StudyModel {
  std::size_t training = 0;  ///< which of `StudyPlan::trainings`
  model::ModelSettings settings;
  model::ModelBundle bundle;
  std::vector<std::uint32_t> runs;  ///< of the dataset, whose samples it is judged on

  std::string name() const { return bundle.name(); }
};

/// @param held_out  objects left out of training; it is judged on their test runs only. Empty: on all test runs
StudyModel model_of(const StudyPlan& plan, microseconds history, std::size_t training,
                    const std::vector<std::string>& held_out = {});

/// `inputs` of a step that runs a model, with the engine. The default engine is not named, so that older steps are kept.
nlohmann::json with_engine(nlohmann::json inputs, model::EngineKind engine);

}  // namespace tactile::study
