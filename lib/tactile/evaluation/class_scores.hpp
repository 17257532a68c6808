#pragma once

#include <span>

#include "tactile/evaluation/confidence_interval.hpp"
#include "tactile/results/class_scores.hpp"
#include "tactile/results/confusion.hpp"

namespace tactile {

ClassScores class_scores_of(std::span<const RunConfusion> runs, const BootstrapOptions& options = {});

}  // namespace tactile
