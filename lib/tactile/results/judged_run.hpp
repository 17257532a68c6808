#pragma once

#include <cstddef>
#include <string>

namespace tactile::results {

/// A run that a trained model was judged on.
struct JudgedRun {
  std::string object;
  std::string run{};         ///< its id within the object, "03"; without one it is a run of its own
  std::size_t training = 0;  ///< which of a study's trainings judged it, from 0
  std::string world{};       ///< the seed of a simulated world; empty for a lab's own data
};

}  // namespace tactile::results
