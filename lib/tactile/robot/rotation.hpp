#pragma once

#include <array>

namespace tactile::robot {

/// A rotation in the base frame: axis times angle [rad], the angle at most pi. Of a half turn either sign is right.
using RotationVector = std::array<double, 3>;

/// The same as x, y, z, w: sin(angle / 2) times the axis, then cos(angle / 2). A rotation has two, of opposite signs.
using Quaternion = std::array<double, 4>;

RotationVector rotation_vector_of(const Quaternion& rotation);

/// The rotation that leads from `before` to `after`.
RotationVector turn_from_to(const RotationVector& before, const RotationVector& after);
RotationVector turn_from_to(const Quaternion& before, const Quaternion& after);

}  // namespace tactile::robot
