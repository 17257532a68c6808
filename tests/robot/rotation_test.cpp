#include "tactile/robot/rotation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tactile/core/random.hpp"

namespace tactile::robot {
namespace {

void expect_vector(const RotationVector& rotation, const RotationVector& expected, double tolerance = 1e-12) {
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(rotation[i], expected[i], tolerance) << i;
}

TEST(RotationVector, IsAxisTimesTheSmallerAngle) {
  expect_vector(rotation_vector_of({0, 0, 0, 1}), {0, 0, 0});
  expect_vector(rotation_vector_of({0, 0, std::sin(0.25), std::cos(0.25)}), {0, 0, 0.5});
  expect_vector(rotation_vector_of({0, 0, -std::sin(0.25), -std::cos(0.25)}), {0, 0, 0.5});
  expect_vector(rotation_vector_of({0, 1, 0, 0}), {0, std::numbers::pi, 0});
  expect_vector(rotation_vector_of({1e-13, 0, 0, 1}), {2e-13, 0, 0}, 1e-25);
}

TEST(TurnFromTo, LeadsFromTheOneToTheOther) {
  // A quarter about x, then a quarter about the base's z: what leads there is the quarter about z.
  const double h = std::sqrt(0.5);
  const Quaternion about_x{h, 0, 0, h}, about_both{0.5, 0.5, 0.5, 0.5};
  constexpr double quarter = std::numbers::pi / 2;
  expect_vector(turn_from_to(about_x, about_both), {0, 0, quarter});
  expect_vector(turn_from_to(RotationVector{quarter, 0, 0}, rotation_vector_of(about_both)), {0, 0, quarter});
}

TEST(TurnFromTo, OfNoRotationIsTheRotationUpToAHalfTurn) {
  Random random(3);
  for (const double angle : {0.0, 1e-300, 1e-12, 1e-7, 1e-3, 1.0, 2.6, 3.0, 3.1415, std::numbers::pi - 1e-7}) {
    for (int i = 0; i < 20; ++i) {
      RotationVector v{random.normal(), random.normal(), i % 3 == 0 ? 0.0 : random.normal()};
      const double size = std::hypot(v[0], v[1], v[2]);
      for (double& part : v) part *= angle / size;
      expect_vector(turn_from_to(RotationVector{}, v), v, 1e-8);
      expect_vector(turn_from_to(v, v), {0, 0, 0});
    }
  }
}

}  // namespace
}  // namespace tactile::robot
