#include "tactile/simulation/simulated_run.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/video/video_times.hpp"
#include "tactile/video/video_writer.hpp"

namespace tactile {
namespace {

// Robot and video go on for a moment after the camera has stopped, as they began before it.
constexpr microseconds robot_after_end = 200ms;
constexpr microseconds video_after_end = 100ms;

}  // namespace

const SimulationPreset& simulation_preset(std::string_view name) {
  static const std::array presets{
      SimulationPreset{"tiny",
                       2,
                       {.quiet_s = {0.60, 0.75},
                        .travel_s = {0.15, 0.35},
                        .hold_s = {0.30, 0.42},
                        .lift_s = {0.35, 0.55},
                        .rest_s = {0.60, 0.80}}},
      SimulationPreset{"quick", 3, {}},
  };
  for (const SimulationPreset& preset : presets) {
    if (preset.name == name) return preset;
  }
  throw Error("'" + std::string(name) + "' is no preset of the simulation; expected tiny or quick");
}

EventCameraOptions simulated_camera_options() { return {}; }

CameraPixels simulated_camera_pixels(std::uint64_t seed) {
  return draw_camera_pixels(simulated_camera_options(), seed_for(seed, {"camera"}));
}

std::string simulated_camera_name(std::uint64_t seed) { return fmt::format("DVXplorer_SIM{:05}", seed % 100'000); }

nlohmann::json simulation_settings(const ObjectModel& object, std::string_view run, const SimulationPreset& preset,
                                   std::uint64_t seed) {
  const EventCameraOptions c = simulated_camera_options();
  const nlohmann::json camera = {{"width", c.size.width},
                                 {"height", c.size.height},
                                 {"readout_us", c.readout.count()},
                                 {"threshold", c.threshold},
                                 {"threshold_sigma", c.threshold_sigma},
                                 {"threshold_floor", c.threshold_floor},
                                 {"residual", c.residual},
                                 {"noise_hz", c.noise_hz},
                                 {"noise_spread_decades", c.noise_spread_decades},
                                 {"noise_on_share", c.noise_on_share},
                                 {"hot_pixels", c.hot_pixels},
                                 {"hot_min_hz", c.hot_min_hz},
                                 {"hot_max_hz", c.hot_max_hz},
                                 {"hot_kept_share", c.hot_kept_share},
                                 {"skin", c.skin},
                                 {"black", c.black},
                                 {"white", c.white},
                                 {"blur_px", c.blur_px}};
  return {{"model_version", simulation_model_version},
          {"object", object},
          {"run", run},
          {"preset", preset.name},
          {"timings", preset.timings},
          {"seed", seed},
          {"camera", camera}};
}

std::uint64_t DrawnRun::seed_for_use(std::string_view use) const { return seed_for(seed, {"run", object.name, run, use}); }

DrawnRun draw_run(const ObjectModel& object, std::string run, const SimulationPreset& preset, std::uint64_t seed) {
  DrawnRun drawn;
  drawn.object = object;
  drawn.run = std::move(run);
  drawn.preset = preset;
  drawn.seed = seed;
  Random for_plan(drawn.seed_for_use("plan")), for_clocks(drawn.seed_for_use("clocks")), for_motion(drawn.seed_for_use("motion"));
  drawn.plan = draw_run_plan(object, preset.timings, for_plan);
  drawn.clocks = draw_run_clocks(for_clocks);
  drawn.camera = simulated_camera_options();
  drawn.camera.veil = drawn.plan.veil;
  drawn.camera.noise_factor = drawn.plan.noise_factor;
  drawn.motion = move_skin(drawn.plan, drawn.camera.readout, for_motion);
  return drawn;
}

SkinFilm film_of(const DrawnRun& drawn, const CameraPixels& pixels) {
  return {drawn.motion, pixels, drawn.camera, drawn.start(), drawn.seed_for_use("camera")};
}

std::uint64_t write_robot(const std::filesystem::path& file, const DrawnRun& drawn, std::optional<CameraTime> until) {
  Random random(drawn.seed_for_use("robot"));
  LoggedRobot robot = log_robot(drawn.plan, drawn.clocks, random);
  if (until) {
    std::erase_if(robot.log.states,
                  [&](const RobotState& state) { return drawn.clocks.robot.camera_from(state.t) > *until + robot_after_end; });
  }
  write_robot_log(file, robot.log);
  return robot.dropped_packages;
}

void write_video(const std::filesystem::path& film, const std::filesystem::path& times, const DrawnRun& drawn,
                 std::optional<CameraTime> until) {
  Random random(drawn.seed_for_use("video"));
  std::vector<VideoTime> frames = draw_frame_times(drawn.plan, drawn.clocks, random);
  if (until) {
    std::erase_if(frames, [&](VideoTime t) { return drawn.clocks.video.camera_from(t) > *until + video_after_end; });
  }
  VideoWriter writer(film, {});
  for (const VideoTime t : frames) {
    const double t_s = 1e-6 * static_cast<double>(us_of(drawn.clocks.video.camera_from(t)) - drawn.clocks.camera_start_us);
    writer.write(draw_frame(drawn.object, drawn.plan, t_s, random), t);
  }
  writer.close();
  sync_to_disk(film);
  write_video_times(times, frames);
}

Truth truth_of(const DrawnRun& drawn, const FilmedSkin& filmed, std::optional<CameraTime> until) {
  const CameraTime start = drawn.start();
  const SkinMotion& motion = drawn.motion;
  Truth truth;
  truth.intervals.push_back({.interval = {Touch::press, start + motion.press_start, start + motion.press_end},
                             .gross = {},
                             .first_event = filmed.first_of_press});
  truth.intervals.push_back({.interval = {Touch::slip, start + motion.slip_start, start + motion.slip_end},
                             .gross = start + motion.gross,
                             .first_event = filmed.first_of_slip});
  truth.lift_start = start + motion.lift_start;
  if (until) {
    const auto is_later = [&](const std::optional<CameraTime>& t) { return t && *t > *until; };
    std::erase_if(truth.intervals, [&](const TrueInterval& interval) { return interval.interval.start >= *until; });
    for (TrueInterval& interval : truth.intervals) {
      interval.interval.end = std::min(interval.interval.end, *until);
      if (is_later(interval.gross)) interval.gross.reset();
      if (is_later(interval.first_event)) interval.first_event.reset();
    }
    if (is_later(truth.lift_start)) truth.lift_start.reset();
  }
  truth.robot_clock = drawn.clocks.robot;
  truth.video_clock = drawn.clocks.video;
  truth.parameters = {{"object", drawn.object},
                      {"plan", drawn.plan},
                      {"camera_start_us", drawn.clocks.camera_start_us},
                      {"settings", simulation_settings(drawn.object, drawn.run, drawn.preset, drawn.seed)}};
  return truth;
}

}  // namespace tactile
