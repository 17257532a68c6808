#pragma once

#include <chrono>
#include <thread>

namespace tactile::test {

/// Time limit for an event that a test waits for. It is far longer than the event takes, because the machine may be busy.
inline constexpr std::chrono::seconds long_enough{60};

/// Waits until `holds()` is true; asks once in each `pause`. Returns false if it is still false after `long_enough`.
template <class Condition>
bool comes_true(const Condition& holds, std::chrono::microseconds pause = std::chrono::milliseconds(5)) {
  const auto end = std::chrono::steady_clock::now() + long_enough;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(pause);
  }
  return true;
}

}  // namespace tactile::test
