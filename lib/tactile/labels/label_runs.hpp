#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/labels/label_run.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/labels/run_signals.hpp"

namespace tactile {

struct LabelRunsOptions {
  LabelOptions label{};
  bool force = false;    ///< label again what has not changed, and forget what a person did
  unsigned threads = 0;  ///< 0: as many as the machine has cores

  /// Whether all that is made beside `labels.json` is there and not older; a run that lacks some is labelled again. Empty:
  /// nothing is.
  std::function<bool(const RunFolder&)> has_companions = {};
  /// Told of each run that was labelled, once its `labels.json` is written; from several threads at once. What it throws
  /// becomes the run's error.
  std::function<void(const RunSignals&, const Labels&)> make_companions = {};
};

/// What became of one run.
struct RunOutcome {
  RunFolder run;
  Labels labels;           ///< as `labels.json` has them now; empty if there was an error
  bool unchanged = false;  ///< its files, its session's and the settings are those of its labels: they were left alone
  std::string error;       ///< why it could not be labelled; the others were
};

/// Labels runs and writes `labels.json` into each folder, whole or not at all. Runs of one session share their clocks, which are
/// fitted to all of its runs in the data folder, be they asked for or not. What a person made, moved, confirmed or took away
/// stays. The result does not depend on the number of threads.
/// @return in the order of `runs`
std::vector<RunOutcome> label_runs(const std::vector<RunFolder>& runs, const LabelRunsOptions& options = {},
                                   const ProgressCallback& progress = {});

}  // namespace tactile
