#pragma once

#include <array>
#include <cmath>

namespace tactile::alignment {

using Vector3 = std::array<double, 3>;

inline double dot(const Vector3& a, const Vector3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double length_of(const Vector3& v) { return std::hypot(v[0], v[1], v[2]); }

}  // namespace tactile::alignment
