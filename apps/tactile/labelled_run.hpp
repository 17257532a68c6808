#pragma once

#include "tactile/core/run_folder.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile {

/// A run with its labels, for tables.
struct LabelledRun {
  RunFolder run;
  Labels labels;
  CameraTime first_event{};  ///< zero of the times in tables
};

}  // namespace tactile
