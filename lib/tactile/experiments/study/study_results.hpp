#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "tactile/experiments/study/plan_study.hpp"
#include "tactile/results/cell.hpp"
#include "tactile/results/step_record.hpp"
#include "tactile/results/study.hpp"

namespace tactile::study {

/// Last stage of a study: all figures, made from its cells. @throws Error  if a model or labels cannot be read
results::Study results_of(const StudyPlan& plan, std::span<const results::Cell> cells, std::vector<results::ReportedRun> runs,
                          std::vector<results::StepRecord> steps);

/// Writes study.json and the table of cells into the study's folder. @throws Error  if one cannot be written
void write_results(const results::Study& study, std::span<const results::Cell> cells, const std::filesystem::path& folder);

}  // namespace tactile::study
