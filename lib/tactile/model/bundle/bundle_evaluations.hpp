#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "tactile/model/bundle/model_bundle.hpp"

namespace tactile::model {

/// Where `tactile eval` with its usual options writes the results of a model.
/// @param learned_from  hash of the manifest of the dataset that the model learned from
/// @param judged_on     that of the dataset it is judged on
/// @return  `eval.json` if they are the same, else `eval-on-1a2b3c4d.json`, with the first digits of `judged_on`
std::filesystem::path evaluation_on(const ModelBundle& bundle, const std::string& learned_from, const std::string& judged_on);

/// The newest of these files that is of the dataset file which the model learned from, in whichever state; else the newest of
/// all.
/// @return  nothing if there is none
std::optional<std::filesystem::path> newest_evaluation(const ModelBundle& bundle);

}  // namespace tactile::model
