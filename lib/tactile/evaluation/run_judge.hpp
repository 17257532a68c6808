#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/ticks.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/evaluation/detection_delay.hpp"
#include "tactile/evaluation/run_truth.hpp"
#include "tactile/model/inference/logits.hpp"
#include "tactile/model/inference/two_thresholds.hpp"
#include "tactile/results/cell.hpp"

namespace tactile::evaluation {

/// A maximal row of ticks with one verdict other than none.
struct Episode {
  Touch touch = Touch::none;
  std::int64_t first = 0, last = 0;  ///< indexes of ticks
};

std::vector<Episode> episodes_in(std::span<const Touch> verdicts);

/// What happened in a run, as far as a detector is judged by it.
struct Course {
  struct Motion {
    TouchInterval interval;
    std::string cause;
  };

  bool by_truth = false;
  std::vector<TouchInterval> touches;             ///< to be detected, by onset
  std::vector<std::optional<CameraTime>> gross;   ///< of each touch: when object and tip first move against each other
  std::vector<TouchInterval> in_doubt;            ///< touches that are not judged: their labels are flagged
  std::vector<Motion> motions;                    ///< that are no touch and cause events
  std::optional<CameraTime> lift_without_slip{};  ///< when the arm begins to lift, in a run whose lift does not slip
};

/// By the truth of a simulated run, which knows all motion; else by the labels, which know touches and releases.
Course course_of(const RunTruth& truth);

/// By the labels, also where there is a truth.
Course course_by_labels(const RunTruth& truth);

/// Judges detectors on a run, whole.
///
/// **Delay, miss, early**: as `detections_of`, of all touches that are not in doubt.
///
/// **False alarm**: an episode whose first tick is in no touch, or that made a touch early. An episode that begins at most the
/// head start before an onset and lasts into it detects that touch, and is none. An episode counts again for each further 500 ms
/// outside of touches: a detector that stays on one class has few episodes, but is in alarm all the time. The time of touches in
/// doubt, and the head start before them, is left out: an episode that begins there counts only once it has lasted 500 ms outside
/// of touches.
///
/// **Cause** of a false alarm, by its first tick outside of touches: the motion that holds the tick, the one that began last of
/// several; else what ended last of the motions and touches that ended within 100 ms before it, a touch under the name "after an
/// end"; else "quiet".
///
/// **Wrong class**: an episode whose first tick is in a touch of the other class. One that detects the touch behind it by a head
/// start, or made it early, is none.
///
/// **False slips**: episodes of slip with a tick in the first 500 ms of a lift without slip.
///
/// **Right ticks**: the class of the touch, in its first 500 ms; of touches longer than 200 ms, in their last 200 ms and before.
class RunJudge {
 public:
  /// @param ticks  the run's full ticks
  RunJudge(const TickRange& ticks, const Course& course, const DelayOptions& options = {});

  /// @return  a cell without world, object, run, training, setting, threshold and samples
  /// @throws Error  if there is not one verdict for each tick
  results::Cell judged(std::span<const Touch> verdicts) const;

 private:
  enum class Place : std::uint8_t { outside, in_touch, in_doubt };

  bool is_outside(std::int64_t tick) const { return places_[static_cast<std::size_t>(tick)] == Place::outside; }
  std::string cause_at(CameraTime t) const;
  void add_right_ticks(results::Cell& cell, std::span<const Touch> verdicts) const;
  void add_alarms(results::Cell& cell, const Episode& episode, std::span<const results::Detection> detections) const;

  TickRange ticks_;
  Course course_;
  DelayOptions options_;
  std::vector<Place> places_;  ///< of each tick
};

/// The log-odds from which two thresholds report a touch, ascending, along the curve of delay against false alarms: from -4 to 16
/// in steps of a half. The other threshold keeps its distance.
std::span<const double> curve_thresholds();

/// The run judged by its verdicts, and at each of `curve_thresholds()`. With `thresholds`, also its confirmed slips: by them, and
/// confirmed from each of the curve's thresholds that are no lower than their `on`.
/// @param verdicts       as they were decided
/// @param probabilities  of each tick
/// @return               the cell of the verdicts first
std::vector<results::Cell> judged_along_curve(const RunJudge& judge, microseconds tick, std::span<const Touch> verdicts,
                                              std::span<const model::Probabilities> probabilities,
                                              const std::optional<model::TwoThresholds>& thresholds = {});

}  // namespace tactile::evaluation
