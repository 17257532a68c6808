#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

namespace tactile::review {

/// The model bundles in a folder, by name: [{"name", "kind", "settings", "trained": {"when", "dataset", "runs"}, "parameters",
/// "eval", "history", "error"}]. "parameters" is null but of a network. "settings" has those that differ from the default, by
/// their paths; "eval" is null where the model is not evaluated, else {"accuracy", "press_delay_ms", "slip_delay_ms", "missed":
/// {"press", "slip"}, "false_alarms_per_min"} as figures, those that `tactile eval` prints; "history" is a training's course,
/// epoch by epoch. A bundle that cannot be read has an "error", and its name.
nlohmann::json models_json(const std::filesystem::path& models);

/// A figure as the page gets it: {"value", "low", "high"}; what is not known is null.
nlohmann::json figure_json(double value, const std::optional<double>& low, const std::optional<double>& high);

}  // namespace tactile::review
