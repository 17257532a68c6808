#pragma once

#include <cstdint>

#include "tactile/pictures/gnuplot.hpp"
#include "tactile/results/stress.hpp"

namespace tactile::report {

enum class StressMeasure : std::uint8_t { accuracy, within_50_ms, false_alarms };

/// One panel a recipe or world: the measure at each severity, with its 95 % intervals, one line a model. Severities have equal
/// distances, the harmless one first. Shares are in percent; false alarms are those outside of touches, per minute, on an axis
/// that is logarithmic beyond 1.
/// @param of_quiet  the curves of recordings without a touch
pictures::Plot stress_plot(const results::Stress& stress, StressMeasure measure, bool of_quiet = false);

}  // namespace tactile::report
