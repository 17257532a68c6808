#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tactile/experiments/step_runner.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/model/definition/model_settings.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::experiments {

/// Where trainings read their data and write their models.
struct TrainingPlaces {
  std::filesystem::path data, models;
  std::string models_from_study;  ///< the same folder of models, relative to the folder of the steps
};

/// "tactile train …", each word quoted for a shell.
std::string command_of(const std::vector<std::string>& words);

/// A training by a process of `tactile train` with one thread. An interrupted training resumes. A model of the same name that no
/// such step made is never replaced.
/// @param settings  as `tactile train` makes them from --th, --seed, --epochs, --train-run, the split and the rendering
/// @param dataset   must outlive the step
Step training_step(const windows::Dataset& dataset, const model::ModelSettings& settings, const model::ModelBundle& bundle,
                   const TrainingPlaces& places);

}  // namespace tactile::experiments
