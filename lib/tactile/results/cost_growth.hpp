#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/events/event.hpp"
#include "tactile/results/json_view.hpp"

namespace tactile::results {

/// The time of a tick at one point of a curve, by the sparse and by the dense method [us]: rendering, with the events that enter
/// and leave the window, and the network.
struct GrowthPoint {
  double events_per_s = 0;
  microseconds history{0};
  events::SensorSize sensor{};
  events::SensorSize heatmap{};
  double lit_share = 0;  ///< of the heatmap's cells that are not 0, on average
  struct MethodTime {
    double rendering_us = 0, network_us = 0;  ///< medians over ticks
    double p50_us = 0, p99_us = 0;            ///< of both together
  };
  MethodTime sparse{}, dense{};
};

struct CostGrowth {
  std::vector<GrowthPoint> by_rate, by_history, by_resolution;
};

/// {"events_per_s", "th_ms", "sensor", "heatmap", "lit_share", "sparse", "dense"}, sizes as [width, height], with "rendering_us",
/// "network_us", "p50_us", "p99_us" in "sparse" and "dense".
void to_json(nlohmann::json& json, const GrowthPoint& point);
void from_json(const JsonView& json, GrowthPoint& point);

/// {"rate", "history", "resolution"}, lists of points.
void to_json(nlohmann::json& json, const CostGrowth& growth);
void from_json(const JsonView& json, CostGrowth& growth);

}  // namespace tactile::results
