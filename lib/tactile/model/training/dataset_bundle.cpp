#include "tactile/model/training/dataset_bundle.hpp"

#include <string>

#include "tactile/core/error.hpp"

namespace tactile::model {
namespace {

bool is_of(const ModelDescription& model, const windows::Dataset& dataset, const ModelSettings& settings) {
  return model.manifest_hash == dataset.manifest_hash() && same_settings(model.settings, settings);
}

}  // namespace

BundleState state_of(const ModelBundle& bundle, const windows::Dataset& dataset, const ModelSettings& settings) {
  if (!std::filesystem::exists(bundle.folder)) return BundleState::missing;
  try {
    const ModelDescription description = read_description(bundle);
    read_bundle_weights(bundle, description);
    return is_of(description, dataset, settings) ? BundleState::unchanged : BundleState::changed;
  } catch (const Error&) {
    return BundleState::changed;
  }
}

ModelBundle bundle_for(const std::filesystem::path& models, const windows::Dataset& dataset, const ModelSettings& settings) {
  return free_bundle(models, default_name(settings),
                     [&](const ModelBundle&, const ModelDescription& model) { return !is_of(model, dataset, settings); });
}

}  // namespace tactile::model
