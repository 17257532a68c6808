#pragma once

#include <string>

#include "tactile/results/evaluation.hpp"

namespace tactile::cli {

// The results of every tick as tables.

std::string delays_text(const results::Evaluation& evaluation);  ///< all intervals first, then the paper's mean
std::string whole_runs_text(const results::Evaluation& evaluation);

}  // namespace tactile::cli
