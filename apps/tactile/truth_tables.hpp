#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "labelled_run.hpp"

namespace tactile::cli {

/// Errors of labels over all simulated runs, and over groups of them with different sources for labels.
struct TruthTables {  // NOLINT(bugprone-exception-escape): moving nlohmann::json does not throw
  nlohmann::json json;
  std::string text;
  std::vector<std::string> errors;  ///< why runs could not be compared, a sentence each
};

/// @throws Error  if none of the runs has a truth.json that can be read
TruthTables compare_all(const std::vector<LabelledRun>& runs);

}  // namespace tactile::cli
