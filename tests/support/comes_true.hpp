#pragma once

#include <chrono>
#include <thread>

namespace tactile::test {

/// Waits until `holds`; false if it does not for a minute.
template <class Condition>
bool comes_true(const Condition& holds) {
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!holds()) {
    if (std::chrono::steady_clock::now() > patience) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

}  // namespace tactile::test
