#include "tactile/detect/robot_bits.hpp"

#include <gtest/gtest.h>

namespace tactile::detect {
namespace {

constexpr RobotBitRule both{}, press{.at_press = true, .at_slip = false}, slip{.at_press = false, .at_slip = true},
    confirmed{.at_press = false, .at_slip = false, .at_confirmed_slip = true};

TEST(RobotBits, RiseWithinTheTickAndFallWithTheVerdict) {
  RobotBits bits({both, press, slip}, {});
  EXPECT_EQ(bits.next(camera_time(2'000), Touch::none, false), 0U);
  EXPECT_EQ(bits.next(camera_time(4'000), Touch::press, false), 0b011U);
  EXPECT_EQ(bits.next(camera_time(6'000), Touch::slip, false), 0b101U);
  EXPECT_EQ(bits.next(camera_time(8'000), Touch::none, false), 0U);
}

TEST(RobotBits, StayForAsLongAsTheyShall) {
  RobotBits bits({both}, {.never = false, .hold = 4ms});
  EXPECT_EQ(bits.next(camera_time(2'000), Touch::slip, false), 1U);
  EXPECT_EQ(bits.next(camera_time(4'000), Touch::none, false), 1U);
  EXPECT_EQ(bits.next(camera_time(6'000), Touch::none, false), 1U);
  EXPECT_EQ(bits.next(camera_time(8'000), Touch::none, false), 0U);
}

TEST(RobotBits, FallWhereNothingIsKnownAnyMoreUnlessTheyNeverDo) {
  RobotBits bits({both}, {.never = false, .hold = 1s});
  bits.next(camera_time(2'000), Touch::slip, false);
  EXPECT_EQ(bits.forget(), 0U);
  RobotBits latched({both}, {.never = true, .hold = {}});
  latched.next(camera_time(2'000), Touch::slip, false);
  EXPECT_EQ(latched.next(camera_time(60'000'000), Touch::none, false), 1U);
  EXPECT_EQ(latched.forget(), 1U);
}

TEST(RobotBits, RiseAtASlipThatIsConfirmed) {
  RobotBits bits({both, slip, confirmed}, {});
  EXPECT_EQ(bits.next(camera_time(2'000), Touch::slip, false), 0b011U);
  EXPECT_EQ(bits.next(camera_time(4'000), Touch::slip, true), 0b111U);
  EXPECT_EQ(bits.next(camera_time(6'000), Touch::none, false), 0U);
}

}  // namespace
}  // namespace tactile::detect
