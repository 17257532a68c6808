#pragma once

#include "tactile/core/run_folder.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile {

/// A run with its labels, as tables tell of it.
struct LabelledRun {
  RunFolder run;
  Labels labels;
  CameraTime first_event{};  ///< what times in tables count from
};

}  // namespace tactile
