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
  std::vector<std::string> held_out;  ///< of --unseen; empty: those of the paper's five that there are
  std::vector<std::string> runs;      ///< to be shown over time; the rest is left undone then
  std::string out;
};

/// The `tactile train` that makes a model of these settings.
std::string train_command(const EvalArguments& args, const ModelSettings& settings);

/// That of `--model`: a folder, or a name below `--models`.
ModelBundle bundle_named(const EvalArguments& args);

/// The model of this dataset and kind of split that was trained last.
std::optional<ModelBundle> newest_of(const EvalArguments& args, const Dataset& dataset, SplitKind kind);

/// The same settings with another split. @param held_out  of unseen
ModelSettings with_split(ModelSettings settings, SplitKind kind, const std::vector<std::string>& held_out);

/// The model of the same settings that holds objects out, or does not; trained where it is missing.
ModelBundle partner_of(const EvalArguments& args, const CommonArguments& common, const Dataset& dataset,
                       const ModelSettings& settings);

}  // namespace tactile
