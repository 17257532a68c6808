#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/windows/sample.hpp"

namespace tactile::evaluation {

/// The touches of a run: its labels and, of a simulated run, its truth.
struct RunTruth {
  std::vector<windows::SampledInterval> labels;     ///< by start; those whose labels are in doubt are not `used`
  bool has_labels = false, run_is_flagged = false;  ///< the file is there; it has an unconfirmed flag on the whole run
  std::vector<std::optional<CameraTime>> visible;   ///< of each of `labels`: when the events show it by eye
  std::vector<TouchInterval> releases;              ///< that `label` found
  std::vector<TouchInterval> unclear;               ///< releases, and where an end may lie: no `none` sample is near
  bool has_truth = false;                           ///< the rest is empty without
  std::vector<TouchInterval> true_ones;             ///< that labels should have
  std::vector<std::optional<CameraTime>> gross;     ///< of each of `true_ones`: first motion of object and tip against each other
  std::vector<TouchInterval> unlabelled;            ///< motion without labels that causes events
  std::vector<std::string> causes;                  ///< what each of `unlabelled` is: "release", "firm lift", ...
  std::optional<CameraTime> lift;                   ///< when the arm begins to lift
  std::string world;                                ///< the seed of the simulation; runs of one share their objects

  bool is_known() const { return has_truth || has_labels; }  ///< something can be judged by it
  std::vector<TouchInterval> all_labelled() const;
  std::vector<TouchInterval> used() const;
};

/// Reads labels.json and truth.json of a run; empty where there is none.
/// @param include_flagged  flagged intervals are used too
/// @throws Error  if one of them is damaged
RunTruth read_run_truth(const RunFolder& run, bool include_flagged = false);

/// The same run with its truth in the place of its labels: exact, none in doubt, without releases. Motion without labels is
/// unclear. @throws Error  if it has no truth
RunTruth with_truth_as_labels(const RunTruth& truth);

/// The same run with touches that begin when the events show them by eye, as the paper labelled: labels, and the true ones that
/// have a label. Others, and those without a visible onset, keep theirs.
RunTruth with_visible_onsets(RunTruth truth);

/// The class of the interval that contains the tick; none where there is no such interval.
Touch touch_at(CameraTime tick, std::span<const TouchInterval> intervals);

}  // namespace tactile::evaluation
