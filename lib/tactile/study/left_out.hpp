#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile {

/// A run, or one interval of it, that a study neither learns from nor judges by.
struct LeftOut {
  std::string run;     ///< "fan/03"
  std::string what;    ///< "run", or an interval's id: "press-1"
  std::string reason;  ///< in words
};

/// {"run", "what", "reason"}
void to_json(nlohmann::json& json, const LeftOut& left_out);

/// What of the runs found is not in the dataset's samples, and why: runs that are not in it or give no samples, and intervals
/// that are flagged. In the order of the runs.
/// @throws Error  if labels cannot be read
std::vector<LeftOut> left_out_of(const Dataset& dataset, std::span<const RunFolder> runs);

}  // namespace tactile
