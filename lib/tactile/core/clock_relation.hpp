#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>

#include "tactile/core/time.hpp"

namespace tactile {

/// How another device's clock relates to the camera's:
///
///   camera_us = clock_us + offset_us + drift_ppm * 1e-6 * (clock_us - reference_us)
///
/// `reference_us` is that clock's first stamp in the run.
struct ClockRelation {
  std::int64_t offset_us = 0;
  double drift_ppm = 0.0;
  std::int64_t reference_us = 0;

  CameraTime camera_from(std::int64_t clock_us) const;  ///< rounded to the nearest microsecond
  std::int64_t clock_us_from(CameraTime t) const;       ///< the inverse, rounded to the nearest microsecond

  template <class Clock>
  CameraTime camera_from(std::chrono::time_point<Clock, microseconds> t) const {
    return camera_from(us_of(t));
  }
};

void to_json(nlohmann::json& json, const ClockRelation& relation);
void from_json(const nlohmann::json& json, ClockRelation& relation);

}  // namespace tactile
