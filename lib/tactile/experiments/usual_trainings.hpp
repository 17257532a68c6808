#pragma once

#include "tactile/windows/dataset.hpp"

namespace tactile::experiments {

/// How many trainings of a setting there are where no number is given: 2 if all runs were simulated with the preset `tiny`, else
/// 5, the fewest that decide a claim.
unsigned usual_trainings(const windows::Dataset& dataset);

}  // namespace tactile::experiments
