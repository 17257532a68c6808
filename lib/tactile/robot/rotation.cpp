#include "tactile/robot/rotation.hpp"

#include <Eigen/Geometry>

namespace tactile::robot {
namespace {

RotationVector vector_of(const Eigen::AngleAxisd& rotation) {
  const Eigen::Vector3d vector = rotation.angle() * rotation.axis();
  return {vector[0], vector[1], vector[2]};
}

Eigen::Quaterniond quaternion_of(const RotationVector& rotation) {
  const Eigen::Vector3d vector(rotation[0], rotation[1], rotation[2]);
  const double angle = vector.stableNorm();
  return angle > 0 ? Eigen::Quaterniond(Eigen::AngleAxisd(angle, vector / angle)) : Eigen::Quaterniond::Identity();
}

Eigen::Quaterniond quaternion_of(const Quaternion& rotation) {
  return Eigen::Quaterniond(rotation[3], rotation[0], rotation[1], rotation[2]);
}

template <class Rotation>
RotationVector turn(const Rotation& before, const Rotation& after) {
  return vector_of(Eigen::AngleAxisd(quaternion_of(after) * quaternion_of(before).conjugate()));
}

}  // namespace

RotationVector rotation_vector_of(const Quaternion& rotation) { return vector_of(Eigen::AngleAxisd(quaternion_of(rotation))); }

RotationVector turn_from_to(const RotationVector& before, const RotationVector& after) { return turn(before, after); }

RotationVector turn_from_to(const Quaternion& before, const Quaternion& after) { return turn(before, after); }

}  // namespace tactile::robot
