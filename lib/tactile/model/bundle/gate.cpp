#include "tactile/model/bundle/gate.hpp"

#include <cmath>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/robust_statistics.hpp"

namespace tactile::model {

void to_json(nlohmann::json& json, const Gate& gate) {
  json = {{"limit_events", gate.limit}, {"share", gate.share}, {"ticks", gate.ticks}};
}

void from_json(const nlohmann::json& json, Gate& gate) {
  const std::string where = "gate";
  gate.limit = member<std::uint64_t>(json, "limit_events", where);
  gate.share = member<double>(json, "share", where);
  gate.ticks = member<std::uint64_t>(json, "ticks", where);
}

Gate calibrated_gate(const std::vector<std::uint64_t>& counts, double share) {
  if (!(share >= 0 && share < 1)) throw Error("gate: a share of " + std::to_string(share) + "; expected 0 to below 1");
  Gate gate{.limit = 0, .share = share, .ticks = counts.size()};
  if (counts.empty()) return gate;
  const auto index = static_cast<std::size_t>(std::floor(share * static_cast<double>(counts.size())));
  gate.limit = value_of_rank<std::uint64_t>(counts, index);
  return gate;
}

}  // namespace tactile::model
