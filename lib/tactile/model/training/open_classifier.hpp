#pragma once

#include <filesystem>

#include "tactile/model/inference/classifier.hpp"

namespace tactile::model {

/// Opens a model bundle of any kind with either engine. Their verdicts are the same unless the logits are `is_close`. A network
/// of one's own, NAME.pt or NAME.onnx, is run by libtorch or by OpenCV's dnn, whichever reads such a file.
/// @param threads  0: one per core
/// @param options  of the fast engine
/// @throws Error   as Classifier; of a network of one's own also if another engine or precision is asked for
Classifier open_classifier(const std::filesystem::path& bundle, unsigned threads, EngineKind engine,
                           const EngineOptions& options = {});

}  // namespace tactile::model
