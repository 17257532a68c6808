#pragma once

#include <chrono>
#include <thread>

namespace tactile::test {

/// Time limit for an event that a test waits for. It is far longer than the event takes, because the machine may be busy.
inline constexpr std::chrono::seconds long_enough{60};

/// Waits until `holds()` is true. Returns false if it is still false after `long_enough`.
template <class Condition>
bool comes_true(const Condition& holds) {
  const auto end = std::chrono::steady_clock::now() + long_enough;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

}  // namespace tactile::test
