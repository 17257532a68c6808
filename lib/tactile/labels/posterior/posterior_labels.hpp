#pragma once

#include "tactile/alignment/run_signals.hpp"
#include "tactile/alignment/video_clock.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/labels/posterior/run_posterior.hpp"

namespace tactile::labels {

/// What a person should look at.
struct DoubtLimits {
  double least_probability = 0.9;  ///< of a touch and its class, 0.5 to 1
  double widest_onset_ms = 80;     ///< 95 % interval of its onset, > 0
};

/// The labels of a run by the model of it: the touches that are more likely than not. The film's clock follows from the robot's.
///
/// Flags: problems of the files; a touch below the least probability, or one without a label that the limit does not rule out; an
/// onset that is not known well enough; an onset before the recording; a film of another run.
Labels posterior_labels(const alignment::RunSignals& signals, const RunPosterior& posterior, const DoubtLimits& limits = {},
                        const alignment::VideoClockOptions& film = {});

}  // namespace tactile::labels
