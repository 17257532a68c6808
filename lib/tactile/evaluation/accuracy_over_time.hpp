#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/ticks.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/evaluation/crossed_figure.hpp"
#include "tactile/results/judged_run.hpp"
#include "tactile/results/over_time.hpp"

namespace tactile::evaluation {

/// Ticks of intervals, and how many of them were predicted correctly.
struct TickCount {
  std::uint64_t ticks = 0, right = 0, intervals = 0;  ///< intervals: that have such a tick
};

/// The ticks of one run's intervals of one class, by how far they lie from onset and end.
struct OverTimeCounts {
  TickCount first, later, last;         ///< within `first` of the onset, after that, and within `last` of the end
  TickCount last_of_long, before_last;  ///< of intervals longer than `last`: within `last` of the end, and before that
  TickCount after;                      ///< end < t_c <= end + `after`, where no other interval is; right: none is predicted
  std::vector<TickCount> since_onset;   ///< bin i: i * bin < t_c - start <= (i + 1) * bin; up to the last bin with a tick
  std::vector<TickCount> before_end;    ///< bin i: i * bin <= end - t_c < (i + 1) * bin; up to the last bin with a tick
};

/// By the value of Touch.
using OverTimeOfRun = std::array<OverTimeCounts, touch_count>;

/// Every tick of every interval counts, however long the interval is.
/// @param verdicts   one for each tick
/// @param elsewhere  other intervals: their ticks do not count as after an interval
/// @throws Error  if there is not one verdict for each tick
OverTimeOfRun over_time_of(const TickRange& ticks, std::span<const Touch> verdicts, std::span<const TouchInterval> intervals,
                           const results::OverTimeOptions& options = {}, std::span<const TouchInterval> elsewhere = {});

/// One run's.
struct RunOverTime : results::JudgedRun {
  OverTimeOfRun counts{};
};

results::OverTime accuracy_over_time(std::span<const RunOverTime> runs, const results::OverTimeOptions& options = {},
                                     const results::BootstrapOptions& bootstrap = {});

}  // namespace tactile::evaluation
