#pragma once

#include <nlohmann/json.hpp>
#include <span>

#include "tactile/experiments/study/judge_models.hpp"
#include "tactile/experiments/study/prepare_data.hpp"
#include "tactile/experiments/study/study_tables.hpp"
#include "tactile/results/step_record.hpp"

namespace tactile::study {

/// What a study writes.
struct StudyResults {
  nlohmann::json study;                ///< study.json; docs/format/ lists its keys
  std::vector<AccuracyRow> accuracy;   ///< accuracy.csv; points into the `TrainedModels` of the study
  std::vector<UnseenRow> unseen;       ///< unseen.csv
  std::vector<results::Claim> claims;  ///< claims.csv
};

/// Last stage of a study: all results, and what they show of the paper's claims.
StudyResults results_of(const StudyPlan& plan, const TrainedModels& trained, const JudgedModels& judged,
                        const PreparedData& prepared, std::span<const results::StepRecord> steps);

/// Writes the four files into the folder; those that would not change keep their modification time.
void write_results(const StudyResults& results, const std::filesystem::path& folder);

}  // namespace tactile::study
