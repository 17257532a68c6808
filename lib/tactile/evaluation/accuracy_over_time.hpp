#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/touch.hpp"
#include "tactile/evaluation/confidence_interval.hpp"
#include "tactile/results/over_time.hpp"
#include "tactile/windows/sample.hpp"

namespace tactile {

struct OverTimeOptions {
  microseconds bin{50'000};         ///< of the curves, > 0
  microseconds longest{3'000'000};  ///< how far from onset and end the curves go, >= bin
  microseconds first{500'000};      ///< what counts as the beginning of an interval, > 0
  microseconds last{200'000};       ///< what counts as its end, > 0
  microseconds after{100'000};      ///< so long behind an interval it is looked at what is still said, >= 0
};

/// Ticks of intervals, and how many of them were said right.
struct TickCount {
  std::uint64_t ticks = 0, right = 0, intervals = 0;  ///< intervals: that have such a tick
};

/// The ticks of one run's intervals of one class, by how far they lie from onset and end.
struct OverTimeCounts {
  TickCount first, later, last;         ///< within `first` of the onset, behind that, and within `last` of the end
  TickCount last_of_long, before_last;  ///< of intervals longer than `last` alone: within `last` of the end, and ahead of that
  TickCount after;                      ///< end < t_c <= end + `after`, where nothing else is; right: none is said
  std::vector<TickCount> since_onset;   ///< bin i: i * bin < t_c - start <= (i + 1) * bin
  std::vector<TickCount> before_end;    ///< bin i: i * bin <= end - t_c < (i + 1) * bin
};

/// By the value of Touch.
using OverTimeOfRun = std::array<OverTimeCounts, touch_count>;

/// Every tick of every interval counts, however long the interval is.
/// @param verdicts   one for each tick
/// @param elsewhere  whatever else there is: a tick in it is not counted as behind an interval
/// @throws Error  if there is not one verdict for each tick
OverTimeOfRun over_time_of(const TickRange& ticks, std::span<const Touch> verdicts, std::span<const TouchInterval> intervals,
                           const OverTimeOptions& options = {}, std::span<const TouchInterval> elsewhere = {});

/// One run's.
struct RunOverTime {
  std::string object;
  OverTimeOfRun counts;
};

/// Of press, of slip and of both together.
struct OverTime {
  OverTimeOptions options;
  AccuracyOverTime press, slip, both;
};

/// {"bin_ms", "first_ms", "last_ms", "after_ms", "press", "slip", "both"}
void to_json(nlohmann::json& json, const OverTime& over_time);

OverTime accuracy_over_time(std::span<const RunOverTime> runs, const OverTimeOptions& options = {},
                            const BootstrapOptions& bootstrap = {});

}  // namespace tactile
