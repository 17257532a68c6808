#pragma once

#include <string>

#include "tactile/evaluation/evaluation.hpp"

namespace tactile {

// What an evaluation found, as tables for people.

std::string text_of(const Evaluation& evaluation);
std::string text_of(const UnseenComparison& comparison, bool simulated);

}  // namespace tactile
