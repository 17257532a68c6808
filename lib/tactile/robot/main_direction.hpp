#pragma once

#include <array>
#include <span>

namespace tactile {

struct MainDirection {
  std::array<double, 3> axis{0, 0, 1};  ///< unit vector; its sign says nothing
  double along = 0;                     ///< sum of the squares of what the vectors have along it
  double across = 0;                    ///< and of the rest
};

/// The direction in which most of the vectors goes: the eigenvector of the largest eigenvalue of sum v v^T. The default where
/// they all are 0.
MainDirection main_direction(std::span<const std::array<double, 3>> vectors);

}  // namespace tactile
