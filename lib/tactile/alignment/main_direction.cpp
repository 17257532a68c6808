#include "tactile/alignment/main_direction.hpp"

#include <Eigen/Eigenvalues>

namespace tactile::alignment {

MainDirection main_direction(std::span<const std::array<double, 3>> vectors) {
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  for (const auto& vector : vectors) {
    const Eigen::Map<const Eigen::Vector3d> v(vector.data());
    moments += v * v.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> found(moments);
  const Eigen::Vector3d squares = found.eigenvalues(), axis = found.eigenvectors().col(2);  // ascending
  if (!(squares[2] > 0)) return {};
  return {.axis = {axis[0], axis[1], axis[2]}, .along = squares[2], .across = squares[0] + squares[1]};
}

}  // namespace tactile::alignment
