#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/events/event.hpp"
#include "tactile/results/cost_growth.hpp"

namespace tactile::trade {

struct GrowthOptions {
  std::vector<double> rates{0, 1e4, 1e5, 3e5, 1e6, 3e6, 1e7, 2e7};  ///< events per second, at t_h 40 ms on the source's sensor
  std::vector<microseconds> histories{2ms, 10ms, 20ms, 40ms, 100ms, 200ms};                  ///< at `usual_rate`
  std::vector<events::SensorSize> sensors{{160, 120}, {320, 240}, {640, 480}, {1280, 960}};  ///< at `usual_rate`
  double usual_rate = 3e5;
  unsigned pieces = 5;  ///< of the source, spread evenly over it, > 0
  unsigned ticks = 20;  ///< of each piece, > 0
  unsigned turns = 3;   ///< the result is the shortest, > 0
};

/// The events of all milliseconds with 100 events or more, in which the skin moves, one recording after the other.
/// @throws Error  if there are none
std::vector<events::Event> moving_events(std::span<const std::filesystem::path> recordings);

/// Times ticks of 2 ms on this thread, of streams with the events of `source` at an even rate. All points, sparse and dense, take
/// turns: other load on the machine affects all alike. The network has random weights, which do not change its cost.
/// @param sensor  of the source
results::CostGrowth measure_growth(std::span<const events::Event> source, events::SensorSize sensor,
                                   const GrowthOptions& options = {}, const ProgressCallback& progress = {});

}  // namespace tactile::trade
