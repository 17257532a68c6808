#pragma once

#include <optional>
#include <vector>

#include "tactile/labels/labels.hpp"
#include "tactile/simulation/truth.hpp"

namespace tactile {

/// How far something labelled is from the truth, and what the label says of its uncertainty.
struct Deviation {
  microseconds error{0};  ///< labelled - true
  bool covered = false;   ///< the 95 % interval holds the truth, its ends included
  microseconds width{0};  ///< of that interval

  friend bool operator==(const Deviation&, const Deviation&) = default;
};

/// One true interval beside the label that was found for it.
struct IntervalComparison {
  Touch touch = Touch::none;
  CameraTime true_start{};
  std::optional<Deviation> start, end;   ///< nothing if it was not found
  std::optional<Deviation> first_event;  ///< of the labelled onset from the first event that the motion caused
  bool flagged = false;                  ///< a flag stands on the label, or on the run
};

/// A label that no true interval of its class overlaps.
struct SpuriousLabel {
  TouchInterval interval;
  bool flagged = false;
};

struct TruthComparison {
  std::vector<IntervalComparison> intervals;  ///< of the true, labelled ones, by start
  std::vector<SpuriousLabel> spurious;        ///< by start
  bool flagged = false;                       ///< a flag stands, whatever it is on
  /// Of the clock's offset at the lift's start, else at the first true interval's: where the fitted clock puts that moment, less
  /// where it is. The interval is that of the offset.
  std::optional<Deviation> robot_clock, video_clock;
  bool robot_clock_sought = false;  ///< the truth knows the clock, whether or not the labels have it
  bool video_clock_sought = false;
  bool clocks_flagged = false;  ///< a flag stands on the run
};

/// Pairs each true interval with the label of its class that overlaps it most.
TruthComparison compare_with_truth(const Labels& labels, const Truth& truth);

}  // namespace tactile
