#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tactile/experiments/step_runner.hpp"
#include "tactile/experiments/study/study_options.hpp"

namespace tactile::study {

/// A world of a study, ready to be learned from.
struct PreparedWorld {
  World world;
  std::filesystem::path dataset;      ///< the file
  bool simulated = false;             ///< this study simulated the runs
  std::vector<std::string> errors{};  ///< a sentence for each object or run that could not be read or labelled
};

/// Whether the data folder holds runs that the study in `runner` did not begin to simulate.
bool has_own_runs(const StudyOptions& options, const experiments::StepRunner& runner);

/// First stage of a study: simulates the runs of a world if there are none, labels them, draws samples, and renders heatmaps for
/// each history.
/// @param options  as `completed` returns them
/// @param warn     receives a sentence for each misnamed folder, and one before a dataset with other settings is replaced
/// @throws Error   if there are runs and the options choose what to simulate, no run can be labelled, or a step fails
PreparedWorld prepare_world(const StudyOptions& options, const World& world, experiments::StepRunner& runner,
                            const WarningCallback& warn);

}  // namespace tactile::study
