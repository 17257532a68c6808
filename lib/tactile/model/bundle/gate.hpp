#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

namespace tactile {

/// When a skin is so quiet that the network need not be asked: with fewer than `limit` events in t_h the verdict is none.
struct Gate {
  std::uint64_t limit = 0;  ///< events in [t_c - t_h, t_c)
  double share = 0;         ///< of the ticks below that it was calibrated to, at the most
  std::uint64_t ticks = 0;  ///< of press and slip that it was calibrated on

  friend bool operator==(const Gate&, const Gate&) = default;
};

void to_json(nlohmann::json& json, const Gate& gate);
void from_json(const nlohmann::json& json, Gate& gate);  ///< @throws Error

inline constexpr double gate_share = 1e-3;

/// The largest limit by which at most this share of presses and slips is taken for none: of n counts in ascending order the one
/// with index floor(share * n), so that no more than that many lie below it. 0, which gates nothing, where there are none.
/// @param counts  events in t_h at ticks of presses and slips
/// @param share   in [0, 1)
Gate calibrated_gate(std::vector<std::uint64_t> counts, double share = gate_share);

}  // namespace tactile
