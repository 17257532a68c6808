#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::study {

/// A run, or one interval of it, that a study uses neither to train nor to judge.
struct LeftOut {
  std::string run;     ///< "fan/03"
  std::string what;    ///< "run", or an interval's id: "press-1"
  std::string reason;  ///< in words
};

/// {"run", "what", "reason"}
void to_json(nlohmann::json& json, const LeftOut& left_out);

/// The runs that give the dataset no samples, and the flagged intervals of the others, with the reasons; in the order of the
/// runs.
/// @throws Error  if labels cannot be read
std::vector<LeftOut> left_out_of(const windows::Dataset& dataset, std::span<const RunFolder> runs);

}  // namespace tactile::study
