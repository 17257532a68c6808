#pragma once

#include <cstdint>
#include <vector>

#include "tactile/labels/posterior/run_states.hpp"
#include "tactile/labels/posterior/state_paths.hpp"

namespace tactile::labels {

/// Paths that were drawn with one offset of the robot's clock.
struct DrawnPaths {
  std::int64_t offset_us = 0;                 ///< without a log: 0
  std::vector<std::uint8_t> conditions = {};  ///< of the arm, in each bin
  std::vector<Path> paths = {};
};

/// Draws from the posterior of a run.
struct PathSample {
  const RunStates* states = nullptr;
  CameraTime begin{};
  microseconds bin{};
  std::size_t bins = 0;
  std::vector<DrawnPaths> drawn = {};  ///< by offset

  /// @param use  gets each path, and the paths that share its offset
  template <class Use>
  void for_all_paths(Use use) const {
    for (const DrawnPaths& one : drawn) {
      for (const Path& path : one.paths) use(path, one);
    }
  }

  double share_of_path() const {
    std::size_t count = 0;
    for (const DrawnPaths& one : drawn) count += one.paths.size();
    return 1.0 / static_cast<double>(count);
  }

  CameraTime begin_of(std::size_t b) const { return after(begin, bin * static_cast<std::int64_t>(b)); }
};

}  // namespace tactile::labels
