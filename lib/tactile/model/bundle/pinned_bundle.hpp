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

/// The bundle in the folder `models` that `tactile train` made last, or found unchanged; the file `last` in it has its name.
/// Trainings of `eval --unseen` do not count: no user asked for one of them alone.
/// @return  nothing if no file has a name, or its bundle was removed
std::optional<ModelBundle> last_bundle(const std::filesystem::path& models);

/// Makes this bundle the last one of its folder. @throws Error  if the file cannot be written
void note_last_bundle(const ModelBundle& bundle);

}  // namespace tactile::model
