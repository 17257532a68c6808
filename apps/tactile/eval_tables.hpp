#pragma once

#include <string>

#include "tactile/evaluation/evaluation.hpp"

namespace tactile::cli {

// The results of an evaluation as tables.

std::string text_of(const results::Evaluation& evaluation);
std::string text_of(const results::UnseenComparison& comparison, bool simulated);

}  // namespace tactile::cli
