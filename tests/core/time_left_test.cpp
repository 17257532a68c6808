#include "tactile/core/time_left.hpp"

#include <gtest/gtest.h>

namespace tactile {
namespace {

using namespace std::chrono_literals;

std::optional<double> left_s(TimeLeft& left, std::uint64_t done, std::uint64_t total, std::chrono::seconds at) {
  const auto seconds = left.after({done, total, "training"}, TimeLeft::Clock::time_point{} + at);
  return seconds ? std::optional(seconds->count()) : std::nullopt;
}

TEST(TimeLeft, FollowsTheRateSoFar) {
  TimeLeft left;
  EXPECT_EQ(left_s(left, 0, 100, 7s), std::nullopt) << "no rate yet";
  EXPECT_EQ(left_s(left, 20, 100, 17s), 40);
  EXPECT_EQ(left_s(left, 50, 100, 17s), 10);
  EXPECT_EQ(left_s(left, 100, 100, 20s), std::nullopt) << "nothing is left";
}

TEST(TimeLeft, MeasuresEachPartOfAStepByItself) {
  // Rendering takes 60 s. The training after it has the same total.
  TimeLeft left;
  left_s(left, 0, 640, 0s);
  left_s(left, 640, 640, 60s);
  EXPECT_EQ(left_s(left, 32, 640, 61s), std::nullopt);
  EXPECT_EQ(left_s(left, 64, 640, 62s), 18) << "32 of 576 in a second";
  EXPECT_EQ(left_s(left, 96, 1280, 63s), std::nullopt) << "another total is another part";
}

TEST(TimeLeft, CountsWhatWasDoneBeforeAsNoWork) {
  // A training that is resumed at its half.
  TimeLeft left;
  left_s(left, 500, 1000, 0s);
  EXPECT_EQ(left_s(left, 600, 1000, 10s), 40);
}

}  // namespace
}  // namespace tactile
