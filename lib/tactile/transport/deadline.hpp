#pragma once

#include <algorithm>
#include <chrono>
#include <string>

namespace tactile::transport {

using SteadyClock = std::chrono::steady_clock;

/// `patience` from now, at most a day: more could overflow the clock.
inline SteadyClock::time_point deadline_after(std::chrono::microseconds patience) {
  using std::chrono::microseconds;
  return SteadyClock::now() + std::clamp<microseconds>(patience, microseconds(0), std::chrono::hours(24));
}

/// The time left until `deadline`, rounded up, so that a wait never ends too early; 0 after it.
inline std::chrono::microseconds left_until(SteadyClock::time_point deadline) {
  using std::chrono::microseconds;
  return std::max(std::chrono::ceil<microseconds>(deadline - SteadyClock::now()), microseconds(0));
}

/// "5 s", "0.300 s"
inline std::string seconds_text(std::chrono::milliseconds patience) {
  std::string text = std::to_string(patience.count() / 1000);
  if (const auto rest = patience.count() % 1000; rest != 0) text += "." + std::to_string(1000 + rest).substr(1);
  return text + " s";
}

}  // namespace tactile::transport
