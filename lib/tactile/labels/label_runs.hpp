#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tactile/alignment/run_signals.hpp"
#include "tactile/core/progress.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/labels/label_run.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile::labels {

struct LabelRunsOptions {
  LabelOptions label{};
  bool force = false;    ///< label unchanged runs again, and discard a person's edits
  unsigned threads = 0;  ///< 0: as many as the machine has cores

  /// Whether the files that are made in addition to `labels.json` exist and are not older; else the run is labelled again. Empty:
  /// there are none.
  std::function<bool(const RunFolder&)> has_companions = {};
  /// Called for each labelled run once its `labels.json` is written; from several threads at once. What it throws becomes the
  /// run's error.
  std::function<void(const alignment::RunSignals&, const Labels&)> make_companions = {};
};

/// The result of one run.
struct RunOutcome {
  RunFolder run;
  Labels labels;           ///< as in `labels.json`; empty if there was an error
  bool unchanged = false;  ///< the labels exist and have the same files and settings: they were kept
  std::string error;       ///< why it could not be labelled; empty if it was
};

/// Labels runs and writes `labels.json` into each folder, whole or not at all. Runs of one session share their clocks: what all
/// of its runs in the data folder say counts, requested or not. A person's edits stay. The result does not depend on the
/// number of threads.
/// @return in the order of `runs`
std::vector<RunOutcome> label_runs(const std::vector<RunFolder>& runs, const LabelRunsOptions& options = {},
                                   const ProgressCallback& progress = {});

}  // namespace tactile::labels
