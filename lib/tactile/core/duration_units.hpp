#pragma once

#include <chrono>

namespace tactile {

/// A duration in milliseconds, with its fraction.
template <class Rep, class Period>
constexpr double in_ms(std::chrono::duration<Rep, Period> duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

/// A duration in seconds, with its fraction.
template <class Rep, class Period>
constexpr double in_s(std::chrono::duration<Rep, Period> duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace tactile
