#include "tactile/robot/arm_kinematics.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <string>

#include "tactile/core/text.hpp"

namespace tactile::robot {
namespace {

struct Links {
  std::array<double, 6> d, a;
};

constexpr Links ur10_links{{0.1273, 0, 0, 0.163941, 0.1157, 0.0922}, {0, -0.612, -0.5723, 0, 0, 0}};
constexpr Links ur10e_links{{0.1807, 0, 0, 0.17415, 0.11985, 0.11655}, {0, -0.6127, -0.57155, 0, 0, 0}};

// alpha is a quarter turn or none: its sine, and its cosine, exactly.
constexpr std::array<double, 6> alpha_sine{1, 0, 0, 1, -1, 0}, alpha_cosine{0, 1, 1, 0, 0, 1};

}  // namespace

std::string_view name_of(ArmModel model) { return model == ArmModel::ur10 ? "UR10" : "UR10e"; }

std::optional<ArmModel> arm_model_named(std::string_view name) {
  const std::string small = lower_case(name);
  if (small == "ur10") return ArmModel::ur10;
  if (small == "ur10e") return ArmModel::ur10e;
  return std::nullopt;
}

std::array<double, 6> flange_pose(ArmModel model, const std::array<double, 6>& joints) {
  const Links& links = model == ArmModel::ur10 ? ur10_links : ur10e_links;
  RotationMatrix r{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  std::array<double, 3> p{};
  for (std::size_t i = 0; i < 6; ++i) {
    const double c = std::cos(joints[i]), s = std::sin(joints[i]);
    for (std::size_t row = 0; row < 3; ++row) {
      const double x = c * r[row][0] + s * r[row][1];  // the axes, turned about z by the joint
      const double y = c * r[row][1] - s * r[row][0];
      const double z = r[row][2];
      p[row] += links.d[i] * z + links.a[i] * x;
      r[row] = {x, alpha_cosine[i] * y + alpha_sine[i] * z, alpha_cosine[i] * z - alpha_sine[i] * y};
    }
  }
  const std::array<double, 3> turn = rotation_vector_of(r);
  return {p[0], p[1], p[2], turn[0], turn[1], turn[2]};
}

std::array<double, 3> rotation_vector_of(const RotationMatrix& r) {
  // 2 sin(angle) times the axis, and the angle from both sine and cosine, each good where the other is not.
  const std::array<double, 3> twice_sine{r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]};
  const double sine = 0.5 * std::hypot(twice_sine[0], twice_sine[1], twice_sine[2]);
  const double cosine = 0.5 * (r[0][0] + r[1][1] + r[2][2] - 1.0);
  const double angle = std::atan2(sine, cosine);
  if (cosine > -0.9) {
    const double factor = sine > 1e-9 ? 0.5 * angle / sine : 0.5;
    return {factor * twice_sine[0], factor * twice_sine[1], factor * twice_sine[2]};
  }
  // Near half a turn R + R^T = 2 cos I + 2 (1 - cos) axis axis^T gives the axis, except for its sign.
  std::size_t k = 0;
  for (std::size_t i = 1; i < 3; ++i) k = r[i][i] > r[k][k] ? i : k;
  std::array<double, 3> axis{};
  for (std::size_t i = 0; i < 3; ++i) axis[i] = 0.5 * (r[i][k] + r[k][i]) - (i == k ? cosine : 0.0);
  const double size = std::hypot(axis[0], axis[1], axis[2]);
  const double along = axis[0] * twice_sine[0] + axis[1] * twice_sine[1] + axis[2] * twice_sine[2];
  for (double& part : axis) part *= (along < 0 ? -angle : angle) / size;
  return axis;
}

RotationMatrix rotation_matrix_of(const std::array<double, 3>& v) {
  const double angle = std::hypot(v[0], v[1], v[2]);
  const double a = angle > 1e-9 ? std::sin(angle) / angle : 1.0;
  const double b = angle > 1e-9 ? (1.0 - std::cos(angle)) / (angle * angle) : 0.5;
  const double c = std::cos(angle);
  return {{{c + b * v[0] * v[0], b * v[0] * v[1] - a * v[2], b * v[0] * v[2] + a * v[1]},
           {b * v[0] * v[1] + a * v[2], c + b * v[1] * v[1], b * v[1] * v[2] - a * v[0]},
           {b * v[0] * v[2] - a * v[1], b * v[1] * v[2] + a * v[0], c + b * v[2] * v[2]}}};
}

std::array<double, 3> turn_from_to(const RotationMatrix& before, const RotationMatrix& after) {
  RotationMatrix turn{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t k = 0; k < 3; ++k) turn[i][j] += after[i][k] * before[j][k];
    }
  }
  return rotation_vector_of(turn);
}

}  // namespace tactile::robot
