#pragma once

#include <array>
#include <span>
#include <vector>

#include "tactile/alignment/run_signals.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/results/full_run.hpp"
#include "tactile/review/signal_window.hpp"

namespace tactile::review {

// A run's signals in microseconds after its first event.

/// robot_speed [m/s], robot_height above the log's first row [m] and film_motion [grey levels/s], placed by the clocks of
/// `labels`; those without a clock are left out.
/// @param signals  with robot log and film; events and IMU are not used
std::vector<SampledSignal> placed_series(const alignment::RunSignals& signals, const labels::Labels& labels, CameraTime first);

/// imu: how far the size of the acceleration is from its median [m/s2]. No samples without an IMU.
SampledSignal imu_series(std::span<const events::ImuSample> samples, CameraTime first);

/// p_none, p_press and p_slip of each tick.
std::array<SampledSignal, touch_count> probability_series(const results::FullRun& run, CameraTime first);

}  // namespace tactile::review
