#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tactile/experiments/step_runner.hpp"
#include "tactile/experiments/study/study_options.hpp"

namespace tactile::study {

/// The dataset of a study.
struct PreparedData {
  std::filesystem::path dataset;    ///< the file
  bool simulated = false;           ///< this study simulated the runs
  std::vector<std::string> errors;  ///< a sentence for each object or run that could not be read or labelled
};

/// First stage of a study: simulates runs if there are none, labels them, draws samples, and renders heatmaps for each history.
/// @param options  as `completed` returns them
/// @param warn     receives a sentence for each misnamed folder, and one before a dataset with other settings is replaced
/// @throws Error   if there are runs and the options choose what to simulate, no run can be labelled, or a step fails
PreparedData prepare_data(const StudyOptions& options, experiments::StepRunner& runner, const WarningCallback& warn);

}  // namespace tactile::study
