#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "tactile/core/time.hpp"

namespace tactile::model {

/// When the network is skipped because the skin is quiet: below a ratio that compares with the background, or, for older bundles,
/// with fewer than `limit` events in t_h. The verdict is then none.
struct Gate {
  std::uint64_t limit = 0;  ///< events in [t_c - t_h, t_c)
  double share = 0;         ///< the largest share of ticks below the limit, in the calibration
  std::uint64_t ticks = 0;  ///< of press and slip in the calibration

  /// The largest value of `BackgroundRatio` in the first 10 ms of each labelled interval of the training runs, ascending; at most
  /// 1000, the smallest. Older bundles have none.
  std::vector<double> ratios{};
  std::uint64_t intervals = 0;  ///< in the calibration

  friend bool operator==(const Gate&, const Gate&) = default;
};

void to_json(nlohmann::json& json, const Gate& gate);
void from_json(const nlohmann::json& json, Gate& gate);  ///< @throws Error

inline constexpr double gate_share = 1e-3;

/// The rule by which a tick is skipped.
struct GateRule {
  std::uint64_t events = 0;       ///< least number of events in t_h for which the network runs
  std::optional<double> ratio{};  ///< instead: the least value of `BackgroundRatio`

  bool closes(std::uint64_t events_in_history, double ratio_now) const {
    return ratio ? ratio_now < *ratio : events_in_history < events;
  }
  friend bool operator==(const GateRule&, const GateRule&) = default;
};

inline constexpr microseconds gate_step{2000};  ///< of `BackgroundRatio`

/// The least ratio at which Poisson noise leaves the gate closed for 98 % of the quiet ticks:
///
///   ln(steps in t_h / 0.02)     6.9 at t_h = 40 ms
///
/// With the known background, the likelihood ratio exp(ratio) of a step has the mean 1. So it is e^limit or more in at most
/// e^-limit of the steps (Markov), and each opens the gate for t_h. For 90 % real noise may exceed it five times as often.
/// @param history  t_h, > 0
double quiet_limit(microseconds history);

/// The rule that misses this share of the intervals. Of n ratios of the calibration in ascending order, the one with index
/// floor(miss * n) is the least that opens. If this index is 0, n intervals are too few to know such a share, and the smallest of
/// them is not it: by chance the next interval has a smaller ratio in 1 of n + 1 cases. Then the limit is `quiet_limit`: no
/// smaller one is sure to close in quiet. @throws Error  unless 0 <= miss < 1
GateRule rule_of(const Gate& gate, microseconds history, double miss = gate_share);

/// The largest limit that gives at most this share of presses and slips the verdict none: of n counts in ascending order the one
/// with index floor(share * n). 0, which never skips the network, if there are no counts.
/// @param counts  events in t_h at ticks of presses and slips
/// @param share   in [0, 1)
Gate calibrated_gate(const std::vector<std::uint64_t>& counts, double share = gate_share);

}  // namespace tactile::model
