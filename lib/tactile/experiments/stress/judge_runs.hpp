#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/evaluation/run_prediction.hpp"
#include "tactile/experiments/stress/plan_stress.hpp"
#include "tactile/results/confusion.hpp"
#include "tactile/results/detection.hpp"
#include "tactile/results/false_alarm_table.hpp"
#include "tactile/results/judged_run.hpp"

namespace tactile::stress {

/// How one training did in one run.
struct RunOutcome : results::JudgedRun {
  results::Confusion confusion{};                ///< of the balanced samples
  std::vector<results::Detection> detections{};  ///< of the labelled intervals that are not in doubt
  results::FalseAlarms alarms{};
  std::uint64_t close_ticks = 0;  ///< where another engine's verdict may differ
};

/// By which intervals a run is judged.
enum class JudgedBy : std::uint8_t { labels, truth };

/// Judges a training on its runs as `tactile eval` does: the same ticks, samples, detections and false alarms.
///
/// Ticks and labels are those of the unchanged run, however the events are changed. An event that a recipe delays counts in the
/// ticks after it arrives, so its delay is part of the detection delay.
///
/// @param series    nothing: the unchanged runs. Runs of a simulated world are judged by their truth
/// @param severity  > 0 with a series
/// @param by        for unchanged runs
std::vector<RunOutcome> judged_runs(const StressPlan& plan, const StressTraining& training, const StressSeries* series,
                                    double severity, JudgedBy by, const ProgressCallback& progress = {});

/// The same on recordings without a touch, each of them an object of its own: false alarms only.
std::vector<RunOutcome> judged_quiet(const StressPlan& plan, const StressTraining& training, const StressSeries* series,
                                     double severity, const ProgressCallback& progress = {});

/// {"runs": [{"object", "run", "confusion", "intervals", "false_alarms", "close_ticks"}]}, complete or not at all.
void write_outcomes(const std::filesystem::path& file, std::span<const RunOutcome> outcomes);

/// @param training  which one judged them   @throws Error  if it has another form
std::vector<RunOutcome> read_outcomes(const std::filesystem::path& file, std::size_t training);

}  // namespace tactile::stress
