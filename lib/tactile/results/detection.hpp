#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/core/touch.hpp"
#include "tactile/results/json_view.hpp"
#include "tactile/results/judged_run.hpp"

namespace tactile::results {

enum class DetectionOutcome : std::uint8_t { detected, missed, early };

/// How one labelled interval was detected.
struct Detection {
  TouchInterval interval{};
  DetectionOutcome outcome = DetectionOutcome::missed;
  microseconds delay{0};                          ///< of a detected one: one tick at the least
  CameraTime first_right{};                       ///< t_c(k), of a detected one
  std::optional<std::int64_t> leading_episode{};  ///< first tick index of the episode that ran into the onset, where one did
  microseconds limit{0};                          ///< how long after its onset it could be detected
  bool ahead = false;                             ///< predicted before its onset already: early, or detected by a head start
};

/// "8 ms", "missed" or "early"
std::string words_of(const Detection& detection);

std::string_view name_of(DetectionOutcome outcome);  ///< "detected", "missed", "early"

/// {"class", "start_us", "end_us", "outcome", "delay_ms", "ahead", "limit_ms"}; the delay is null but of a detected one.
void to_json(nlohmann::json& json, const Detection& detection);

void from_json(const JsonView& json, Detection& detection);  ///< but for the ticks

}  // namespace tactile::results
