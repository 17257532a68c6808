#include "tactile/robot/arm_kinematics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tactile/robot/rotation.hpp"

namespace tactile::robot {
namespace {

constexpr double quarter = std::numbers::pi / 2;

void expect_pose(const std::array<double, 6>& pose, const std::array<double, 6>& expected) {
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(pose[i], expected[i], 1e-9) << "part " << i;
}

// By hand: stretched out along -x, the wrist's offsets d4 and d6 go along -y and d5 downwards; the flange looks along -y, which
// is z turned by a quarter about x.
TEST(FlangePose, OfTheArmStretchedOut) {
  expect_pose(flange_pose(ArmModel::ur10, {}), {-0.612 - 0.5723, -0.163941 - 0.0922, 0.1273 - 0.1157, quarter, 0, 0});
  expect_pose(flange_pose(ArmModel::ur10e, {}), {-0.6127 - 0.57155, -0.17415 - 0.11655, 0.1807 - 0.11985, quarter, 0, 0});
}

// Upright, the wrist bent back: the links stand on each other, d5 upwards, and the turn is half of one about (0, 1, -1).
TEST(FlangePose, OfTheArmUpright) {
  const std::array<double, 6> home{0, -quarter, 0, -quarter, 0, 0};
  const double half = std::numbers::pi / std::sqrt(2.0);
  expect_pose(flange_pose(ArmModel::ur10, home), {0, -0.163941 - 0.0922, 0.1273 + 0.612 + 0.5723 + 0.1157, 0, half, -half});
  expect_pose(flange_pose(ArmModel::ur10e, home), {0, -0.17415 - 0.11655, 0.1807 + 0.6127 + 0.57155 + 0.11985, 0, half, -half});
}

TEST(FlangePose, TurnsAboutTheBaseWithTheFirstJoint) {
  const std::array<double, 6> joints{0, -1.1, 0.7, -0.4, 1.3, 0.2};
  std::array<double, 6> turned = joints;
  turned[0] = quarter;
  const auto pose = flange_pose(ArmModel::ur10e, joints), there = flange_pose(ArmModel::ur10e, turned);
  EXPECT_NEAR(there[0], -pose[1], 1e-12);
  EXPECT_NEAR(there[1], pose[0], 1e-12);
  EXPECT_NEAR(there[2], pose[2], 1e-12);
  const auto turn = turn_from_to(RotationVector{pose[3], pose[4], pose[5]}, RotationVector{there[3], there[4], there[5]});
  EXPECT_NEAR(turn[0], 0, 1e-12);
  EXPECT_NEAR(turn[1], 0, 1e-12);
  EXPECT_NEAR(turn[2], quarter, 1e-12);
}

TEST(ArmModel, IsFoundByItsName) {
  EXPECT_EQ(arm_model_named("UR10"), ArmModel::ur10);
  EXPECT_EQ(arm_model_named("ur10E"), ArmModel::ur10e);
  EXPECT_EQ(arm_model_named("ur5"), std::nullopt);
  EXPECT_EQ(name_of(ArmModel::ur10e), "UR10e");
}

}  // namespace
}  // namespace tactile::robot
