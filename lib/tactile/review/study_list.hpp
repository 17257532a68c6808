#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace tactile::review {

/// The studies, trades, stresses and evaluations in the folders of `folder`, and `folder` itself where it is one; then the
/// newest evaluation of each model: [{"name", "kind": "study", "trade", "stress" or "eval", "title", "when", "figures":
/// [{"label", "value", "low", "high", "unit"}], "claims": [{"claim", "outcome", "in_words"}], "remarks", "error"}]. One that
/// cannot be read has an "error", and its name.
nlohmann::json studies_json(const std::filesystem::path& folder, const std::filesystem::path& models);

}  // namespace tactile::review
