#pragma once

#include "tactile/alignment/run_signals.hpp"
#include "tactile/alignment/video_clock.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/labels/posterior/run_posterior.hpp"

namespace tactile::labels {

/// The labels of a run by the model of it: the touches that are more likely than not. The film's clock follows from the robot's.
///
/// Flags: problems of the files; a touch whose class is less sure than 90 %, also one without a label; an onset that is known
/// within more than 80 ms; an onset before the recording; a film of another run.
Labels posterior_labels(const alignment::RunSignals& signals, const RunPosterior& posterior,
                        const alignment::VideoClockOptions& film = {});

}  // namespace tactile::labels
