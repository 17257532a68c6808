#pragma once

#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/evaluation/run_prediction.hpp"
#include "tactile/experiments/stress/plan_stress.hpp"
#include "tactile/results/cell.hpp"

namespace tactile::stress {

/// By which intervals the samples of a run are drawn.
enum class JudgedBy : std::uint8_t { labels, truth };

/// Judges a training on its runs as `tactile eval` does: the same ticks, samples, detections and false alarms. A cell's setting
/// is the training's name.
///
/// Ticks and labels are those of the unchanged run, however the events are changed. An event that a recipe delays counts in the
/// ticks after it arrives, so its delay is part of the detection delay.
///
/// A run without samples that cannot be read has no cell.
///
/// @param series    nothing: the unchanged runs. Runs of a simulated world are judged by their truth
/// @param severity  > 0 with a series
/// @param by        for unchanged runs
std::vector<results::Cell> judged_runs(const StressPlan& plan, const StressTraining& training, const StressSeries* series,
                                       double severity, JudgedBy by, const ProgressCallback& progress = {});

/// The same on recordings without a touch, each of them an object of its own: false alarms only.
std::vector<results::Cell> judged_quiet(const StressPlan& plan, const StressTraining& training, const StressSeries* series,
                                        double severity, const ProgressCallback& progress = {});

}  // namespace tactile::stress
