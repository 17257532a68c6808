#pragma once

#include <cstdint>
#include <filesystem>

#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::model {

enum class BundleState : std::uint8_t {
  missing,
  unchanged,  ///< made with these settings from this dataset, and intact
  changed,    ///< made with other settings or from another dataset, or damaged
};

/// Compares an existing bundle with what `train_model` would write.
BundleState state_of(const ModelBundle& bundle, const windows::Dataset& dataset, const ModelSettings& settings);

/// The bundle of these settings and this dataset below `models`, there or not: `free_bundle` of `default_name`. So a model stays
/// if its dataset grows, such as by the runs of this week, and the next one has a name that ends with -2.
ModelBundle bundle_for(const std::filesystem::path& models, const windows::Dataset& dataset, const ModelSettings& settings);

}  // namespace tactile::model
