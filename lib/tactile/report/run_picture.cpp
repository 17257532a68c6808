#include "tactile/report/run_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "tactile/core/error.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile {
namespace {

void add_robot(LabelPicture& picture, const RobotLog& log) {
  const std::vector<FittedClock>& clocks = picture.labels.robot_clocks;
  if (clocks.empty() || log.states.empty()) return;
  // Each piece of the log has a clock of its own, which counts from the piece's first stamp.
  const auto own = std::find_if(clocks.begin(), clocks.end(), [&](const FittedClock& clock) {
    return clock.relation.reference_us == us_of(log.states.front().t);
  });
  const ClockRelation& clock = own != clocks.end() ? own->relation : clocks.front().relation;
  Trace speed{.kind = TraceKind::tcp_speed, .name = "speed"}, height{.kind = TraceKind::tcp_height, .name = "height"};
  for (const RobotState& state : log.states) {
    speed.t.push_back(clock.camera_from(state.t));
    speed.values.push_back(1e3 * std::hypot(state.tcp_speed[0], state.tcp_speed[1], state.tcp_speed[2]));
    height.values.push_back(1e3 * (state.tcp_pose[2] - log.states.front().tcp_pose[2]));
  }
  height.t = speed.t;
  std::uint64_t changing = 0;
  for (const RobotState& state : log.states)
    changing |= state.digital_output_bits.value_or(0) ^ log.states.front().digital_output_bits.value_or(0);
  for (int bit = 0; bit < 64; ++bit) {
    if ((changing >> bit & 1U) == 0) continue;
    Trace output{.kind = TraceKind::stage_output, .name = "digital output " + std::to_string(bit)};
    for (const RobotState& state : log.states) {
      output.t.push_back(clock.camera_from(state.t));
      output.values.push_back(static_cast<double>(state.digital_output_bits.value_or(0) >> bit & 1U));
    }
    picture.traces.push_back(std::move(output));
  }
  picture.traces.push_back(std::move(speed));
  picture.traces.push_back(std::move(height));
}

/// What the IMU feels beyond its rest, which is gravity and its bias.
void add_imu(LabelPicture& picture, RecordingReader& recording) {
  const auto stream = std::find_if(recording.streams().begin(), recording.streams().end(),
                                   [](const Stream& s) { return s.type == StreamType::imu; });
  if (stream == recording.streams().end()) return;
  std::array<Trace, 3> axes;
  const std::array<const char*, 3> names{"x", "y", "z"};
  for (std::size_t k = 0; k < axes.size(); ++k) axes[k] = {.kind = TraceKind::acceleration, .name = names[k]};
  for (const PacketRecord& packet : recording.packets()) {
    if (packet.stream_id != stream->id) continue;
    for (const ImuSample& sample : recording.read_imu(packet)) {
      if (!axes[0].t.empty() && sample.t <= axes[0].t.back()) continue;
      for (std::size_t k = 0; k < axes.size(); ++k) {
        axes[k].t.push_back(sample.t);
        axes[k].values.push_back(static_cast<double>(sample.acceleration_g[k]));
      }
    }
  }
  for (Trace& axis : axes) {
    if (axis.values.empty()) return;
    std::vector<double> sorted = axis.values;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    for (double& value : axis.values) value -= sorted[sorted.size() / 2];
    picture.traces.push_back(std::move(axis));
  }
}

}  // namespace

LabelPicture picture_of(const RunFolder& run, const Labels& labels, const EventRateOptions& options) {
  LabelPicture picture;
  picture.title = run.name();
  picture.labels = labels;
  RecordingReader recording(run.events());
  picture.rate = event_rate(recording, event_stream(recording).id, options);
  picture.begin = picture.rate.begin;
  picture.end = picture.rate.last;
  add_imu(picture, recording);
  if (std::filesystem::exists(run.info())) {
    const RunInfo info = read_run_info(run);
    if (info.simulated) picture.title += " (simulated)";
  }
  if (std::filesystem::exists(run.robot())) {
    try {
      add_robot(picture, read_robot_log(run.robot()));
    } catch (const Error& e) {
      picture.remarks.push_back(e.what());
    }
  }
  return picture;
}

}  // namespace tactile
