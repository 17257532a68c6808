#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/model/definition/model_settings.hpp"
#include "tactile/study/step_runner.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile {

/// Where trainings take their data from and put their models.
struct TrainingPlaces {
  std::filesystem::path data, models;
  std::string models_from_study;  ///< the same folder of models, counted from that of the steps
};

/// "tactile train …", each word as a shell reads it.
std::string command_of(const std::vector<std::string>& words);

/// A training by a process of `tactile train` with one thread, gone on with where it was broken off. A model of the same name
/// that no such step made is never replaced.
/// @param settings  a training's as `tactile train` makes them of --th, --seed, --epochs, --train-run, the split and the
/// rendering
/// @param dataset   must outlive the step
Step training_step(const Dataset& dataset, const ModelSettings& settings, const ModelBundle& bundle,
                   const TrainingPlaces& places);

}  // namespace tactile
