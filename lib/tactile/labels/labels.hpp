#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/alignment/fitted_clock.hpp"
#include "tactile/labels/edit_history.hpp"
#include "tactile/labels/labelled_interval.hpp"

namespace tactile::labels {

struct Labels {
  std::vector<LabelledInterval> intervals;  ///< by start; never overlapping
  std::vector<TouchInterval> releases;      ///< motion of class none, by start: the skin leaves an object. No `none` sample
                                            ///< lies near one
  std::vector<alignment::FittedClock> robot_clocks;  ///< one per unbroken piece of the robot log that could be related, by time
  std::optional<alignment::FittedClock> video_clock;
  std::vector<LabelFlag> flags;
  std::vector<std::string> remarks;  ///< what is missing or unusual, but needs no check
  /// Removed by a person: an interval of the same class that overlaps one is not found again.
  std::vector<TouchInterval> rejected;
  EditHistory history;                                   ///< of a person's edits
  nlohmann::json provenance = nlohmann::json::object();  ///< the settings, and hashes of the files that the labels were made from

  bool run_is_flagged() const;                        ///< there is an unconfirmed flag on the whole run
  bool interval_is_flagged(std::size_t index) const;  ///< there is an unconfirmed flag on this interval

  /// The clock of the piece of the robot log with this first stamp; null if it could not be related.
  const alignment::FittedClock* robot_clock_of(RobotTime first_stamp) const;
  /// The piece of the robot's clock that holds at `t`, else the nearest; null if there is none.
  const alignment::FittedClock* robot_clock_at(CameraTime t) const;
};

/// Stretches with motion of no sure class: releases, and from each end that was found until its interval's end. No `none` sample
/// lies near them.
std::vector<TouchInterval> unclear_motion(const Labels& labels);

/// The SHA-256 of what learning and judging use of the labels: `touches_sha256` in docs/format/runs.md. Equal labels have the
/// same, whoever found them, and whatever edits led to them.
std::string touches_sha256(const Labels& labels);

/// A later touch ends the one before it. @param intervals  by start
void cut_overlaps(std::vector<LabelledInterval>& intervals);

/// Gives every interval without an id one: its class and the least free number from 1, in order.
void name_intervals(std::vector<LabelledInterval>& intervals);

/// Intervals without an id are named. @throws Error  if the file is missing or not of labels, its intervals overlap or share an
/// id, or it has times or clocks that no run has: docs/format/runs.md gives the limits
Labels read_labels(const std::filesystem::path& file);
/// The oldest edits leave the history where it would take more than 3 MiB: the file must stay below what `read_labels` takes.
void write_labels(const std::filesystem::path& file, const Labels& labels);

}  // namespace tactile::labels
