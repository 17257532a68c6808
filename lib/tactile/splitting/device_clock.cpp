#include "tactile/splitting/device_clock.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <utility>

#include "tactile/alignment/clock_anchors.hpp"
#include "tactile/alignment/motion_phases.hpp"
#include "tactile/alignment/run_signals.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/table_file.hpp"
#include "tactile/events/camera_streams.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile::splitting {
namespace {

constexpr microseconds longest_related = std::chrono::hours(1);  ///< a longer recording is not compared with the log's motions

bool has_host_times(const std::filesystem::path& log) {
  return TableFile(log, {.name = "a log", .header = "host_time_us", .ends_in_any_bytes = true}).find("host_time_us").has_value();
}

/// By camera time.
std::vector<alignment::CameraArrival> arrivals_of(const SplitSource& source) {
  if (!source.info) return {};
  std::vector<alignment::CameraArrival> arrivals = alignment::arrivals_in(*source.info);
  std::stable_sort(arrivals.begin(), arrivals.end(), [](const auto& a, const auto& b) { return a.camera < b.camera; });
  return arrivals;
}

std::optional<labels::Labels> labels_of(const SplitSource& source) {
  return source.labels ? std::optional(labels::read_labels(*source.labels)) : std::nullopt;
}

DeviceClock by_label(const alignment::FittedClock& fitted) {
  return {.relation = fitted.relation, .within = fitted.uncertainty(), .how = "labels.json of the whole recording"};
}

/// By the motions in log and recording.
DeviceClockSearch by_motion(const robot::RobotLog& log, const std::vector<alignment::MotionPhase>& motions,
                            events::RecordingReader& recording, std::int32_t event_stream, const alignment::EventRate& rate,
                            const alignment::QuietRate& quiet) {
  if (between(rate.begin, rate.last) > longest_related) {
    return {.clock = {},
            .why_not =
                fmt::format("the recording is longer than {} h and has no host times", longest_related / std::chrono::hours(1))};
  }
  const std::vector<events::ImuSample> imu = imu_of(recording, event_stream);
  const alignment::FoundAnchors found = alignment::clock_anchors(
      {.robot = log, .motions = motions, .rate = rate, .quiet = quiet, .imu = imu, .host_from_camera = {}, .coarse = {}});
  if (found.anchors.empty())
    return {.clock = {},
            .why_not = found.doubts.empty() ? "log and recording show no common motion" : found.doubts.front().words};
  const std::int64_t first = us_of(log.states.front().t), last = us_of(log.states.back().t);
  alignment::ClockFitOptions options;
  options.middle_us = first + (last - first) / 2;
  const alignment::ClockFit fit = alignment::fit_clock(found.anchors, first, options);
  if (!fit.clock) return {.clock = {}, .why_not = fit.refused};
  return {.clock = DeviceClock{.relation = fit.clock->relation,
                               .within = fit.clock->uncertainty(),
                               .how = "motions in log and recording (" + fit.clock->method + ")"}};
}

/// Adds the lifts and taps of one piece of the log, in camera time.
void add_moves(const robot::RobotLog& log, const std::vector<alignment::MotionPhase>& motions, DeviceClockSearch& found) {
  const DeviceClock& clock = *found.clock;
  const auto camera_at = [&](RobotTime t) {
    if (!clock.is_by_host()) return clock.camera_at(us_of(t));
    const auto next = std::lower_bound(log.states.begin(), log.states.end(), t,
                                       [](const robot::RobotState& state, RobotTime at) { return state.t < at; });
    const robot::RobotState& row = next == log.states.end() ? log.states.back() : *next;
    return row.host_time ? clock.camera_at(us_of(*row.host_time)) : CameraTime::min();
  };
  for (const alignment::MotionPhase& motion : motions) {
    if (motion.kind != alignment::MotionKind::lift && motion.kind != alignment::MotionKind::tap) continue;
    const ArmMove move{.start = camera_at(motion.start), .end = camera_at(motion.end), .uncertainty = clock.within};
    (motion.kind == alignment::MotionKind::lift ? found.lifts : found.taps)->push_back(move);
  }
}

}  // namespace

std::vector<events::ImuSample> imu_of(events::RecordingReader& recording, std::int32_t event_stream) {
  const std::vector<events::Stream> streams = events::camera_streams(recording.streams(), recording.stream(event_stream));
  std::vector<events::ImuSample> all;
  for (const events::PacketRecord& packet : recording.packets()) {
    const bool is_of_imu = std::any_of(streams.begin(), streams.end(), [&](const events::Stream& stream) {
      return stream.id == packet.stream_id && stream.type == events::StreamType::imu;
    });
    if (!is_of_imu) continue;
    const std::vector<events::ImuSample> samples = recording.read_imu(packet);
    all.insert(all.end(), samples.begin(), samples.end());
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
  return all;
}

std::int64_t DeviceClock::device_us_at(CameraTime t) const {
  if (!is_by_host()) return relation.clock_us_from(t);
  // The nearest arrival: so the clocks' drift does not add up.
  const auto later = std::lower_bound(arrivals.begin(), arrivals.end(), t,
                                      [](const alignment::CameraArrival& a, CameraTime at) { return a.camera < at; });
  const auto nearest = later == arrivals.end()                                            ? std::prev(later)
                       : later == arrivals.begin()                                        ? later
                       : between(std::prev(later)->camera, t) < between(t, later->camera) ? std::prev(later)
                                                                                          : later;
  return saturating_add(us_of(nearest->host), between(nearest->camera, t).count());
}

CameraTime DeviceClock::camera_at(std::int64_t us) const {
  if (!is_by_host()) return relation.camera_from(us);
  const auto nearest = std::min_element(arrivals.begin(), arrivals.end(), [us](const auto& a, const auto& b) {
    return std::abs(saturating_subtract(us_of(a.host), us)) < std::abs(saturating_subtract(us_of(b.host), us));
  });
  return after(nearest->camera, microseconds{saturating_subtract(us, us_of(nearest->host))});
}

DeviceClockSearch find_robot_clock(const SplitSource& source, events::RecordingReader& recording, std::int32_t event_stream,
                                   const alignment::EventRate& rate, const alignment::QuietRate& quiet) {
  const robot::RobotLogFile log = robot::read_robot_log(*source.robot, {.arm = {}, .columns = source.robot_columns});
  if (log.pieces.empty()) return {.clock = {}, .why_not = "the log has no row"};
  std::vector<std::vector<alignment::MotionPhase>> motions;
  for (const robot::RobotLog& piece : log.pieces) motions.push_back(alignment::motion_phases(piece));
  DeviceClockSearch found;
  const auto labels = labels_of(source);
  if (auto arrivals = arrivals_of(source); !arrivals.empty() && source.robot_columns.empty() && has_host_times(*source.robot)) {
    found.clock = DeviceClock{.arrivals = std::move(arrivals), .within = 100ms, .how = "host times"};
  } else if (log.pieces.size() > 1) {
    found.why_not = "the robot's clock restarts within the log, and there are no host times";
  } else if (labels && labels->robot_clocks.size() == 1) {
    found.clock = by_label(labels->robot_clocks.front());
  } else {
    found = by_motion(log.pieces.front(), motions.front(), recording, event_stream, rate, quiet);
  }
  if (!found.clock) return found;
  found.lifts.emplace();
  found.taps.emplace();
  for (std::size_t i = 0; i < log.pieces.size(); ++i) add_moves(log.pieces[i], motions[i], found);
  return found;
}

DeviceClockSearch find_film_clock(const SplitSource& source) {
  std::vector<alignment::CameraArrival> arrivals = arrivals_of(source);
  if (!arrivals.empty() && source.video_times && has_host_times(*source.video_times))
    return {.clock = DeviceClock{.arrivals = std::move(arrivals), .within = 100ms, .how = "host times"}};
  if (const auto labels = labels_of(source); labels && labels->video_clock) return {.clock = by_label(*labels->video_clock)};
  return {.clock = {}, .why_not = "there are no host times, and no labels of the whole recording"};
}

}  // namespace tactile::splitting
