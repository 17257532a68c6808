#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tactile/results/json_view.hpp"

namespace tactile::results {

/// What is kept of a step of an experiment that is done.
struct StepRecord {
  std::string name;
  std::string command;      ///< that does the same; empty where there is none
  double seconds = 0;       ///< duration, whenever it was done; NaN if it is not known
  std::string finished_at;  ///< UTC
};

/// {"name", "command", "seconds", "finished_at"}; "command" is null where there is none.
void to_json(nlohmann::json& json, const StepRecord& step);
void from_json(const JsonView& json, StepRecord& step);

}  // namespace tactile::results
