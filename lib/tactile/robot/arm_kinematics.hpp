#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace tactile::robot {

enum class ArmModel { ur10, ur10e };

std::string_view name_of(ArmModel model);  ///< "UR10", "UR10e"

/// "ur10e", in upper or lower case; nothing for any other name.
std::optional<ArmModel> arm_model_named(std::string_view name);

/// Where the arm's flange is: x y z [m], then its rotation vector [rad], in the controller's base frame. Without a tool set at
/// the controller this is `actual_TCP_pose`, except for the arm's own calibration, of some mm.
///
///   T = prod_i Rz(q_i) Tz(d_i) Tx(a_i) Rx(alpha_i),   alpha = pi/2 0 0 pi/2 -pi/2 0
///
///   UR10:  d = 0.1273 0 0 0.163941 0.1157 0.0922 m,  a = 0 -0.612 -0.5723 0 0 0 m
///   UR10e: d = 0.1807 0 0 0.17415 0.11985 0.11655 m, a = 0 -0.6127 -0.57155 0 0 0 m
///
/// @param joints  base, shoulder, elbow, wrists 1 to 3 [rad]
/// Source: Universal Robots, "DH parameters for calculations of kinematics and dynamics".
std::array<double, 6> flange_pose(ArmModel model, const std::array<double, 6>& joints);

}  // namespace tactile::robot
