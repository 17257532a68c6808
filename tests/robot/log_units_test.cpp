#include <fmt/core.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

#include "robot/robot_log_text.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile::robot {
namespace {

/// By what the numbers of a log are too large.
struct Factors {
  double time = 1, place = 1, turn = 1, speed = 1, turning = 1;
};

/// Two seconds of an arm that rises by 5 cm and turns, at 125 Hz. The first row is damaged.
std::string log_with(const Factors& factors, bool of_joints = false) {
  std::string text = "timestamp";
  for (const char* name : {of_joints ? "actual_q" : "actual_TCP_pose", "actual_TCP_speed"}) {
    for (int i = 0; i < 6; ++i) text += fmt::format(",{}_{}", name, i);
  }
  text += "\n";
  for (int row = 0; row < 250; ++row) {
    const double t = 0.008 * row, lifting = t > 1 && t < 1.5 ? 0.1 : 0, far = row == 0 ? 100 : 1;
    const std::array<double, 6> pose =
        of_joints ? std::array{0.1, -1.5, 1.8, -1.9, -1.57, 40.0} : std::array{-0.4, 0.1, 0.2 + 0.05 * t, 0.0, 3.1, 0.1};
    text += fmt::format("{:.6f}", factors.time * (500 + t));
    for (std::size_t i = 0; i < 6; ++i)
      text += fmt::format(",{:.6f}", far * pose.at(i) * (of_joints || i > 2 ? factors.turn : factors.place));
    for (std::size_t i = 0; i < 6; ++i)
      text += fmt::format(",{:.6f}", far * (i == 2 ? lifting * factors.speed : i == 5 ? 10 * lifting * factors.turning : 0.001));
    text += "\n";
  }
  return text;
}

std::string refusal_of_log(const Factors& factors, bool of_joints = false) {
  const std::string text = test::complaint_about(log_with(factors, of_joints));
  return text.substr(text.find("robot.csv") + (text.empty() ? 0 : 9));
}

TEST(LogUnits, AreSecondsMetresAndRadians) {
  EXPECT_EQ(test::read(log_with({})).states.size(), 250U);
  EXPECT_EQ(test::read(log_with({}, true)).states.size(), 250U);
}

TEST(LogUnits, OfOtherKindsAreRefusedWithColumnAndFactor) {
  constexpr double mm = 1000, cm = 100, degrees = 57.29578;
  const std::string convert = "convert the values (millimetres: divide by 1000; centimetres: by 100; inches: multiply by 0.0254)";
  EXPECT_EQ(refusal_of_log({.place = mm, .speed = mm}),
            ": actual_TCP_pose_0 to _2 have values of 400, where no arm reaches; expected metres: " + convert);
  EXPECT_EQ(refusal_of_log({.place = cm, .speed = cm}),
            ": actual_TCP_pose_0 to _2 have values of 40, where no arm reaches; expected metres: " + convert);
  EXPECT_EQ(refusal_of_log({.turn = degrees}),
            ": actual_TCP_pose_3 to _5 have values of 177.6, more than a turn; expected radians: multiply degrees by 0.0174533");
  EXPECT_EQ(refusal_of_log({.turn = degrees}, true),
            ": actual_q_0 to _5 have values of 108.9, more than a turn; expected radians: multiply degrees by 0.0174533");
  EXPECT_EQ(refusal_of_log({.speed = mm}),
            ": actual_TCP_speed_0 to _2 have values of 100, faster than any arm; expected m/s: " + convert);
  EXPECT_EQ(refusal_of_log({.turning = degrees}),
            ": actual_TCP_speed_3 to _5 have values of 57.3, faster than any arm; expected rad/s: multiply degrees by 0.0174533");
}

TEST(LogUnits, OfTimesAreSeconds) {
  EXPECT_EQ(refusal_of_log({.time = 1e3}),
            ": timestamp: the rows are 8 apart (median); expected seconds, and more than two rows a second: divide milliseconds "
            "by 1000");
  EXPECT_NE(refusal_of_log({.time = 1e6}).find("the rows are 8000 apart (median)"), std::string::npos);
  EXPECT_NE(refusal_of_log({.time = 1e6}).find("divide microseconds by 1000000"), std::string::npos);
  EXPECT_NE(refusal_of_log({.time = 1e9}).find("divide nanoseconds by 1000000000"), std::string::npos);
  EXPECT_NE(refusal_of_log({.time = 1e10}).find("seconds; divide milliseconds by 1000"), std::string::npos);
}

}  // namespace
}  // namespace tactile::robot
