#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

namespace tactile::model {

/// Skips the network while the skin is quiet: with fewer than `limit` events in t_h the verdict is none.
struct Gate {
  std::uint64_t limit = 0;  ///< events in [t_c - t_h, t_c)
  double share = 0;         ///< the largest share of ticks below the limit, in the calibration
  std::uint64_t ticks = 0;  ///< of press and slip in the calibration

  friend bool operator==(const Gate&, const Gate&) = default;
};

void to_json(nlohmann::json& json, const Gate& gate);
void from_json(const nlohmann::json& json, Gate& gate);  ///< @throws Error

inline constexpr double gate_share = 1e-3;

/// The largest limit that gives at most this share of presses and slips the verdict none: of n counts in ascending order the one
/// with index floor(share * n). 0, which never skips the network, if there are no counts.
/// @param counts  events in t_h at ticks of presses and slips
/// @param share   in [0, 1)
Gate calibrated_gate(const std::vector<std::uint64_t>& counts, double share = gate_share);

}  // namespace tactile::model
