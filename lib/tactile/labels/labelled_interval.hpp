#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

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
  bool confirmed = false;                  ///< a person has looked at it
  std::optional<double> probability = {};  ///< that it is a touch of this class; nothing if a person added it
  std::optional<CameraTime> visible = {};  ///< when the events show it by eye (`visible_onset`)

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

}  // namespace tactile::labels
