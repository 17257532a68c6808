#include "tactile/model/training/dataset_bundle.hpp"

#include <string>

#include "tactile/core/error.hpp"

namespace tactile::model {
namespace {

/// Whether it has these settings, but another dataset.
bool is_of_another_dataset(const ModelBundle& bundle, const windows::Dataset& dataset, const ModelSettings& settings) {
  try {
    const ModelDescription description = read_description(bundle);
    return same_settings(description.settings, settings) && description.manifest_hash != dataset.manifest_hash();
  } catch (const Error&) {
    return false;  // missing or damaged
  }
}

}  // namespace

BundleState state_of(const ModelBundle& bundle, const windows::Dataset& dataset, const ModelSettings& settings) {
  if (!std::filesystem::exists(bundle.folder)) return BundleState::missing;
  try {
    const ModelDescription description = read_description(bundle);
    read_bundle_weights(bundle, description);
    const bool same = description.manifest_hash == dataset.manifest_hash() && same_settings(description.settings, settings);
    return same ? BundleState::unchanged : BundleState::changed;
  } catch (const Error&) {
    return BundleState::changed;
  }
}

ModelBundle bundle_for(const std::filesystem::path& models, const windows::Dataset& dataset, const ModelSettings& settings) {
  const std::string name = default_name(settings);
  ModelBundle bundle{models / name};
  for (unsigned number = 2; is_of_another_dataset(bundle, dataset, settings); ++number)
    bundle.folder = models / (name + "-" + std::to_string(number));
  return bundle;
}

}  // namespace tactile::model
