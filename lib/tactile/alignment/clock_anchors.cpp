#include "tactile/alignment/clock_anchors.hpp"

#include <algorithm>
#include <utility>

#include "tactile/alignment/arm_motion.hpp"
#include "tactile/alignment/event_anchors.hpp"
#include "tactile/alignment/host_anchors.hpp"
#include "tactile/alignment/imu_anchors.hpp"

namespace tactile::alignment {
namespace {

/// Adds what IMU, events and stage show.
void add_content_anchors(AnchorSearch& search) {
  const std::optional<ArmMotion> motion = arm_motion(search.inputs.robot, {.step = search.options.grid});
  if (!motion) {
    search.found.doubts.push_back(
        doubt("log-length", "the robot log is too short, or too long, to be matched with the recording"));
    return;
  }
  std::optional<double> shift_s;
  if (!search.inputs.imu.empty()) shift_s = add_imu_anchors(search, *motion);
  EventAnchors events(search);
  if (!shift_s && events.has_motion()) {
    shift_s = events.match();
    if (shift_s && !search.left_by_imu_s.empty()) add_imu_anchors_near(search, *shift_s);
  }
  if (shift_s) {
    events.add_anchors(*shift_s);
  } else if (events.has_commands()) {
    events.add_stage_anchors_alone();
  } else if (!events.has_motion()) {
    search.found.doubts.push_back(
        doubt("arm-rests", "the arm does not move, and no output changes: the recording shows nothing of the log"));
  }
  if (!search.found.anchors.empty() || !search.found.doubts.empty()) return;
  search.found.doubts.push_back(
      shift_s ? doubt("no-lift-at-events",
                      "the arm's motion matches the events, but no lift begins where they do: nothing relates its clock")
              : doubt("no-match", "nothing in the recording matches the arm's motion: nothing relates its clock"));
}

}  // namespace

FoundAnchors clock_anchors(const AnchorInputs& inputs, const AnchorOptions& options) {
  FoundAnchors none;
  if (inputs.robot.states.size() < 2 || inputs.rate.counts.empty()) {
    none.doubts.push_back(doubt("log-or-recording-empty", "the robot log or the recording is empty"));
    return none;
  }
  ClockOrigins origins{.robot = inputs.robot.states.front().t, .camera = inputs.rate.begin, .apart_us = 0};
  if (__builtin_sub_overflow(us_of(origins.camera), us_of(origins.robot), &origins.apart_us)) {
    none.doubts.push_back(doubt("clocks-apart", "the two clocks lie further apart than 64 bits of microseconds"));
    return none;
  }
  AnchorInputs known = inputs;
  std::vector<ClockAnchor> by_host = host_anchors(inputs);
  if (!by_host.empty()) {
    constexpr microseconds late = 250ms;
    const ClockAnchor& middle = by_host[by_host.size() / 2];
    known.coarse = CoarseOffset{saturating_subtract(us_of(middle.camera), middle.clock_us), late};
  }
  AnchorSearch search{.inputs = known, .options = options, .origins = origins, .found = {}};
  search.found.anchors = std::move(by_host);
  add_content_anchors(search);
  std::stable_sort(search.found.anchors.begin(), search.found.anchors.end(), [](const ClockAnchor& a, const ClockAnchor& b) {
    return std::pair(a.kind, a.clock_us) < std::pair(b.kind, b.clock_us);
  });
  return std::move(search.found);
}

}  // namespace tactile::alignment
