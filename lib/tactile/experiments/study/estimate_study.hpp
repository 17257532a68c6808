#pragma once

#include "tactile/experiments/estimate.hpp"
#include "tactile/experiments/study/study_options.hpp"

namespace tactile::study {

/// What a study would do, from its options and from what its folders hold. Measures this machine's speed in training, for a
/// second or two; writes nothing.
///
/// The times are estimates: other work may be slower or faster on this machine than its speed in training lets expect. What
/// exists is counted, and only trainings are checked against the options: a study makes again what does not fit them.
/// @throws Error  as `completed`, or if a dataset or a recording cannot be read
experiments::Estimate estimate_study(const StudyOptions& options);

}  // namespace tactile::study
