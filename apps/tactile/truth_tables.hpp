#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "labelled_run.hpp"

namespace tactile {

/// Errors of labels over all simulated runs, and over groups of them that differ in what their labels can be taken from.
struct TruthTables {
  nlohmann::json json;
  std::string text;
};

/// @throws Error  if none of the runs has a truth.json
TruthTables compare_all(const std::vector<LabelledRun>& runs);

}  // namespace tactile
