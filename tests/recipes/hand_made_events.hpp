#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/recipes/recipe_stream.hpp"

namespace tactile::recipes::test {

inline events::Event event(std::int64_t us, int x = 0, int y = 0, bool on = true) {
  return {camera_time(us), static_cast<std::int16_t>(x), static_cast<std::int16_t>(y), static_cast<std::uint8_t>(on ? 1 : 0)};
}

/// `count` events, one each `step_us`, at random pixels.
inline std::vector<events::Event> random_events(std::size_t count, events::SensorSize size, std::int64_t step_us = 10,
                                                std::int64_t begin_us = 1'000'000) {
  Random random(7);
  std::vector<events::Event> events;
  for (std::size_t i = 0; i < count; ++i) {
    events.push_back(event(begin_us + static_cast<std::int64_t>(i) * step_us,
                           static_cast<int>(random.below(static_cast<std::uint64_t>(size.width))),
                           static_cast<int>(random.below(static_cast<std::uint64_t>(size.height))), random.below(2) == 1));
  }
  return events;
}

inline std::vector<events::Event> after_recipe(std::string_view recipe, const std::vector<events::Event>& events,
                                               events::SensorSize size = {16, 12}, std::uint64_t seed = 1) {
  const std::vector<Recipe> recipes{parse_recipe(recipe, seed)};
  return worsened(events, recipes, size);
}

}  // namespace tactile::recipes::test
