#pragma once

#include <array>
#include <span>

namespace tactile::alignment {

struct MainDirection {
  std::array<double, 3> axis{0, 0, 1};  ///< unit vector; its sign has no meaning
  double along = 0;                     ///< sum of the squares of the vectors' components along it
  double across = 0;                    ///< of their other components
};

/// The main direction of vectors: the eigenvector of the largest eigenvalue of sum v v^T. The default where
/// they all are 0.
MainDirection main_direction(std::span<const std::array<double, 3>> vectors);

}  // namespace tactile::alignment
