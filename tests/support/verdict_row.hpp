#pragma once

#include <string_view>
#include <vector>

#include "tactile/core/ticks.hpp"
#include "tactile/core/touch.hpp"

namespace tactile::test {

/// Verdicts as a row of letters: '.' none, 'p' press, 's' slip.
inline std::vector<Touch> verdict_row(std::string_view letters) {
  std::vector<Touch> verdicts;
  for (const char letter : letters) verdicts.push_back(letter == 'p' ? Touch::press : letter == 's' ? Touch::slip : Touch::none);
  return verdicts;
}

/// Ticks at first_ms, first_ms + 2, ... as many as there are verdicts.
inline TickRange ticks_of(const std::vector<Touch>& verdicts, std::int64_t first_ms = 0) {
  return {camera_time(first_ms * 1000), static_cast<std::int64_t>(verdicts.size()), 2ms};
}

/// An interval in whole milliseconds.
inline TouchInterval interval_ms(Touch touch, std::int64_t start_ms, std::int64_t end_ms) {
  return {touch, camera_time(start_ms * 1000), camera_time(end_ms * 1000)};
}

}  // namespace tactile::test
