#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/clock_relation.hpp"
#include "tactile/core/touch.hpp"

namespace tactile {

/// What really happened, in camera time.
struct TrueInterval {
  TouchInterval interval;                 ///< onset and end by the rules that labels follow
  std::optional<CameraTime> gross;        ///< slip only: object and tip first move against each other
  std::optional<CameraTime> first_event;  ///< the first event that this motion caused
  bool labelled = true;                   ///< false: real motion that nobody labels
  std::string what = {};                  ///< "press", "slip", "release", "micro-slip", ...; empty where the file does not say
};

/// A pixel that is not as it should be.
struct TruePixel {
  int x = 0;
  int y = 0;
  double hz = 0;  ///< of a hot one, by itself; 0: it is dead

  friend bool operator==(const TruePixel&, const TruePixel&) = default;
};

struct Truth {
  std::vector<TrueInterval> intervals;                    ///< by start
  std::optional<CameraTime> lift_start;                   ///< nothing without a simulated robot
  std::optional<ClockRelation> robot_clock, video_clock;  ///< nothing where the robot, or the film, was not simulated
  std::vector<TruePixel> hot_pixels, dead_pixels;         ///< of this run; none where the file does not say
  nlohmann::json parameters = nlohmann::json::object();   ///< what the run was made from
};

/// @throws Error  if the file is missing or not a truth
Truth read_truth(const std::filesystem::path& file);
void write_truth(const std::filesystem::path& file, const Truth& truth);

}  // namespace tactile
