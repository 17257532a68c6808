#include "tactile/simulation/simulate.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <tuple>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/run_files.hpp"
#include "tactile/core/version.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_writer.hpp"
#include "tactile/simulation/simulated_devices.hpp"
#include "tactile/simulation/truth.hpp"
#include "tactile/video/video_times.hpp"
#include "tactile/video/video_writer.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;

constexpr int model_version = 1;  ///< raised whenever the same settings give other runs than before

nlohmann::json settings_json(const ObjectModel& object, const std::string& run, const SimulationPreset& preset,
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
  return {{"model_version", model_version}, {"object", object}, {"run", run},      {"preset", preset.name},
          {"timings", preset.timings},      {"seed", seed},     {"camera", camera}};
}

/// The settings' hash of a run that `simulate` made; nothing for any other folder.
std::optional<std::string> settings_hash_in(const RunFolder& run) {
  try {
    const RunInfo info = read_run_info(run);
    if (!info.simulated || !info.complete || info.object != run.object || info.run != run.run) return std::nullopt;
    return member<std::string>(member<nlohmann::json>(info.extra, "simulation", "run.json"), "settings_hash", "run.json");
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::uint64_t bytes_in(const fs::path& folder) {
  std::uint64_t bytes = 0;
  for (const fs::directory_entry& file : fs::directory_iterator(folder)) {
    if (file.is_regular_file()) bytes += file.file_size();
  }
  return bytes;
}

bool is_whole(const RunFolder& run) {
  const std::array files{run.events(), run.robot(), run.video(), run.video_times(), run.truth()};
  return std::all_of(files.begin(), files.end(), [](const fs::path& file) { return fs::is_regular_file(file); });
}

/// Takes the folder's name away before its files, so that no half of a run is ever found under it.
void remove_run(const RunFolder& run) {
  const fs::path aside = run.folder.parent_path() / ("." + run.run + ".removed");
  std::error_code failed;
  fs::remove_all(aside, failed);
  if (!failed) fs::rename(run.folder, aside, failed);
  if (!failed) fs::remove_all(aside, failed);
  if (failed) throw Error(run.folder.string() + ": cannot be removed (" + failed.message() + "); expected a writable folder");
}

struct PlannedRun {
  const ObjectModel* object = nullptr;
  SimulatedRun outcome;
  bool keeps_labels = false;  ///< made with the same settings before: its labels still hold
};

/// What is to be done for each run asked for; refuses before anything is touched.
std::vector<PlannedRun> plan_runs(const SimulateOptions& options, const SimulationPreset& preset, int runs) {
  std::vector<const ObjectModel*> objects;
  if (options.objects.empty()) {
    for (const ObjectModel& object : object_models()) objects.push_back(&object);
  }
  std::set<std::string> asked(options.objects.begin(), options.objects.end());
  for (const std::string& name : asked) objects.push_back(&object_model(name));
  std::sort(objects.begin(), objects.end(), [](const ObjectModel* a, const ObjectModel* b) { return a->name < b->name; });

  std::vector<PlannedRun> planned;
  for (const ObjectModel* object : objects) {
    for (int i = 1; i <= 99; ++i) {
      const std::string id = fmt::format("{:02}", i);
      const RunFolder run{options.data / object->name / id, object->name, id};
      if (i > runs) {
        if (options.force && settings_hash_in(run))
          planned.push_back({object, {.run = run, .kind = SimulatedRun::Kind::removed}, false});
        continue;
      }
      SimulatedRun outcome{.run = run};
      bool keeps_labels = false;
      if (fs::exists(fs::symlink_status(run.folder))) {
        const std::optional<std::string> hash = settings_hash_in(run);
        if (!hash) {
          throw Error(run.folder.string() +
                      ": is there already and was not made by 'simulate'; expected another data folder, or this one free");
        }
        const bool same = *hash == hash_of(settings_json(*object, id, preset, options.seed));
        if (!same && !options.force) {
          throw Error(run.folder.string() + ": was simulated with other settings; expected the same, or --force to replace it");
        }
        keeps_labels = same;
        outcome.kind = same && is_whole(run) ? SimulatedRun::Kind::kept : SimulatedRun::Kind::replaced;
      }
      planned.push_back({object, outcome, keeps_labels});
    }
  }
  return planned;
}

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

SimulatedRun simulate_run(const RunFolder& run, const ObjectModel& object, const SimulationPreset& preset, std::uint64_t seed,
                          const CameraPixels& pixels, const std::function<void(double)>& tell_share) {
  const auto random_for = [&](std::string_view use) { return Random(seed_for(seed, {"run", run.object, run.run, use})); };
  Random for_plan = random_for("plan"), for_clocks = random_for("clocks"), for_motion = random_for("motion");
  const RunPlan plan = draw_run_plan(object, preset.timings, for_plan);
  const RunClocks clocks = draw_run_clocks(for_clocks);
  const CameraTime start = camera_time(clocks.camera_start_us);

  EventCameraOptions camera = simulated_camera_options();
  camera.veil = plan.veil;
  camera.noise_factor = plan.noise_factor;
  const SkinMotion motion = move_skin(plan, camera.readout, for_motion);
  const std::string source = fmt::format("DVXplorer_SIM{:05}", seed % 100'000);
  RecordingWriter recording(run.events(), {event_stream_declaration(camera.size, source)});
  const FilmedSkin filmed = film_skin(
      motion, pixels, camera, start, seed_for(seed, {"run", run.object, run.run, "camera"}),
      [&](std::span<const Event> events) { recording.write_events(0, events); }, tell_share);
  recording.close();

  Random for_robot = random_for("robot");
  const LoggedRobot robot = log_robot(plan, clocks, for_robot);
  write_robot_log(run.robot(), robot.log);

  Random for_video = random_for("video");
  const std::vector<VideoTime> frames = draw_frame_times(plan, clocks, for_video);
  VideoWriter film(run.video(), {});
  for (const VideoTime t : frames) {
    const double t_s = 1e-6 * static_cast<double>(us_of(clocks.video.camera_from(t)) - clocks.camera_start_us);
    film.write(draw_frame(object, plan, t_s, for_video), t);
  }
  film.close();
  sync_to_disk(run.video());
  write_video_times(run.video_times(), frames);

  const nlohmann::json settings = settings_json(object, run.run, preset, seed);
  Truth truth;
  truth.intervals.push_back({.interval = {Touch::press, start + motion.press_start, start + motion.press_end},
                             .gross = {},
                             .first_event = filmed.first_of_press});
  truth.intervals.push_back({.interval = {Touch::slip, start + motion.slip_start, start + motion.slip_end},
                             .gross = start + motion.gross,
                             .first_event = filmed.first_of_slip});
  truth.lift_start = start + motion.lift_start;
  truth.robot_clock = clocks.robot;
  truth.video_clock = clocks.video;
  truth.parameters = {{"object", object}, {"plan", plan}, {"camera_start_us", clocks.camera_start_us}, {"settings", settings}};
  write_truth(run.truth(), truth);

  write_run_info(
      run,
      {.object = run.object,
       .run = run.run,
       .session = fmt::format("simulated-{}-{}-{}", seed, run.object, run.run),
       .simulated = true,
       .complete = true,
       .width = camera.size.width,
       .height = camera.size.height,
       .extra = {
           {"camera", {{"source", source}, {"readout_mode", "constant"}, {"readout_us", camera.readout.count()}}},
           {"simulation",
            {{"settings_hash", hash_of(settings)}, {"preset", preset.name}, {"seed", seed}, {"model_version", model_version}}},
           {"software", {{"name", "tactile"}, {"version", version()}, {"revision", revision()}}},
           {"host_time_us",
            {{"begin", clocks.camera_start_us + clocks.host_from_camera_us},
             {"end", us_of(filmed.last_readout) + clocks.host_from_camera_us}}},
           {"dropped", {{"events", 0}, {"robot_packages", robot.dropped_packages}, {"frames", 0}}},
           {"files", files_json(std::array{run.events(), run.robot(), run.video(), run.video_times(), run.truth()})}}});
  return {.run = run,
          .kind = SimulatedRun::Kind::made,
          .events = filmed.events,
          .duration_s = plan.end_s,
          .bytes = bytes_in(run.folder)};
}

std::vector<SimulatedRun> simulate(const SimulateOptions& options, const ProgressCallback& progress) {
  const SimulationPreset& preset = simulation_preset(options.preset);
  const int runs = options.runs.value_or(preset.runs);
  if (runs < 1 || runs > 99) throw Error(fmt::format("simulate: {} runs per object; expected 1 to 99", runs));
  std::vector<PlannedRun> planned = plan_runs(options, preset, runs);

  std::vector<std::size_t> to_make;
  for (std::size_t i = 0; i < planned.size(); ++i) {
    SimulatedRun& outcome = planned[i].outcome;
    if (outcome.kind == SimulatedRun::Kind::removed) remove_run(outcome.run);
    if (outcome.kind == SimulatedRun::Kind::kept) outcome.bytes = bytes_in(outcome.run.folder);
    if (outcome.kind == SimulatedRun::Kind::made || outcome.kind == SimulatedRun::Kind::replaced) to_make.push_back(i);
  }

  if (!to_make.empty()) {
    constexpr std::uint64_t parts = 1000;
    const CameraPixels pixels = simulated_camera_pixels(options.seed);
    std::vector<std::uint64_t> done(to_make.size(), 0);
    std::mutex guard;
    parallel_for(to_make.size(), options.threads, [&](std::size_t i) {
      SimulatedRun& outcome = planned[to_make[i]].outcome;
      const auto tell_part = [&](double share) {
        const std::scoped_lock lock(guard);
        done[i] = static_cast<std::uint64_t>(share * parts);
        std::uint64_t sum = 0;
        for (const std::uint64_t part : done) sum += part;
        tell(progress, sum, parts * done.size(), outcome.run.name());
      };
      WholeFile whole(outcome.run.folder);
      fs::create_directory(whole.path());
      const SimulatedRun made = simulate_run({whole.path(), outcome.run.object, outcome.run.run}, *planned[to_make[i]].object,
                                             preset, options.seed, pixels, [&](double share) { tell_part(0.9 * share); });
      // The same run made again is the same run: its labels, which a person may have confirmed, still hold.
      if (planned[to_make[i]].keeps_labels && fs::exists(outcome.run.labels()))
        fs::copy_file(outcome.run.labels(), whole.path() / "labels.json");
      if (outcome.kind == SimulatedRun::Kind::replaced) remove_run(outcome.run);
      whole.commit();
      std::tie(outcome.events, outcome.duration_s, outcome.bytes) = std::tie(made.events, made.duration_s, made.bytes);
      tell_part(1.0);
    });
  }

  std::vector<SimulatedRun> outcomes;
  for (PlannedRun& run : planned) outcomes.push_back(std::move(run.outcome));
  return outcomes;
}

}  // namespace tactile
