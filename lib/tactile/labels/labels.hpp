#pragma once

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/alignment/fitted_clock.hpp"
#include "tactile/core/doubt.hpp"
#include "tactile/core/touch.hpp"

namespace tactile::labels {

/// The onset by each source, in camera time; nothing where a source does not show it.
struct Evidence {
  std::optional<CameraTime> events, robot, video, imu;
};

struct LabelledInterval {
  std::string id = {};  ///< unique in its run, such as "press-1"; it identifies the interval in all formats
  Touch touch = Touch::none;
  alignment::UncertainTime start, end;
  std::string source;  ///< of the onset: "events", or "person" if a person made or moved it
  Evidence evidence;
  bool confirmed = false;  ///< a person has looked at it

  TouchInterval interval() const { return {touch, start.at, end.at}; }
};

/// How long both last at once; below 0 if they do not meet.
inline microseconds overlap(const TouchInterval& a, const TouchInterval& b) {
  return between(std::max(a.start, b.start), std::min(a.end, b.end));
}

/// A doubt that a person should check: about one interval, or the whole run.
struct LabelFlag {
  std::optional<std::size_t> interval_index;
  std::string reason;
  bool confirmed = false;  ///< a person found the label right: the flag no longer stands
  std::string key = {};    ///< kind and values, as `Doubt` has them; empty if an older version wrote the flag
};

/// @param interval_index  nothing: of the whole run
inline LabelFlag flag_of(Doubt doubt, std::optional<std::size_t> interval_index = std::nullopt) {
  return {.interval_index = interval_index, .reason = std::move(doubt.words), .key = std::move(doubt.key)};
}

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

/// Gives every interval without an id one: its class and the least free number from 1, in order.
void name_intervals(std::vector<LabelledInterval>& intervals);

/// Intervals without an id are named. @throws Error  if the file is missing or not of labels, or its intervals overlap or share
/// an id
Labels read_labels(const std::filesystem::path& file);
void write_labels(const std::filesystem::path& file, const Labels& labels);

}  // namespace tactile::labels
