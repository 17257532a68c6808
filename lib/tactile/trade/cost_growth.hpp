#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/events/event.hpp"

namespace tactile {

/// What a tick costs at one place of a curve, by our way and by the dense one [us]: rendering with what comes and goes, and the
/// network.
struct GrowthPoint {
  double events_per_s = 0;
  microseconds history{0};
  SensorSize sensor;
  SensorSize heatmap;
  double lit_share = 0;  ///< of the heatmap's cells that are not 0, on average
  struct Way {
    double rendering_us = 0, network_us = 0;  ///< medians over ticks
    double p50_us = 0, p99_us = 0;            ///< of both together
  };
  Way sparse, dense;
};

void to_json(nlohmann::json& json, const GrowthPoint& point);

struct CostGrowth {
  std::vector<GrowthPoint> by_rate, by_history, by_resolution;
};

void to_json(nlohmann::json& json, const CostGrowth& growth);

struct GrowthOptions {
  std::vector<double> rates{0, 1e4, 1e5, 3e5, 1e6, 3e6, 1e7, 2e7};  ///< events per second, at t_h 40 ms on the source's sensor
  std::vector<microseconds> histories{2ms, 10ms, 20ms, 40ms, 100ms, 200ms};          ///< at `usual_rate`
  std::vector<SensorSize> sensors{{160, 120}, {320, 240}, {640, 480}, {1280, 960}};  ///< at `usual_rate`
  double usual_rate = 3e5;
  unsigned pieces = 5;  ///< of the source, spread evenly over it, > 0
  unsigned ticks = 20;  ///< of each piece, > 0
  unsigned turns = 3;   ///< the shortest counts, > 0
};

/// The events of the milliseconds in which the skin moves, which have 100 and more, one recording after the other.
/// @throws Error  if there are none
std::vector<Event> moving_events(std::span<const std::filesystem::path> recordings);

/// Times ticks of 2 ms of streams that take their events from `source`, at an even rate, on this thread; all points, sparse and
/// dense, take turns, so that what else the machine does falls on all alike. The network's weights are drawn at random: what it
/// costs does not depend on them.
/// @param sensor  of the source
CostGrowth measure_growth(std::span<const Event> source, SensorSize sensor, const GrowthOptions& options = {},
                          const ProgressCallback& progress = {});

}  // namespace tactile
