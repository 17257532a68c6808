#include "tactile/core/clock_relation.hpp"

#include <algorithm>
#include <cmath>

#include "tactile/core/json.hpp"

namespace tactile {
namespace {

/// Rounded, and limited to int64: labels.json may contain any drift.
std::int64_t whole_us(double us) {
  constexpr double limit = 9.2e18;
  return std::isnan(us) ? 0 : std::llround(std::clamp(us, -limit, limit));
}

}  // namespace

CameraTime ClockRelation::camera_from(std::int64_t clock_us) const {
  const double since_reference_us = static_cast<double>(saturating_subtract(clock_us, reference_us));
  const std::int64_t drifted_us = whole_us(drift_ppm * 1e-6 * since_reference_us);
  return camera_time(saturating_add(saturating_add(clock_us, offset_us), drifted_us));
}

std::int64_t ClockRelation::clock_us_from(CameraTime t) const {
  const std::int64_t undrifted_us = saturating_subtract(us_of(t), offset_us);
  const double rate = drift_ppm * 1e-6;
  const double since_reference_us = static_cast<double>(saturating_subtract(undrifted_us, reference_us));
  const std::int64_t drifted_us = whole_us(rate / (1.0 + rate) * since_reference_us);
  return saturating_subtract(undrifted_us, drifted_us);
}

void to_json(nlohmann::json& json, const ClockRelation& relation) {
  json = {{"offset_us", relation.offset_us}, {"drift_ppm", relation.drift_ppm}, {"reference_us", relation.reference_us}};
}

void from_json(const nlohmann::json& json, ClockRelation& relation) {
  relation.offset_us = member<std::int64_t>(json, "offset_us", "is no clock");
  relation.drift_ppm = member<double>(json, "drift_ppm", "is no clock");
  relation.reference_us = member<std::int64_t>(json, "reference_us", "is no clock");
}

}  // namespace tactile
