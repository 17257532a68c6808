#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "command.hpp"
#include "model_arguments.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::cli {

struct EvalArguments {
  std::string data = "data";
  std::string models = "models", model;
  bool unseen = false, no_train = false, strict = false, verbose = false;
  DecisionArguments decision{.thresholds = "by-kind"};
  std::optional<unsigned> trainings;  ///< of --unseen; their usual number if not given
  model::EngineKind engine = model::EngineKind::fast;
  std::string onset = "first";
  std::vector<std::string> held_out;  ///< of --unseen; empty: those of the paper's five objects that the dataset has
  std::vector<std::string> runs;      ///< to show over time, instead of the evaluation
  std::string out;
  bool camera_time = false;
};

/// The command that trains a model with these settings.
std::string train_command(const EvalArguments& args, const model::ModelSettings& settings);

/// The model of `--model`. @throws Error  if it is not there or not finished
model::ModelBundle bundle_named(const EvalArguments& args);

/// The same settings with another split. @param held_out  for the split unseen
model::ModelSettings with_split(model::ModelSettings settings, windows::SplitKind kind, const std::vector<std::string>& held_out);

/// The settings of a further training: it learns from the run that is `training` runs later, and its seed is greater by
/// `training`.
model::ModelSettings with_training(model::ModelSettings settings, const windows::Dataset& dataset, unsigned training);

/// The model with the same settings and the other split. Trains it if it is missing.
/// @param exactly  false: if the user named no objects, a model with other held-out objects is accepted
model::ModelBundle partner_of(const EvalArguments& args, const CommonArguments& common, const windows::Dataset& dataset,
                              const model::ModelSettings& settings, bool exactly = false);

}  // namespace tactile::cli
