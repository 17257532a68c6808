#pragma once

#include "tactile/core/run_folder.hpp"
#include "tactile/labels/label_options.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/labels/posterior/run_posterior.hpp"

namespace tactile::labels {

/// The labels of a run, in camera time: the touches that are more likely than not by the model of the run
/// (docs/numerics/labels.md), with what each witness says of their onsets.
///
/// Flags: problems of the files; a touch below the least probability, or one without a label that the limit does not rule out; an
/// onset that is not known well enough, or lies outside the recording; a witness that contradicts: a film of another run, a
/// command to the stage that no press follows.
/// @param posterior  of this run
Labels label_signals(const alignment::RunSignals& signals, const RunPosterior& posterior, const LabelOptions& options = {});

/// The labels of one run by itself, from its events, robot log, film and run.json.
/// @throws Error  if events or robot log cannot be read
/// Source: Faris et al., arXiv:2403.10120, section IV.
Labels label_run(const RunFolder& run, const LabelOptions& options = {});

}  // namespace tactile::labels
