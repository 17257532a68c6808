#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/evaluation/accuracy.hpp"
#include "tactile/evaluation/confidence_interval.hpp"

namespace tactile {

enum class Verdict : std::uint8_t { holds, does_not, cannot_tell };

std::string_view name_of(Verdict verdict);  ///< "holds", "does not", "cannot tell"

/// Whether a figure lies below or above a limit: said only where its whole 95 % interval lies on one side. A bound that is not
/// known is on no side; the limit itself is neither below nor above.
Verdict below(const Figure& figure, double limit);
Verdict above(const Figure& figure, double limit);

/// The largest (smallest) of several objects' figures, and its interval: the largest (smallest) of the lows and of the highs. Its
/// high (low) is unknown if that of any object is; the other bound needs only one. n = objects.
Figure largest_of(const std::map<std::string, Figure>& objects);
Figure smallest_of(const std::map<std::string, Figure>& objects);

/// How the touches of one class were met in one object's runs.
struct ObjectDelays {
  Figure mean_ms;  ///< over detected ones
  std::uint64_t intervals = 0, misses = 0, early = 0;
};

/// What a study measured on one set of runs. What was not measured is empty, and its claims cannot be told.
struct ClaimInputs {
  std::map<microseconds, std::vector<RunConfusion>> histories;  ///< balanced samples by history t_h, the same runs in each
  std::map<std::string, ObjectDelays> press, slip;              ///< delays of the history chosen
  double tick_ms = 2;                                           ///< the shortest delay that there can be, > 0
  Figure first, last_minus_first;  ///< share of ticks said right: within 500 ms of the onset, and near the end less that
  std::vector<RunConfusion> seen, held_out;  ///< balanced samples of objects held out of training, the same runs in both
};

enum class Asked : std::uint8_t { below, above };

/// One of the paper's claims beside what was measured of it.
struct Claim {
  std::string id;     ///< "history-2-worst"
  std::string claim;  ///< in words, with what it is measured by
  std::string paper;  ///< what the paper says
  std::string unit;   ///< of `measured`, `limit` and `objects`: "%", "points" (of percent), "ms", "objects"
  Asked asked = Asked::below;
  double limit = 0;
  Figure measured;
  std::map<std::string, Figure> objects;  ///< where the claim is about each object
  Verdict verdict = Verdict::cannot_tell;
  std::string note;  ///< what there is to be said, such as intervals missed; may be empty
};

/// {"id", "claim", "paper", "unit", "asked", "limit", "measured", "objects", "verdict", "note"}
void to_json(nlohmann::json& json, const Claim& claim);

/// The claims of the paper's section V, always the same ones in the same order.
///
/// - history-2-worst: the accuracy at 2 ms less the lowest at any other history, the largest over objects, is below 0.
/// - best-history-40: of more objects 40 ms is the best than any other history: the difference is above 0.
/// - marginal-past-20: the highest mean accuracy past 20 ms less that at 20 ms is below 1 point.
/// - accuracy-at-40: the lowest object's accuracy at 40 ms is above 95 %.
/// - press-delay, slip-delay: the largest object's mean delay is below 5 ms; cannot be told to hold where one was missed or
/// early.
/// - slip-at-once: of more than half of the objects every slip was told at its first tick.
/// - right-at-first: within 500 ms of an onset more than 95 % of the ticks are said right.
/// - worse-near-the-end: near an interval's end fewer are than that.
/// - unseen-near-seen: held-out objects but plastic-container lose less than 5 points, on average over them.
/// - unseen-plastic-container: that one loses more than 5 points.
///
/// The paper says "highly accurate" and "comparable": 95 % is its own other figure, 5 points are ours.
/// @throws Error  if the histories, or seen and held out, are not of the same runs
/// Source: Faris et al., arXiv:2403.10120, section V.
std::vector<Claim> claims_of(const ClaimInputs& inputs, const BootstrapOptions& options = {});

/// "On simulated runs 3 of the paper's 11 claims hold, 2 do not, and of 6 one cannot tell."
std::string summary_of(const std::vector<Claim>& claims, bool simulated);

}  // namespace tactile
