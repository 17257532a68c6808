#pragma once

#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "tactile/core/touch.hpp"
#include "tactile/evaluation/accuracy.hpp"
#include "tactile/evaluation/confidence_interval.hpp"

namespace tactile {

/// How well one class is told from the others:
///
///   precision = right / said so;   recall = right / is so;   f1 = 2 right / (said so + is so)
///
/// all in [0, 1]; a precision where the class is never said, and a recall where it never is, are nothing.
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

ClassScores class_scores_of(std::span<const RunConfusion> runs, const BootstrapOptions& options = {});

}  // namespace tactile
