#pragma once

#include <chrono>
#include <cstdint>
#include <random>
#include <thread>

namespace tactile::test {

/// Random moments at which a test kills a command.
class KillMoments {
 public:
  /// @param duration  of the command if it is not killed
  KillMoments(std::chrono::duration<double> duration, std::uint64_t seed) : duration_(duration), random_(seed) {}

  /// Sleeps for a random share of the duration. @param from, to  limits of the share, 0 to 1
  void sleep(double from, double to) {
    std::this_thread::sleep_for(duration_ * std::uniform_real_distribution<double>(from, to)(random_));
  }
  /// The command ended before it was killed: it is faster now, and the next moments are earlier.
  void were_too_late() { duration_ *= 0.7; }

 private:
  std::chrono::duration<double> duration_;
  std::mt19937_64 random_;
};

}  // namespace tactile::test
