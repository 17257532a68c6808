#include "tactile/simulation/simulated_run.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tactile/core/fields.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_writer.hpp"
#include "tactile/simulation/simulated_imu.hpp"
#include "tactile/simulation/simulated_robot.hpp"
#include "tactile/simulation/simulated_video.hpp"
#include "tactile/video/video_times.hpp"
#include "tactile/video/video_writer.hpp"

namespace tactile::simulation {
namespace {

constexpr std::size_t objects_per_round = 10;

// Robot and video begin before the camera and end after it.
constexpr microseconds robot_after_end = 200ms;
constexpr microseconds video_after_end = 100ms;

int number_of(const std::string& run) { return static_cast<int>(whole_number_in(run).value_or(1)); }

/// The number of earlier runs of the camera, in the order of a lab: the first run of each object, then the second of each, ...
std::size_t runs_before(const SimulationPhysics& physics, const std::string& object, const std::string& run) {
  return static_cast<std::size_t>(number_of(run) - 1) * objects_per_round + physics.place_of(object);
}

TruePixel pixel_at(std::size_t index, events::SensorSize size, double hz) {
  const auto width = static_cast<std::size_t>(size.width);
  return {static_cast<int>(index % width), static_cast<int>(index / width), hz};
}

}  // namespace

CameraPixels camera_pixels_of(const DrawnRun& drawn) { return draw_camera_pixels(drawn.camera, drawn.pixels_seed); }

std::string simulated_camera_name(std::uint64_t seed) { return fmt::format("DVXplorer_SIM{:05}", seed % 100'000); }

nlohmann::json simulation_settings(const SimulationPhysics& physics, std::string_view object, std::string_view run,
                                   std::string_view preset, std::uint64_t seed) {
  nlohmann::json json = json_of_fields(physics);
  json.erase("presets");
  const SimulationPreset& size = physics.preset(preset);
  json["preset"] = {{"name", preset}, {"timings", json_of_fields(size.timings)}, {"special_runs", size.special_runs}};
  json["object"] = json_of_fields(physics.object(object));
  json["place"] = physics.place_of(object);
  json["run"] = run;
  json["seed"] = seed;
  json["model_version"] = simulation_model_version;
  return json;
}

std::uint64_t DrawnRun::seed_for_use(std::string_view use) const { return seed_for(seed, {"run", object.name, run, use}); }

DrawnRun draw_run(const SimulationPhysics& physics, std::string_view object, std::string run, std::string_view preset,
                  std::uint64_t seed, const std::optional<SessionCamera>& camera) {
  DrawnRun drawn;
  drawn.physics = &physics;
  drawn.object = physics.object(object);
  drawn.run = std::move(run);
  drawn.preset = preset;
  drawn.seed = seed;
  const SimulationPreset& size = physics.preset(preset);
  Random for_plan(drawn.seed_for_use("plan")), for_motion(drawn.seed_for_use("motion"));
  RunPlanOptions options = physics.plan_options(size, number_of(drawn.run));
  options.object_seed = seed_for(seed, {"object", drawn.object.name});
  drawn.plan = draw_run_plan(drawn.object, options, for_plan);
  drawn.clocks = clocks_of_run(physics.clocks, seed, drawn.object.name, options.run_number, longest_run_s(options));
  const SessionCamera of_session =
      camera ? *camera : session_camera(physics.camera, physics.sessions, seed, drawn.clocks.session);
  drawn.camera = of_session.options;
  drawn.pixels_seed = of_session.pixels_seed;
  drawn.camera.veil = drawn.plan.veil;
  drawn.camera.light_drift = drawn.plan.light_drift;
  drawn.camera.noise_factor = drawn.plan.noise_factor;
  drawn.camera.run_index = runs_before(physics, drawn.object.name, drawn.run);
  drawn.motion = move_skin(drawn.plan, view_of(drawn.camera), microseconds{std::llround(drawn.camera.readout_us)}, for_motion,
                           crossing_px(drawn.camera));
  return drawn;
}

SkinFilm film_of(const DrawnRun& drawn, const CameraPixels& pixels) {
  return {drawn.motion, pixels, drawn.camera, drawn.start(), drawn.seed_for_use("camera")};
}

events::Stream simulated_imu_stream(std::string source) {
  return {.id = 1,
          .type = events::StreamType::imu,
          .type_identifier = "IMUS",
          .source = std::move(source),
          .name = "imu",
          .size = {},
          .info = {}};
}

std::vector<events::ImuSample> imu_of(const DrawnRun& drawn) {
  Random random(drawn.seed_for_use("imu"));
  return feel_run(drawn.plan, drawn.start(), drawn.physics->imu, random);
}

std::uint64_t write_robot(const std::filesystem::path& file, const DrawnRun& drawn, std::optional<CameraTime> until) {
  Random random(drawn.seed_for_use("robot"));
  LoggedRobot robot = log_robot(drawn.plan, drawn.clocks, drawn.physics->robot, random);
  if (until) {
    std::erase_if(robot.log.states, [&](const robot::RobotState& state) {
      return drawn.clocks.robot.camera_from(state.t) > *until + robot_after_end;
    });
  }
  robot::write_robot_log(file, robot.log);
  return robot.dropped_packages;
}

void write_video(const std::filesystem::path& film, const std::filesystem::path& times, const DrawnRun& drawn,
                 std::optional<CameraTime> until) {
  SimulatedVideo video(drawn.object, drawn.plan, drawn.clocks, drawn.physics->video, Random(drawn.seed_for_use("video")));
  std::vector<VideoTime> frames = video.times();
  if (until) {
    std::erase_if(frames, [&](VideoTime t) { return drawn.clocks.video.camera_from(t) > *until + video_after_end; });
  }
  video::VideoWriter writer(film, {.quality = drawn.physics->video.quantiser, .fast = true});
  for (std::size_t i = 0; i < frames.size(); ++i) writer.write(video.draw(i), frames[i]);
  writer.close();
  sync_to_disk(film);
  video::write_video_times(times, frames);
}

Truth truth_of(const DrawnRun& drawn, const CameraPixels& pixels, const FilmedSkin& filmed, std::optional<CameraTime> until) {
  const CameraTime start = drawn.start();
  const SkinMotion& motion = drawn.motion;
  Truth truth;
  for (std::size_t i = 0; i < motion.motions.size(); ++i) {
    const MarkerMotion& moved = motion.motions[i];
    TrueInterval interval{.interval = {moved.touch, start + moved.start, start + moved.end},
                          .gross = {},
                          .first_event = i < filmed.first_events.size() ? filmed.first_events[i] : std::nullopt,
                          .labelled = moved.labelled,
                          .what = moved.what};
    if (moved.gross) interval.gross = start + *moved.gross;
    truth.intervals.push_back(interval);
  }
  if (motion.lift_start) truth.lift_start = start + *motion.lift_start;
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
  for (const SimulatedHotPixel& pixel : hot_pixels_of_run(pixels, drawn.camera.run_index))
    truth.hot_pixels.push_back(pixel_at(pixel.index, drawn.camera.size, pixel.hz));
  for (std::size_t i = 0; i < pixels.thresholds.size(); ++i) {
    if (std::isinf(pixels.thresholds[i])) truth.dead_pixels.push_back(pixel_at(i, drawn.camera.size, 0));
  }
  truth.parameters = {{"plan", drawn.plan},
                      {"camera", json_of_fields(drawn.camera)},
                      {"camera_start_us", drawn.clocks.camera_start_us},
                      {"physics_hash", hash_of(json_of(*drawn.physics))},
                      {"settings", simulation_settings(*drawn.physics, drawn.object.name, drawn.run, drawn.preset, drawn.seed)}};
  return truth;
}

}  // namespace tactile::simulation
