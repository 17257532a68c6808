#pragma once

#include <chrono>
#include <cstdint>
#include <random>
#include <thread>

namespace tactile::test {

/// Moments at which to kill a command, drawn over what it takes undisturbed.
class KillMoments {
 public:
  KillMoments(std::chrono::duration<double> undisturbed, std::uint64_t seed) : lasts_(undisturbed), random_(seed) {}

  /// Sleeps for a share of it, drawn from these two.
  void sleep(double from, double to) {
    std::this_thread::sleep_for(lasts_ * std::uniform_real_distribution<double>(from, to)(random_));
  }
  /// The command has ended first: the machine has more time for it than it had, and the next moments come sooner.
  void were_too_late() { lasts_ *= 0.7; }

 private:
  std::chrono::duration<double> lasts_;
  std::mt19937_64 random_;
};

}  // namespace tactile::test
