#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "tactile/experiments/step_runner.hpp"
#include "tactile/experiments/study/study_options.hpp"
#include "tactile/results/study.hpp"

namespace tactile::study {

/// The outcome of a study.
struct StudySummary {
  results::Study study;  ///< study.json
  std::filesystem::path file;
  std::size_t done = 0;             ///< number of steps done now
  std::size_t kept = 0;             ///< number of steps found done
  std::vector<std::string> errors;  ///< a sentence for each object or run that could not be read or labelled; the study omits it
};

/// The paper's study, and the same of a stream, in several worlds. Simulates the runs of each world if there are none, labels
/// them, draws samples and renders heatmaps. Trains a LeNet of each history and a stream, and both without some objects. Judges
/// them, and makes all figures from one table of cells. Keeps all that is done and unchanged. An interrupted study resumes, with
/// the same results.
///
/// @param new_progress  called at the start of each step; returns the callback for its progress
/// @param on_step       see `StepCallback`
/// @param warn          see `WarningCallback`; called before a dataset with other settings is replaced, among others
/// @throws Error  if an option is out of its range, another study works in the same folder, or a step fails: the step's command
///                and what went wrong
StudySummary run_study(const StudyOptions& options, const experiments::NewProgress& new_progress = {},
                       const experiments::StepCallback& on_step = {}, const WarningCallback& warn = {});

}  // namespace tactile::study
