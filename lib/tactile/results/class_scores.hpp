#pragma once

#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "tactile/core/touch.hpp"
#include "tactile/results/figure.hpp"

namespace tactile::results {

/// How well one class is separated from the others:
///
///   precision = right / predicted;   recall = right / true;   f1 = 2 right / (predicted + true)
///
/// all in [0, 1]; a precision where the class is never predicted, and a recall where it never occurs, are nothing.
struct ClassScore {
  Figure precision, recall, f1;
};

/// Of each class, by the value of Touch.
struct ClassScores {
  std::array<ClassScore, touch_count> all;  ///< of the samples of all runs together; objects drawn first, then runs
  std::map<std::string, std::array<ClassScore, touch_count>> objects;  ///< runs drawn
};

/// {"press": {"precision", "recall", "f1", "objects": {"fan": {"precision", "recall", "f1"}}}}
void to_json(nlohmann::json& json, const ClassScores& scores);
void from_json(const JsonView& json, ClassScores& scores);

}  // namespace tactile::results
