#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "tactile/alignment/event_rate.hpp"
#include "tactile/core/progress.hpp"
#include "tactile/core/time.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/labels/posterior/likely_touches.hpp"
#include "tactile/robot/robot_log.hpp"
#include "tactile/splitting/device_clock.hpp"

namespace tactile::splitting {

/// What happens in a recording of several runs, by the model of a run.
struct LongCourse {
  std::vector<labels::LikelyTouch> touches;  ///< more likely than not, each of its likeliest class, by start
  std::vector<TouchInterval> releases;
  std::vector<labels::LikelyRest> rests;  ///< a pause of the recording is one, in which everything is let go
  /// By the log's motions; nothing if the clock was known, the log has several pieces, or no part shows its motions surely.
  std::optional<DeviceClock> robot;
  double quiet_per_s = 0;  ///< [events/s] while nothing moves
};

struct LongCourseOptions {
  microseconds quiet{2'000'000};    ///< a rest that ends a run has this length, > 0,
  double let_go = 0.8;              ///< and a greater probability that nothing touches the skin at some time in it
  microseconds part{60'000'000};    ///< the model is applied to parts of about this length: noise drifts, and memory is limited
  microseconds silence{1'000'000};  ///< this long without any event, against the noise, nothing was recorded
};

/// Whether one run is over and another one may begin after it.
bool ends_run(const labels::LikelyRest& rest, const LongCourseOptions& options);

/// Applies the model of a run (`labels::RunInference`) to one part after another, in bins of the rate. A part begins where
/// everything is let go: in the last such rest of the part before it, which grows until it has one, to eight times the usual
/// length at most. The first part that shows the offset of the robot's clock within 50 ms limits it in those after it, where it
/// may differ by 100 ms from part to part.
/// @param rate   of the stream
/// @param log    of the robot, if there is one  @param clock  of it, if it is known
/// @throws Error  as reading events does
LongCourse long_course(events::RecordingReader& recording, std::int32_t stream, const alignment::EventRate& rate,
                       robot::RobotLogFile log, const std::optional<DeviceClock>& clock, const LongCourseOptions& options,
                       const ProgressCallback& progress = {});

}  // namespace tactile::splitting
