#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace tactile::cli {

/// Logs a step that begins, or, at level debug, one that is kept: the `StepCallback` of reproduce and trade.
void log_step(const std::string& description, bool kept);

/// "97.31 [96.20, 98.10]", "-" without a value; an unknown bound is "?".
/// @param figure  {"value", "low", "high"}   @param factor  100 for percent
std::string figure_text(const nlohmann::json& figure, double factor, int decimals);

}  // namespace tactile::cli
