#pragma once

#include "tactile/alignment/run_signals.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile::labels {

/// The labels of a run by the model of it (`run_posterior`): the touches that are more likely than not.
///
/// Flags: problems of the files; a touch whose class is less sure than 90 %, also one without a label; an onset that is known
/// within more than 60 ms; an onset before the recording.
/// @throws Error  if the events cannot be read
Labels posterior_labels(const alignment::RunSignals& signals);

}  // namespace tactile::labels
