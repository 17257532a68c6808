#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tactile::model {

/// The names of the model bundles in the folder `models`, in order; none if there is no such folder.
std::vector<std::string> bundle_names(const std::filesystem::path& models);

}  // namespace tactile::model
