#pragma once

#include <filesystem>

#include "tactile/model/inference/classifier.hpp"

namespace tactile {

/// Opens a model bundle with either engine; verdicts of both are the same except where the logits are `is_close`.
/// @param threads  0: as many as the machine has cores
/// @param options  of the fast engine
/// @throws Error   as Classifier
Classifier open_classifier(const std::filesystem::path& bundle, unsigned threads, EngineKind engine,
                           const EngineOptions& options = {});

}  // namespace tactile
