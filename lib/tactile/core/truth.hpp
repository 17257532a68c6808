#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/clock_relation.hpp"
#include "tactile/core/touch.hpp"

namespace tactile {

/// An interval of the true motion, in camera time.
struct TrueInterval {
  TouchInterval interval;                 ///< onset and end by the rules of labels
  std::optional<CameraTime> gross;        ///< slip only: start of relative motion between object and tip
  std::optional<CameraTime> first_event;  ///< the first event due to this motion
  bool labelled = true;                   ///< false: real motion without a label
  std::string what = {};                  ///< "press", "slip", "release", "micro-slip", ...; empty if the file lacks it
};

/// A defective pixel.
struct TruePixel {
  int x = 0;
  int y = 0;
  double hz = 0;  ///< rate of a hot pixel; 0: dead

  friend bool operator==(const TruePixel&, const TruePixel&) = default;
};

struct Truth {
  std::vector<TrueInterval> intervals;                    ///< by start
  std::optional<CameraTime> lift_start;                   ///< only with a simulated robot
  std::optional<ClockRelation> robot_clock, video_clock;  ///< only if robot or film was simulated
  std::vector<TruePixel> hot_pixels, dead_pixels;         ///< of this run; empty if the file lacks them
  nlohmann::json parameters = nlohmann::json::object();   ///< the settings of the simulation
};

/// @throws Error  if the file is missing or invalid
Truth read_truth(const std::filesystem::path& file);
void write_truth(const std::filesystem::path& file, const Truth& truth);

}  // namespace tactile
