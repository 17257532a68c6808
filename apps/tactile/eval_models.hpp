#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "command.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile {

struct EvalArguments {
  std::string data = "data";
  std::string models = "models", model;
  bool unseen = false, no_train = false, strict = false;
  double guard_ms = -1;
  std::string confirm = "1/1";
  bool gate = false;
  std::string engine = "fast";
  std::vector<std::string> held_out;  ///< of --unseen; empty: those of the paper's five objects that the dataset has
  std::vector<std::string> runs;      ///< to show over time, instead of the evaluation
  std::string out;
};

/// The command that trains a model with these settings.
std::string train_command(const EvalArguments& args, const ModelSettings& settings);

/// The model of `--model`. @throws Error  if it is not there or not finished
ModelBundle bundle_named(const EvalArguments& args);

/// The newest model of this dataset with this kind of split.
std::optional<ModelBundle> newest_of(const EvalArguments& args, const Dataset& dataset, SplitKind kind);

/// The same settings with another split. @param held_out  for the split unseen
ModelSettings with_split(ModelSettings settings, SplitKind kind, const std::vector<std::string>& held_out);

/// The model with the same settings and the other split. Trains it if it is missing.
ModelBundle partner_of(const EvalArguments& args, const CommonArguments& common, const Dataset& dataset,
                       const ModelSettings& settings);

}  // namespace tactile
