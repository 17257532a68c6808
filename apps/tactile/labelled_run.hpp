#pragma once

#include "tactile/core/run_folder.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile::cli {

/// A run with its labels, for tables.
struct LabelledRun {
  RunFolder run;
  labels::Labels labels;
  CameraTime first_event{};
  CameraTime zero{};  ///< of the times in tables, as `zero_of_times`
};

}  // namespace tactile::cli
