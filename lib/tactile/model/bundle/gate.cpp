#include "tactile/model/bundle/gate.hpp"

#include <algorithm>
#include <cmath>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/robust_statistics.hpp"

namespace tactile::model {

void to_json(nlohmann::json& json, const Gate& gate) {
  json = {{"limit_events", gate.limit},
          {"share", gate.share},
          {"ticks", gate.ticks},
          {"ratios", gate.ratios},
          {"intervals", gate.intervals}};
}

void from_json(const nlohmann::json& json, Gate& gate) {
  const std::string where = "gate";
  gate.limit = member<std::uint64_t>(json, "limit_events", where);
  gate.share = member<double>(json, "share", where);
  gate.ticks = member<std::uint64_t>(json, "ticks", where);
  if (!json.contains("ratios")) return;
  gate.ratios = member<std::vector<double>>(json, "ratios", where);
  gate.intervals = member<std::uint64_t>(json, "intervals", where);
  const bool is_sound = std::is_sorted(gate.ratios.begin(), gate.ratios.end()) && gate.ratios.size() <= gate.intervals &&
                        std::all_of(gate.ratios.begin(), gate.ratios.end(), [](double ratio) { return std::isfinite(ratio); });
  if (!is_sound)
    throw Error(where + ": its ratios cannot be used; expected finite ratios in ascending order, at most one per interval");
}

Gate calibrated_gate(const std::vector<std::uint64_t>& counts, double share) {
  if (!(share >= 0 && share < 1)) throw Error("gate: a share of " + std::to_string(share) + "; expected 0 to below 1");
  Gate gate{.limit = 0, .share = share, .ticks = counts.size()};
  if (counts.empty()) return gate;
  const auto index = static_cast<std::size_t>(std::floor(share * static_cast<double>(counts.size())));
  gate.limit = value_of_rank<std::uint64_t>(counts, index);
  return gate;
}

double quiet_limit(microseconds history) {
  constexpr double open_share = 0.02;
  const auto steps = std::max<std::int64_t>(1, (history.count() + gate_step.count() - 1) / gate_step.count());
  return std::log(static_cast<double>(steps) / open_share);
}

GateRule rule_of(const Gate& gate, microseconds history, double miss) {
  if (!(miss >= 0 && miss < 1)) throw Error("gate: misses of " + std::to_string(miss) + "; expected 0 to below 1");
  GateRule rule{.events = gate.limit};
  if (gate.ratios.empty()) return rule;
  const auto index = static_cast<std::size_t>(std::floor(miss * static_cast<double>(gate.intervals)));
  rule.ratio = index == 0 ? quiet_limit(history) : gate.ratios[std::min(index, gate.ratios.size() - 1)];
  return rule;
}

}  // namespace tactile::model
