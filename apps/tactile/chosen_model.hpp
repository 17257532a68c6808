#pragma once

#include <string>

#include "tactile/model/bundle/model_bundle.hpp"

namespace tactile::cli {

/// The model that `--model` names: a folder, or a name in the folder `models`.
model::ModelBundle named_model(const std::string& model, const std::string& models);

/// That model; if `model` is empty, the pinned one (`tactile models pin`), else the newest single-run model in `models`, else the
/// newest model: a study trains the models with held-out objects last.
/// @throws Error  if there is none
model::ModelBundle chosen_model(const std::string& model, const std::string& models);

/// Why a command without --model takes this one: "pinned", or "the newest".
std::string why_chosen(const model::ModelBundle& chosen, const std::string& models);

}  // namespace tactile::cli
