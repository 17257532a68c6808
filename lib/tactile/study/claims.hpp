#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/evaluation/accuracy.hpp"
#include "tactile/evaluation/confidence_interval.hpp"
#include "tactile/evaluation/detection_delay.hpp"
#include "tactile/results/claim.hpp"
#include "tactile/results/over_time.hpp"

namespace tactile {

/// Whether a figure lies below or above a limit: said only where its whole interval lies on one side. A bound that is not known
/// is on no side, and neither is one at the limit itself.
Verdict below(const Figure& figure, double limit);
Verdict above(const Figure& figure, double limit);

/// Objects' figures, with two intervals for each.
struct ObjectFigures {
  std::map<std::string, Figure> objects;  ///< 95 %
  std::map<std::string, Figure> wide;     ///< so wide that all of them hold at once with 95 %: 1 - 0.05 / k for k objects
};

/// The largest (smallest) of several objects' figures, and its interval. High (low) is the largest (smallest) of the objects'
/// own, unknown if that of any object is: all of them must lie on the good side. Low (high) is the largest (smallest) of the wide
/// intervals: of many looks one may go wrong by chance alone. n = objects.
Figure largest_of(const ObjectFigures& figures);
Figure smallest_of(const ObjectFigures& figures);

/// What a study measured on one set of runs. What was not measured is empty, and its claims cannot be told.
struct ClaimInputs {
  std::map<microseconds, std::vector<RunConfusion>> histories;  ///< balanced samples by history t_h, the same runs in each
  std::vector<microseconds> untrained;       ///< of the paper's histories: without them none is the best of all
  std::vector<RunDetections> detections;     ///< of each run, by the history chosen
  double tick_ms = 2;                        ///< the shortest delay that there can be, > 0
  double history_ms = 40;                    ///< t_h, the one chosen
  ShareOverTime over_time;                   ///< of presses and slips, "first" 500 ms and "last" 200 ms
  double after_ms = 100;                     ///< "still_said" is of that time after an interval
  std::vector<RunConfusion> seen, held_out;  ///< balanced samples of objects held out of training, the same runs in both
};

inline constexpr std::size_t fewest_runs = 3, fewest_objects = 5;

/// The claims of the paper's section V, always the same ones in the same order.
///
/// - history-2-worst: the accuracy at 2 ms less the lowest at any other history, the largest over objects, is below 0.
/// - best-history-40: of more objects 40 ms is the best than any other history: the difference is above 0.
/// - marginal-past-20: the highest mean accuracy past 20 ms less that at 20 ms is below 1 point.
/// - accuracy-at-40: the lowest object's accuracy at 40 ms is above 95 %.
/// - press-delay, slip-delay: the largest object's mean delay is below 5 ms; cannot be told to hold where one was missed or
/// early.
/// - slip-at-once: of more than half of the objects every slip was told at its first tick; objects are drawn, then runs.
/// - right-at-first: within 500 ms of an onset more than 95 % of the ticks are said right.
/// - worse-near-the-end: in an interval's last 200 ms fewer are than ahead of them; what is still said behind it is noted.
/// - unseen-near-seen: each held-out object but plastic-container loses less than 5 points.
/// - unseen-plastic-container: that one loses more than 5 points.
///
/// The paper says "highly accurate" and "comparable": 95 % is its own other figure, 5 points are ours.
/// @throws Error  if the histories, or seen and held out, are not of the same runs
/// Source: Faris et al., arXiv:2403.10120, section V.
std::vector<Claim> claims_of(const ClaimInputs& inputs, const BootstrapOptions& options = {});

/// "On simulated runs 3 of the paper's 11 claims hold, 2 do not, and of 6 one cannot tell: for 4 there are too few runs or
/// objects for a verdict."
std::string summary_of(const std::vector<Claim>& claims, bool simulated);

}  // namespace tactile
