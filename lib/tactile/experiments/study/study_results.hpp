#pragma once

#include <filesystem>
#include <span>

#include "tactile/experiments/study/judge_models.hpp"
#include "tactile/experiments/study/prepare_data.hpp"
#include "tactile/results/study.hpp"

namespace tactile::study {

/// Last stage of a study: all results, and what they show of the paper's claims.
results::Study results_of(const StudyPlan& plan, const TrainedModels& trained, const JudgedModels& judged,
                          const PreparedData& prepared, std::span<const results::StepRecord> steps);

/// Writes study.json, accuracy.csv, unseen.csv and claims.csv into the folder; those that would not change keep their
/// modification time.
void write_results(const results::Study& study, const std::filesystem::path& folder);

}  // namespace tactile::study
