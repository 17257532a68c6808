#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tactile/experiments/study/prepare_data.hpp"
#include "tactile/experiments/study/study_options.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/model/definition/model_settings.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::study {

/// What one training of every setting learns from: one run of each object.
struct PlannedTraining {
  std::uint64_t seed = 0;
  std::string train_run;            ///< id of the run
  std::vector<std::uint32_t> test;  ///< runs with samples that it does not learn from
};

/// A world with its dataset.
struct StudiedWorld {
  PreparedWorld prepared;
  std::unique_ptr<const windows::Dataset> dataset;
  std::vector<PlannedTraining> trainings;  ///< at least one; the runs rotate from one to the next
  std::vector<std::string> held_out;       ///< objects held out together; empty where there are none to hold out
};

/// A model that the study trains, and what it is judged on.
struct StudyModel {
  std::size_t world = 0, training = 0;
  std::string setting{};  ///< "th040", "stream", "stream-unseen"
  model::ModelSettings settings{};
  model::ModelBundle bundle{};
  std::vector<std::uint32_t> runs{};  ///< of the dataset
  bool whole = false;                 ///< at every tick of whole runs, also of those without samples; else on its samples only

  std::string name() const { return bundle.name(); }
};

/// What a study does with its worlds.
struct StudyPlan {
  StudyOptions options;  ///< as `completed` returns them
  std::vector<StudiedWorld> worlds;
  std::vector<StudyModel> models;
  std::vector<std::string> remarks;  ///< sentences on runs that are not as requested

  const windows::Dataset& dataset(const StudyModel& model) const { return *worlds[model.world].dataset; }
};

/// "th040" of a history of 40 ms, "th002.5"; "-unseen" where objects are held out of training.
std::string setting_name(const model::ModelSettings& settings);

/// Second stage of a study: divides the runs, selects the objects to hold out, and lists the models: in each world and training a
/// LeNet of each history and a stream, and without the held-out objects a LeNet of the main history and a stream. Every second
/// world holds out the other objects, where the options name none.
/// @param options  as `completed` returns them
/// @param warn     receives each remark, and a sentence if runs have no samples
/// @throws Error   if held-out objects have no training run or none would be left, an object has no samples and `options.strict`
///                 is set, or as `divide_runs`
StudyPlan plan_study(const StudyOptions& options, std::vector<PreparedWorld> worlds, const WarningCallback& warn);

}  // namespace tactile::study
