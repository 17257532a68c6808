#include "tactile/evaluation/detection_delay.hpp"

#include <algorithm>

#include "tactile/core/error.hpp"

namespace tactile::evaluation {
namespace {

/// The index of the first tick with t_c > t; below 0 where that lies before the range.
std::int64_t first_tick_after(CameraTime t, const TickRange& ticks) {
  const std::int64_t us = between(ticks.first, t).count(), tick_us = ticks.tick.count();
  const std::int64_t floor = us / tick_us - (us % tick_us < 0 ? 1 : 0);
  return floor + 1;
}

}  // namespace

std::vector<results::Detection> detections_of(const TickRange& ticks, std::span<const Touch> verdicts,
                                              std::span<const TouchInterval> intervals, const DelayOptions& options) {
  if (static_cast<std::int64_t>(verdicts.size()) != ticks.count) {
    throw Error("detection delay: " + std::to_string(verdicts.size()) + " verdicts for " + std::to_string(ticks.count) +
                " ticks; expected one for each");
  }
  const auto says = [&](std::int64_t index, Touch touch) {
    return index >= 0 && index < ticks.count && verdicts[static_cast<std::size_t>(index)] == touch;
  };
  std::vector<results::Detection> detections;
  for (const TouchInterval& interval : intervals) {
    results::Detection detection;
    detection.interval = interval;
    const CameraTime latest = std::min(interval.end, after(interval.start, options.window));
    detection.limit = std::max(between(interval.start, latest), microseconds{0});
    const std::int64_t k0 = first_tick_after(interval.start, ticks);
    if (says(k0 - 1, interval.touch) && says(k0, interval.touch)) {
      std::int64_t first = k0 - 1;
      while (says(first - 1, interval.touch)) --first;
      detection.leading_episode = first;
      if (ticks.tick * (k0 - first) > options.head_start) {
        detection.outcome = results::DetectionOutcome::early;
        detection.ahead = true;
        detections.push_back(detection);
        continue;
      }
    }
    for (std::int64_t k = std::max<std::int64_t>(k0, 0); k < ticks.count && ticks.at(k) <= latest; ++k) {
      if (!says(k, interval.touch)) continue;
      detection.outcome = results::DetectionOutcome::detected;
      detection.ahead = detection.leading_episode.has_value();
      detection.delay = ticks.tick * (k - k0 + 1);
      detection.first_right = ticks.at(k);
      break;
    }
    detections.push_back(detection);
  }
  return detections;
}

}  // namespace tactile::evaluation
