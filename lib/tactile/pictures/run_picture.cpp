#include "tactile/pictures/run_picture.hpp"

#include <array>
#include <cmath>
#include <set>
#include <string>

#include "tactile/core/robust_statistics.hpp"

namespace tactile::pictures {
namespace {

/// An output's value over time: from its first change on, and what it was before that.
Trace trace_of(const std::string& output, const robot::RobotLog& log, const ClockRelation& clock) {
  Trace trace{.kind = TraceKind::stage_output, .name = output};
  const auto add = [&](RobotTime t, std::int64_t value) {
    trace.t.push_back(clock.camera_from(t));
    trace.values.push_back(static_cast<double>(value));
  };
  for (const robot::OutputChange& change : log.output_changes) {
    if (change.output != output) continue;
    if (trace.t.empty()) add(log.states.front().t, change.from);
    add(change.at, change.to);
  }
  add(log.states.back().t, static_cast<std::int64_t>(trace.values.back()));
  return trace;
}

void add_robot(LabelPicture& picture, const robot::RobotLog& log) {
  const alignment::FittedClock* own = picture.labels.robot_clock_of(log.states.front().t);
  if (own == nullptr) return;
  const ClockRelation& clock = own->relation;
  std::set<std::string> outputs;
  for (const robot::OutputChange& change : log.output_changes) outputs.insert(change.output);
  for (const std::string& output : outputs) picture.traces.push_back(trace_of(output, log, clock));

  Trace speed{.kind = TraceKind::tcp_speed, .name = "speed"}, height{.kind = TraceKind::tcp_height, .name = "height"};
  for (const robot::RobotState& state : log.states) {
    speed.t.push_back(clock.camera_from(state.t));
    speed.values.push_back(1e3 * std::hypot(state.tcp_speed[0], state.tcp_speed[1], state.tcp_speed[2]));
    height.values.push_back(1e3 * (state.tcp_pose[2] - log.states.front().tcp_pose[2]));
  }
  height.t = speed.t;
  picture.traces.push_back(std::move(speed));
  picture.traces.push_back(std::move(height));
}

/// What the IMU feels beyond its rest, which is gravity and its bias.
void add_imu(LabelPicture& picture, const std::vector<events::ImuSample>& samples) {
  constexpr std::array<const char*, 3> names{"x", "y", "z"};
  for (std::size_t k = 0; k < names.size() && !samples.empty(); ++k) {
    Trace axis{.kind = TraceKind::acceleration, .name = names[k]};
    for (const events::ImuSample& sample : samples) {
      if (!axis.t.empty() && sample.t <= axis.t.back()) continue;
      axis.t.push_back(sample.t);
      axis.values.push_back(static_cast<double>(sample.acceleration_g[k]));
    }
    const double rest = median(axis.values);
    for (double& value : axis.values) value -= rest;
    picture.traces.push_back(std::move(axis));
  }
}

void add_video(LabelPicture& picture, const alignment::MotionEnergy& energy) {
  if (!picture.labels.video_clock) return;
  const ClockRelation& clock = picture.labels.video_clock->relation;
  Trace trace{.kind = TraceKind::video_energy, .name = "film"};
  for (const alignment::MotionStep& step : energy.steps) {
    trace.t.push_back(clock.camera_from(step.middle()));
    trace.values.push_back(step.energy);
  }
  picture.traces.push_back(std::move(trace));
}

}  // namespace

LabelPicture picture_of(const alignment::RunSignals& signals, const labels::Labels& labels) {
  LabelPicture picture;
  picture.title = signals.run.name() + (signals.info.simulated ? " (simulated)" : "");
  picture.rate = signals.rate;
  picture.labels = labels;
  picture.begin = signals.rate.begin;
  picture.end = signals.rate.last;
  picture.remarks = labels.remarks;
  for (const robot::RobotLog& piece : signals.robot) add_robot(picture, piece);
  add_imu(picture, signals.imu);
  if (signals.video) add_video(picture, *signals.video);
  return picture;
}

}  // namespace tactile::pictures
