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
  double on = 2.5;            ///< log-odds from which a class is reported
  double off = -1.5;          ///< log-odds below which it ends, <= on
  microseconds hold{20'000};  ///< how long they must stay below before it ends, >= 0
  double confirmed = 3.5;     ///< log-odds of slip from which it is confirmed, >= on

  friend bool operator==(const TwoThresholds&, const TwoThresholds&) = default;
};

/// "2.5:-1.5:20:3.5" (on, off, hold in ms, confirmed) as {2.5, -1.5, 20 ms, 3.5}. Without the fourth number it is the usual one,
/// or `on` if that is higher.
/// @throws Error  unless they are finite numbers with off <= on <= confirmed and a hold from 0 to 10 000 ms
TwoThresholds two_thresholds_in(std::string_view text);

std::string text_of(const TwoThresholds& thresholds);  ///< "2.5:-1.5:20:3.5"

/// The same distance and hold with another `on`; what confirms a slip is at least that.
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
/// A firm lift and a slip begin alike. So there are two answers: slip is reported at once, and *confirmed* at the first tick of
/// its episode with l_slip >= confirmed, until the episode ends. Few firm lifts are confirmed.
///
/// The defaults are ours: chosen on simulated runs that no figure is reported of. A hold that is no whole number of ticks counts
/// as the next larger one; 0 as one tick. Allocates no memory.
class ThresholdDecision {
 public:
  /// @throws Error  if the tick or a setting is out of its range
  ThresholdDecision(const TwoThresholds& settings, microseconds tick);

  Touch next(const Probabilities& probabilities);        ///< the verdict at the next tick
  bool confirms_slip() const { return confirms_slip_; }  ///< whether it is a confirmed slip
  void skip(std::uint64_t ticks);                        ///< this many ticks count as below `off`
  void restart();                                        ///< the next tick begins in none

 private:
  TwoThresholds settings_;
  std::uint64_t hold_ticks_;
  Touch reported_ = Touch::none;
  bool confirms_slip_ = false;
  std::uint64_t below_ = 0;  ///< ticks in a row
};

}  // namespace tactile::model
