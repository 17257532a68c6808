#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "tactile/core/time.hpp"
#include "tactile/model/inference/logits.hpp"

namespace tactile::model {

/// Settings of a decision by two thresholds with a hold.
struct TwoThresholds {
  double on = 1.4;            ///< log-odds from which a class is reported
  double off = -2.6;          ///< log-odds below which it ends, <= on
  microseconds hold{20'000};  ///< how long they must stay below before it ends, >= 0

  friend bool operator==(const TwoThresholds&, const TwoThresholds&) = default;
};

/// "1.4:-2.6:20" (on, off, hold in ms) as {1.4, -2.6, 20 ms}.
/// @throws Error  unless they are three finite numbers with off <= on and a hold from 0 to 10 000 ms
TwoThresholds two_thresholds_in(std::string_view text);

std::string text_of(const TwoThresholds& thresholds);  ///< "1.4:-2.6:20"

/// The same distance and hold with another `on`.
TwoThresholds moved_to(const TwoThresholds& thresholds, double on);

/// ln(p / (1 - p)) of a class; 1 - p is the sum of the others. In [-87, 88], also for a probability of 0 or 1.
double log_odds(const Probabilities& probabilities, Touch touch);

/// Decides by two thresholds with a hold on the log-odds of press and slip, whatever model they are of:
///
///   l_c = ln(p_c / (1 - p_c))
///   none to c:    at the first tick with l_c >= on; the likelier of press and slip
///   c to none:    once l_c < off at every tick of `hold`
///   c to other d: at the first tick with l_d >= on + (on - off)
///
/// The defaults are ours: chosen on simulated runs that no figure is reported of. A hold that is no whole number of ticks counts
/// as the next larger one; 0 as one tick. Allocates no memory.
class ThresholdDecision {
 public:
  /// @throws Error  if the tick or a setting is out of its range
  ThresholdDecision(const TwoThresholds& settings, microseconds tick);

  Touch next(const Probabilities& probabilities);  ///< the verdict at the next tick
  void skip(std::uint64_t ticks);                  ///< this many ticks count as below `off`
  void restart();                                  ///< the next tick begins in none

 private:
  TwoThresholds settings_;
  std::uint64_t hold_ticks_;
  Touch reported_ = Touch::none;
  std::uint64_t below_ = 0;  ///< ticks in a row
};

}  // namespace tactile::model
