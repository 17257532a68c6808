#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/model/bundle/weights.hpp"
#include "tactile/model/training/stream_runs.hpp"

namespace tactile::test {

/// Random weights for the rectangle from 0, 0 to 160, 120.
inline model::Weights stream_weights(std::uint64_t seed = 2) {
  model::Weights weights;
  Random random(seed);
  for (const model::ParameterShape& shape : model::stream_parameters()) {
    weights.push_back({shape, std::vector<float>(shape.count())});
    for (float& value : weights.back().values) value = static_cast<float>(random.uniform(-0.3, 0.3));
  }
  weights.front().values = {0, 0, 160, 120};
  return weights;
}

/// Counts of some cells at each tick: most are empty, and about one tick in five has no event.
inline std::vector<std::uint8_t> stream_counts(std::size_t ticks, std::uint64_t seed) {
  std::vector<std::uint8_t> counts(ticks * model::StreamLayout::cells);
  Random random(seed);
  for (std::size_t tick = 0; tick < ticks; ++tick) {
    for (std::uint64_t i = random.below(5) == 0 ? 0 : random.below(300); i > 0; --i) {
      std::uint8_t& count = counts[tick * model::StreamLayout::cells + random.below(model::StreamLayout::cells)];
      count = static_cast<std::uint8_t>(count + 1 + random.below(3));
    }
  }
  return counts;
}

/// A run in noise with a press, of ON events, and a slip, of both.
inline model::StreamRun made_stream_run(std::uint64_t seed, std::size_t ticks = 700) {
  using Image = model::StreamImage;
  model::StreamRun run;
  run.name = "fan/0" + std::to_string(seed % 9 + 1);
  run.ticks = ticks;
  run.touches = {{Touch::press, ticks / 4, ticks / 4 + 100}, {Touch::slip, ticks * 6 / 10, ticks * 6 / 10 + 150}};
  run.truth.assign(ticks, Touch::none);
  run.weights.assign(ticks, 1.0F);
  run.counts.assign(ticks * Image::size, 0);
  Random random(seed);
  for (const model::TickSpan& span : run.touches) {
    for (std::size_t k = span.begin; k < span.end; ++k) run.truth[k] = span.touch;
  }
  for (std::size_t k = 0; k < ticks; ++k) {
    for (std::size_t polarity = 0; polarity < 2; ++polarity) {
      for (std::size_t row = 0; row < Image::rows; ++row) {
        for (std::size_t column = 0; column < Image::columns; ++column) {
          const bool fires = run.truth[k] == Touch::slip || (run.truth[k] == Touch::press && polarity == 1);
          run.counts[k * Image::size + Image::at(polarity, row, column)] =
              static_cast<std::uint8_t>(random.poisson(fires ? 0.4 : 0.03));
        }
      }
    }
  }
  return run;
}

}  // namespace tactile::test
