#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/core/touch.hpp"
#include "tactile/evaluation/confidence_interval.hpp"
#include "tactile/results/delay_table.hpp"
#include "tactile/windows/sample.hpp"

namespace tactile {

struct DelayOptions {
  microseconds window{500'000};     ///< so long after its onset an interval can still be detected, > 0
  microseconds head_start{10'000};  ///< an episode that begins no further ahead of the onset still counts as its detection, >= 0
};

enum class DetectionOutcome : std::uint8_t { detected, missed, early };

/// How one labelled interval was met.
struct Detection {
  TouchInterval interval;
  DetectionOutcome outcome = DetectionOutcome::missed;
  microseconds delay{0};                        ///< of a detected one: one tick at the least
  CameraTime first_right{};                     ///< t_c(k), of a detected one
  std::optional<std::int64_t> leading_episode;  ///< first tick index of the episode that ran into the onset, where one did
};

/// "8 ms", "missed" or "early"
std::string words_of(const Detection& detection);

std::string_view name_of(DetectionOutcome outcome);  ///< "detected", "missed", "early"

/// {"class", "start_us", "end_us", "outcome", "delay_ms"}; the delay is null but of a detected one.
void to_json(nlohmann::json& json, const Detection& detection);

void from_json(const JsonView& json, Detection& detection);  ///< but for the ticks

/// The detection delay of each interval:
///
///   delay = (k - k0 + 1) * tick
///
/// k0 is the first tick after the onset (t_c > start), k the first tick from k0 on whose verdict is right. Missed: no right
/// verdict with t_c <= min(end, start + window). If the verdicts at k0 - 1 and k0 are both the class already, then the delay is
/// one tick where that episode's first tick lies at most `head_start` before k0; else the interval is early.
///
/// @param ticks      the run's full ticks
/// @param verdicts   one for each tick
/// @param intervals  presses and slips
/// @throws Error  if there is not one verdict for each tick
std::vector<Detection> detections_of(const TickRange& ticks, std::span<const Touch> verdicts,
                                     std::span<const TouchInterval> intervals, const DelayOptions& options = {});

/// The delays of the same detections counted from other onsets, which may lie behind the detection: (k - k0 + 1) * tick with k0
/// the first tick after `onset`, zero or negative where the touch was told before it. Missed and early ones stay so.
Detection counted_from(const Detection& detection, CameraTime onset, const TickRange& ticks);

/// The detections of one run.
struct RunDetections {
  std::string object;
  std::vector<Detection> detections;
};

/// Over all runs only, as `delay_table(...).all`.
DelaySummary delay_summary(std::span<const RunDetections> runs, Touch touch, const BootstrapOptions& options = {});
DelayTable delay_table(std::span<const RunDetections> runs, Touch touch, const BootstrapOptions& options = {});

}  // namespace tactile
