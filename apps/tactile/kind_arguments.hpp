#pragma once

#include <string>

#include "options.hpp"
#include "tactile/model/definition/model_settings.hpp"

namespace tactile::cli {

/// The kind of model to train, and the options of kind stream.
struct KindArguments {
  std::string kind = "lenet";
  model::StreamOptions stream;
};

/// `--kind` and `--steps`.
void add_kind_options(Command command, KindArguments& args);

/// @throws Error  that names the option, if one off its default has no meaning for the kind
void check_options_of_kind(const model::ModelSettings& settings, bool starts_from_a_model);

}  // namespace tactile::cli
