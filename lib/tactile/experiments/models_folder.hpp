#pragma once

#include <filesystem>
#include <string>

#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/model/definition/model_settings.hpp"

namespace tactile::experiments {

/// The folder of an experiment's models: `named`, if it is not empty; else the one that trainings in `out/steps` used before, so
/// that an experiment resumes which began when models had another usual place; else `out/models`.
std::filesystem::path models_folder(const std::filesystem::path& named, const std::filesystem::path& out);

/// The bundle of an experiment's training: the folder `name` in `models`. If a model of other settings or of another dataset has
/// that name, and no step in `out/steps` made it, it stays as it is, and the bundle is `name-2`, `name-3`, …
model::ModelBundle training_bundle(const std::filesystem::path& models, const std::filesystem::path& out,
                                   const model::ModelSettings& settings, const std::string& manifest_hash);

}  // namespace tactile::experiments
