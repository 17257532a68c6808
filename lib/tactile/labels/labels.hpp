#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/clock_relation.hpp"
#include "tactile/core/touch.hpp"

namespace tactile {

/// A time and its 95 % interval.
struct UncertainTime {
  CameraTime at{};
  CameraTime low{};
  CameraTime high{};
};

/// What each source says of an onset, in camera time; nothing where it says nothing.
struct Evidence {
  std::optional<CameraTime> events, robot, video, imu;
};

struct LabelledInterval {
  std::string id = {};  ///< unique in its run, such as "press-1"; kept wherever the interval goes, so that it is known again
  Touch touch = Touch::none;
  UncertainTime start, end;
  std::string source;  ///< what the onset was taken from: "events", or "person" once somebody has made or moved it
  Evidence evidence;
  bool confirmed = false;  ///< a person has looked at it

  TouchInterval interval() const { return {touch, start.at, end.at}; }
};

/// A clock as it was found, and how well.
struct FittedClock {
  ClockRelation relation;
  double residual_us = 0;          ///< robust standard deviation at the anchors
  std::int64_t offset_low_us = 0;  ///< 95 % interval of `relation.offset_us`, in the run's middle
  std::int64_t offset_high_us = 0;
  int anchors = 0;
  std::string method;
  std::optional<CameraTime> from = {}, to = {};  ///< where it holds, of a clock that starts anew within the run
};

/// What a person should look at: one interval, or the whole run.
struct LabelFlag {
  std::optional<std::size_t> interval_index;
  std::string reason;
  bool confirmed = false;  ///< looked at and found well: lifts the flag
};

struct Labels {
  std::vector<LabelledInterval> intervals;  ///< by start; never overlapping
  std::vector<FittedClock> robot_clocks;    ///< one for each unbroken piece of the robot log that could be related, by time
  std::optional<FittedClock> video_clock;
  std::vector<LabelFlag> flags;
  std::vector<TouchInterval>
      rejected;  ///< what a person took away: an interval of the class that overlaps one is not found again
  nlohmann::json provenance = nlohmann::json::object();  ///< settings and hashes of what they were made from

  bool run_is_flagged() const;                        ///< a flag on the whole run stands
  bool interval_is_flagged(std::size_t index) const;  ///< a flag on this interval stands

  /// The piece of the robot's clock that holds at `t`, else the one nearest to it; nothing if there is none.
  const FittedClock* robot_clock_at(CameraTime t) const;
};

/// Gives every interval that has no id one: its class and the least number from 1 that is free, in order.
void name_intervals(std::vector<LabelledInterval>& intervals);

/// Intervals without an id are named. @throws Error  if the file is missing or not of labels, or its intervals overlap or share
/// an id
Labels read_labels(const std::filesystem::path& file);
void write_labels(const std::filesystem::path& file, const Labels& labels);

}  // namespace tactile
