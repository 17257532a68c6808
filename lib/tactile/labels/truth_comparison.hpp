#pragma once

#include <optional>
#include <vector>

#include "tactile/core/truth.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile::labels {

/// The error of a label, and its own uncertainty.
struct Deviation {
  microseconds error{0};  ///< labelled - true
  bool covered = false;   ///< the 95 % interval holds the truth, its ends included
  microseconds width{0};  ///< of that interval

  friend bool operator==(const Deviation&, const Deviation&) = default;
};

/// One true interval, and the label that was found for it.
struct IntervalComparison {
  Touch touch = Touch::none;
  CameraTime true_start{};
  std::optional<Deviation> start, end;   ///< nothing if it was not found
  std::optional<Deviation> first_event;  ///< of the labelled onset against the first event that the motion caused
  bool flagged = false;                  ///< the label or the run has an unconfirmed flag
};

/// A label that no true interval of its class overlaps.
struct SpuriousLabel {
  TouchInterval interval;
  bool flagged = false;
};

struct TruthComparison {
  std::vector<IntervalComparison> intervals;  ///< of the true, labelled ones, by start
  std::vector<SpuriousLabel> spurious;        ///< by start
  bool flagged = false;                       ///< there is an unconfirmed flag
  /// The error of the clock at the lift's start, else at that of the first true interval. The interval is that of the offset.
  std::optional<Deviation> robot_clock, video_clock;
  bool robot_clock_sought = false;  ///< the truth knows the clock, whether or not the labels have it
  bool video_clock_sought = false;
  bool clocks_flagged = false;  ///< the run has an unconfirmed flag
};

/// Pairs each true interval with the label of its class that overlaps it most.
TruthComparison compare_with_truth(const Labels& labels, const Truth& truth);

}  // namespace tactile::labels
