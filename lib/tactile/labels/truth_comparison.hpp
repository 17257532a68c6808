#pragma once

#include <optional>
#include <vector>

#include "tactile/labels/labels.hpp"
#include "tactile/simulation/truth.hpp"

namespace tactile {

/// One true interval beside the label that was found for it.
struct IntervalComparison {
  Touch touch = Touch::none;
  std::optional<microseconds> start_error;  ///< labelled - true onset; nothing if it was not found
  std::optional<microseconds> end_error;
  std::optional<microseconds> first_event_error;  ///< labelled onset - first event that the motion caused
  bool covered = false;                           ///< the 95 % interval of the onset holds the true one
};

struct TruthComparison {
  std::vector<IntervalComparison> intervals;      ///< of the true, labelled ones, by start
  std::size_t spurious = 0;                       ///< labels that no true interval of their class overlaps
  std::optional<microseconds> robot_clock_error;  ///< of the lift's start, brought into camera time by the fitted clock
};

/// Pairs each true interval with the label of its class that overlaps it most.
TruthComparison compare_with_truth(const Labels& labels, const Truth& truth);

}  // namespace tactile
