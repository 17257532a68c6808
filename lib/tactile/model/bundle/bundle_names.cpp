#include "tactile/model/bundle/bundle_names.hpp"

#include <system_error>

#include "tactile/core/folders_in.hpp"
#include "tactile/model/bundle/model_bundle.hpp"

namespace tactile::model {

std::vector<std::string> bundle_names(const std::filesystem::path& models) {
  std::vector<std::string> names;
  for (const std::filesystem::path& folder : folders_in(models)) {
    std::error_code unknown;
    if (std::filesystem::exists(ModelBundle{folder}.description(), unknown)) names.push_back(folder.filename().string());
  }
  return names;
}

}  // namespace tactile::model
