#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/events/recording_writer.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile::test {

/// A burst of events, [start, end) in microseconds from the recording's start.
struct MadeBurst {
  double start_us = 0;
  double end_us = 0;
  double events_per_read_out = 40;
};

struct MadeRun {
  std::vector<MadeBurst> bursts;
  double length_us = 3'000'000;
  double noise_per_read_out = 3;
  int hot_pixels = 5;  ///< each fires at every third read-out
  std::uint64_t seed = 1;
};

inline constexpr std::int64_t made_camera_begin_us = 1'700'000'000'000'000;
inline double ms_from_begin(CameraTime t) { return static_cast<double>(us_of(t) - made_camera_begin_us) / 1000.0; }

/// In the place of a recording that is there.
inline void write_made_events(const std::filesystem::path& file, const MadeRun& made) {
  std::filesystem::remove(file);
  Random random(made.seed);
  events::RecordingWriter writer(file, {events::event_stream_declaration({64, 48}, "DVXplorer_TEST")});
  std::vector<events::Event> events;
  for (std::int64_t read_out = 0; read_out * 200 < static_cast<std::int64_t>(made.length_us); ++read_out) {
    const auto t = static_cast<double>(read_out) * 200.0;
    double mean = made.noise_per_read_out;
    for (const MadeBurst& burst : made.bursts) mean += burst.start_us <= t && t < burst.end_us ? burst.events_per_read_out : 0.0;
    const auto event_at = [&](std::uint64_t x, std::uint64_t y) {
      events::Event event;
      event.t = camera_time(made_camera_begin_us + read_out * 200);
      event.x = static_cast<std::int16_t>(x);
      event.y = static_cast<std::int16_t>(y);
      event.on = static_cast<std::uint8_t>(random.below(2));
      return event;
    };
    for (std::uint64_t n = random.poisson(mean); n > 0; --n) events.push_back(event_at(random.below(64), 10 + random.below(38)));
    for (int hot = 0; hot < made.hot_pixels && read_out % 3 == 0; ++hot)
      events.push_back(event_at(static_cast<std::uint64_t>(hot), 0));
  }
  writer.write_events(0, events);
  writer.close();
}

/// A lift from `start_us` (camera time from the recording's start) with UR's usual acceleration, on a robot clock that is
/// `offset_us` later.
inline robot::RobotLog made_lift(double start_us, double cruise_us, double speed_m_s, std::int64_t offset_us,
                                 double length_us = 3'000'000) {
  constexpr double acceleration = 1.2;
  const double ramp_us = speed_m_s / acceleration * 1e6;
  Random random(9);
  robot::RobotLog log;
  double height = 0.3;
  for (double t = 0; t < length_us; t += 8'000) {
    const double u = t - start_us;
    const double full = ramp_us + cruise_us;
    const double v = u < 0 || u > full + ramp_us ? 0.0
                     : u < ramp_us               ? speed_m_s * u / ramp_us
                     : u < full                  ? speed_m_s
                                                 : speed_m_s * (1 - (u - full) / ramp_us);
    height += v * 0.008;
    robot::RobotState state;
    state.t = RobotTime{microseconds{static_cast<std::int64_t>(t) + made_camera_begin_us - offset_us}};
    state.tcp_pose = {0.1, 0.2, height, 0, 0, 0};
    state.tcp_speed = {2e-4 * random.normal(), 2e-4 * random.normal(), v + 2e-4 * random.normal(), 0, 0, 0};
    log.states.push_back(state);
  }
  return log;
}

/// `DATA/fan/NAME` with these events, and the log if it has rows.
inline RunFolder write_made_run(const std::filesystem::path& data, const MadeRun& made, const robot::RobotLog& log,
                                const std::string& name = "01") {
  std::filesystem::create_directories(data / "fan" / name);
  const RunFolder run = run_folder_at(data / "fan" / name);
  write_made_events(run.events(), made);
  if (!log.states.empty()) robot::write_robot_log(run.robot(), log);
  write_run_info(run, {.object = "fan",
                       .run = name,
                       .session = "",
                       .simulated = true,
                       .complete = true,
                       .width = 64,
                       .height = 48,
                       .extra = nlohmann::json::object()});
  return run;
}

}  // namespace tactile::test
