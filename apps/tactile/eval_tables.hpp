#pragma once

#include <string>

#include "tactile/evaluation/evaluation.hpp"

namespace tactile {

// The results of an evaluation as tables.

std::string text_of(const Evaluation& evaluation);
std::string text_of(const UnseenComparison& comparison, bool simulated);

}  // namespace tactile
