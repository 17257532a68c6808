#pragma once

#include <span>

#include "tactile/evaluation/crossed_figure.hpp"
#include "tactile/results/class_scores.hpp"
#include "tactile/results/confusion.hpp"

namespace tactile::evaluation {

results::ClassScores class_scores_of(std::span<const results::RunConfusion> runs, const results::BootstrapOptions& options = {});

}  // namespace tactile::evaluation
