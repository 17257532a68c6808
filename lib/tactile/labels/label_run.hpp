#pragma once

#include "tactile/core/run_folder.hpp"
#include "tactile/labels/label_options.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/labels/posterior/run_posterior.hpp"

namespace tactile::labels {

/// Finds press and slip in the signals of a run, in camera time:
///
/// 1. Bursts of the event rate without hot pixels are classified (`kinds_of`) by the arm's lifts and taps in camera time, and by
///    what they change in the picture. A burst that is neither press nor slip stays unlabelled.
/// 2. Onsets and ends follow by maximum likelihood from the events alone, so that no error of the clocks enters them.
/// 3. Robot, film and IMU are witnesses: the time that each gives for an onset is its evidence.
///
/// Doubts are flagged in words: problems of the files, a lift without slip, a missing press, onsets that the events do not
/// decide, sources that disagree, clocks that could not be related.
/// @param clocks  of this run, by `robot_clocks_of`
/// @throws Error  if the events cannot be read
/// Source: Faris et al., arXiv:2403.10120, section IV.
Labels label_signals(const alignment::RunSignals& signals, const alignment::RobotClocks& clocks,
                     const LabelOptions& options = {});

/// The same by a model of the run.
Labels label_signals(const alignment::RunSignals& signals, const RunPosterior& posterior, const LabelOptions& options = {});

/// The labels of one run by itself, from its events, robot log, film and run.json.
/// @throws Error  if events or robot log cannot be read
Labels label_run(const RunFolder& run, const LabelOptions& options = {});

}  // namespace tactile::labels
