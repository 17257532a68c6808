#pragma once

#include <filesystem>

#include "tactile/model/inference/classifier.hpp"

namespace tactile::model {

/// Opens a model bundle of any kind with either engine. Their verdicts are the same unless the logits are `is_close`.
/// @param threads  0: one per core
/// @param options  of the fast engine
/// @throws Error   as Classifier
Classifier open_classifier(const std::filesystem::path& bundle, unsigned threads, EngineKind engine,
                           const EngineOptions& options = {});

}  // namespace tactile::model
