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
  Touch touch = Touch::none;
  UncertainTime start, end;
  std::string source;  ///< what the onset was taken from, "events"
  Evidence evidence;
  bool confirmed = false;  ///< a person has looked at it

  TouchInterval interval() const { return {touch, start.at, end.at}; }
};

/// A clock as it was found, and how well.
struct FittedClock {
  ClockRelation relation;
  double residual_us = 0;  ///< robust standard deviation at the anchors
  int anchors = 0;
  std::string method;
};

/// What a person should look at: one interval, or the whole run.
struct LabelFlag {
  std::optional<std::size_t> interval_index;
  std::string reason;
  bool confirmed = false;  ///< looked at and found well: lifts the flag
};

struct Labels {
  std::vector<LabelledInterval> intervals;  ///< by start; never overlapping
  std::optional<FittedClock> robot_clock, video_clock;
  std::vector<LabelFlag> flags;
  nlohmann::json provenance = nlohmann::json::object();  ///< settings and hashes of what they were made from

  bool run_is_flagged() const;                        ///< a flag on the whole run stands
  bool interval_is_flagged(std::size_t index) const;  ///< a flag on this interval stands
};

/// @throws Error  if the file is missing or not of labels, or its intervals overlap
Labels read_labels(const std::filesystem::path& file);
void write_labels(const std::filesystem::path& file, const Labels& labels);

}  // namespace tactile
