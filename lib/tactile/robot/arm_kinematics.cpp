#include "tactile/robot/arm_kinematics.hpp"

#include <Eigen/Geometry>
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

constexpr double quarter = std::numbers::pi / 2;
constexpr std::array<double, 6> alpha{quarter, 0, 0, quarter, -quarter, 0};

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
  Eigen::Isometry3d flange = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < 6; ++i) {
    flange.rotate(Eigen::AngleAxisd(joints[i], Eigen::Vector3d::UnitZ()));
    flange.translate(Eigen::Vector3d(links.a[i], 0, links.d[i]));
    flange.rotate(Eigen::AngleAxisd(alpha[i], Eigen::Vector3d::UnitX()));
  }
  const Eigen::AngleAxisd rotation(flange.linear());
  const Eigen::Vector3d place = flange.translation(), turn = rotation.angle() * rotation.axis();
  return {place[0], place[1], place[2], turn[0], turn[1], turn[2]};
}

}  // namespace tactile::robot
