#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace tactile::review {

/// The studies, trades and stresses in the folders of `folder`, and `folder` itself where it is one: [{"name", "kind": "study",
/// "trade" or "stress", "title", "when", "figures": [{"label", "value", "low", "high", "unit"}], "claims": [{"claim", "outcome",
/// "in_words"}], "remarks", "error"}]. One that cannot be read has an "error", and its name.
nlohmann::json studies_json(const std::filesystem::path& folder);

}  // namespace tactile::review
