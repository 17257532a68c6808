#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/experiments/step_runner.hpp"
#include "tactile/experiments/stress/judge_runs.hpp"
#include "tactile/experiments/stress/plan_stress.hpp"

namespace tactile::stress {

/// What is judged: runs of the dataset by their labels or their truth, or quiet recordings.
enum class JudgedRuns : std::uint8_t { by_labels, by_truth, quiet };

/// A curve of a group's figures against severity.
struct PlannedCurve {
  const StressSeries* series = nullptr;
  JudgedRuns runs = JudgedRuns::by_labels;
};

/// One training on all of its runs, or on the quiet recordings, at one severity.
struct StressJudgement {
  const StressTraining* training = nullptr;
  const StressSeries* series = nullptr;  ///< null: unchanged
  double severity = 0;
  JudgedRuns runs = JudgedRuns::by_labels;
};

/// Whether a training of the group has a run to be judged on.
bool has_runs(const StressGroup& group);

/// The curves of a group: those of its runs, then those of the quiet recordings.
std::vector<PlannedCurve> curves_of(const StressPlan& plan, const StressGroup& group);

/// 0 for the unchanged runs, then those of the series.
std::vector<double> severities_of(const StressSeries& series);

/// One for each training of the group.
std::vector<StressJudgement> judgements_at(const StressGroup& group, const PlannedCurve& curve, double severity);

/// Of unchanged runs by their labels, one for each training of the group.
std::vector<StressJudgement> unchanged_runs(const StressGroup& group);

/// All judgements of a plan, each once: the unchanged runs begin every curve.
std::vector<StressJudgement> judgements_of(const StressPlan& plan);

/// The judgements of `judgements_of` as steps that can run side by side. The outcome of a step is its file. `plan` must outlive
/// the steps.
std::vector<experiments::Step> steps_of(const StressPlan& plan);

/// Does one step of a plan, as a task on a cluster. @throws Error  if the plan has no step of this name
void do_step(const StressPlan& plan, const std::string& name, const ProgressCallback& progress = {});

/// The cells of judgements whose steps are done. The training of a cell is its judgement's place in the list.
std::vector<results::Cell> cells_of(const StressPlan& plan, const std::vector<StressJudgement>& judgements);

}  // namespace tactile::stress
