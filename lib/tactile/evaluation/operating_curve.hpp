#pragma once

#include <span>
#include <vector>

#include "tactile/core/touch.hpp"
#include "tactile/evaluation/detection_delay.hpp"
#include "tactile/evaluation/false_alarms.hpp"
#include "tactile/model/inference/logits.hpp"
#include "tactile/results/operating_point.hpp"

namespace tactile::evaluation {

/// Thresholds from 0.01 to 0.9999, close together at both ends, where most probabilities are.
const std::vector<double>& default_thresholds();

/// The more probable of press and slip if its probability is at least `threshold`, else none; press if they are equal.
std::vector<Touch> verdicts_above(std::span<const model::Probabilities> probabilities, double threshold);

/// @param detections, alarms  at this threshold, one entry a run
results::OperatingPoint operating_point(double threshold, std::span<const results::RunDetections> detections,
                                        std::span<const RunFalseAlarms> alarms, const results::BootstrapOptions& options = {});

}  // namespace tactile::evaluation
