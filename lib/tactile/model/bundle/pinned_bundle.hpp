#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "tactile/model/bundle/model_bundle.hpp"

namespace tactile::model {

/// The bundle in the folder `models` that a person chose for all commands; the file `pinned` in it has its name.
/// @return  nothing if none is pinned
/// @throws Error  if the file names a bundle that is not there
std::optional<ModelBundle> pinned_bundle(const std::filesystem::path& models);

/// @throws Error  if there is no such bundle in `models`
void pin_bundle(const std::filesystem::path& models, const std::string& name);

/// @return  the name of the bundle that was pinned; empty if there was none
std::string unpin_bundle(const std::filesystem::path& models);

}  // namespace tactile::model
