#pragma once

#include <optional>

#include "tactile/alignment/run_signals.hpp"
#include "tactile/alignment/session_clocks.hpp"
#include "tactile/alignment/video_clock.hpp"

namespace tactile::labels {

/// Relates the film's clock by the arm; without motion in a log, by the bursts of events. The run must have a film.
alignment::VideoClockFit fit_film_clock(const alignment::RunSignals& signals, const alignment::RobotClocks& clocks,
                                        const alignment::VideoClockOptions& options);

/// By how much the skin's own bursts place the film later than `video_clock` does, which relates it by the arm. Nothing if they
/// agree within `longest` and both uncertainties, if the bursts give no clock, or if more than the first shear gave the robot's
/// clock.
std::optional<microseconds> skin_in_film_disagrees(const alignment::RunSignals& signals, const alignment::RobotClocks& clocks,
                                                   const alignment::FittedClock& video_clock,
                                                   const alignment::VideoClockOptions& options, microseconds longest);

}  // namespace tactile::labels
