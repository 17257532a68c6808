#include "tactile/simulation/simulate.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <memory>
#include <mutex>
#include <optional>
#include <set>

#include "tactile/core/command_lock.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/folders_in.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/run_files.hpp"
#include "tactile/core/version.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::simulation {
namespace {

namespace fs = std::filesystem;

/// The hash of the settings of a simulated run; nothing for any other folder.
std::optional<std::string> settings_hash_in(const RunFolder& run) {
  try {
    const RunInfo info = read_run_info(run);
    if (!info.simulated || !info.complete || info.object != run.object || info.run != run.run) return std::nullopt;
    return member<std::string>(member<nlohmann::json>(info.extra, "simulation", "run.json"), "settings_hash", "run.json");
  } catch (const Error&) {
    return std::nullopt;
  }
}

/// The error for a run with other settings: the old and the requested ones, and how the physics differ.
Error made_otherwise(const RunFolder& run, const SimulateOptions& options) {
  const std::string where = run.folder.string();
  std::string was, asked;
  try {
    const auto made = member<nlohmann::json>(read_run_info(run).extra, "simulation", where);
    const auto physics = member<nlohmann::json>(made, "physics", where);
    const auto hash = member<std::string>(physics, "hash", where), asked_hash = hash_of(json_of(options.physics));
    was =
        fmt::format("preset {}, seed {}", member<std::string>(made, "preset", where), member<std::uint64_t>(made, "seed", where));
    asked = fmt::format("preset {}, seed {}", options.preset, options.seed);
    if (hash != asked_hash) {
      was += fmt::format(", physics {} ({})", member<std::string>(physics, "source", where), hash.substr(0, 8));
      asked += fmt::format(", physics {} ({})", options.physics.source, asked_hash.substr(0, 8));
    }
  } catch (const Error&) {  // run.json of an older version has less
  }
  if (was == asked) return Error(where + ": was simulated with other settings; expected the same, or --force to replace it");
  return Error(fmt::format("{}: was simulated with {}; expected {}, or --force to replace it", where, was, asked));
}

std::uint64_t bytes_in(const fs::path& folder) {
  std::uint64_t bytes = 0;
  for (const fs::directory_entry& file : fs::directory_iterator(folder)) {
    if (file.is_regular_file()) bytes += file.file_size();
  }
  return bytes;
}

/// Whether every file exists and has its original size.
bool is_whole(const RunFolder& run) {
  const RunFiles files = check_files(run, read_run_info(run), FileComparison::size);
  return files.is_listed && files.missing.empty() && files.changed.empty() && files.not_listed.empty();
}

struct PlannedRun {
  SimulatedRun outcome;
  bool keeps_labels = false;  ///< made with the same settings, so its labels stay valid
};

/// Counts the events in presses and slips.
class TouchCounter {
 public:
  explicit TouchCounter(const DrawnRun& drawn) {
    for (const MarkerMotion& motion : drawn.motion.motions) {
      if (motion.labelled) intervals_.emplace_back(drawn.start() + motion.start, drawn.start() + motion.end);
    }
  }

  /// @param events  ascending in time
  void count(std::span<const events::Event> events) {
    const auto is_earlier = [](const events::Event& event, CameraTime t) { return event.t < t; };
    for (const auto& [start, end] : intervals_) {
      const auto first = std::lower_bound(events.begin(), events.end(), start, is_earlier);
      events_ += static_cast<std::uint64_t>(std::lower_bound(first, events.end(), end, is_earlier) - first);
    }
  }
  std::uint64_t events() const { return events_; }
  double seconds() const {
    microseconds sum{};
    for (const auto& [start, end] : intervals_) sum += end - start;
    return 1e-6 * static_cast<double>(sum.count());
  }

 private:
  std::vector<std::pair<CameraTime, CameraTime>> intervals_;
  std::uint64_t events_ = 0;
};

/// Records the run, with the events and the samples of the inertial sensor in order of time.
void record(const fs::path& file, const DrawnRun& drawn, SkinFilm& film, TouchCounter& touch,
            const std::function<void(double)>& report_share) {
  constexpr microseconds piece = 10ms;
  const std::string source = simulated_camera_name(drawn.seed);
  std::vector<events::Stream> streams{events::event_stream_declaration(drawn.camera.size, source)};
  std::vector<events::ImuSample> imu;
  if (drawn.plan.has_imu) {
    streams.push_back(simulated_imu_stream(source));
    imu = imu_of(drawn);
  }
  events::RecordingWriter recording(file, streams);
  std::size_t felt = 0;
  const auto write_imu_before = [&](std::optional<CameraTime> t) {
    const std::size_t begin = felt;
    while (felt < imu.size() && (!t || imu[felt].t < *t)) ++felt;
    if (felt > begin) recording.write_imu(streams[1].id, std::span(imu).subspan(begin, felt - begin));
  };
  const auto write_events = [&](std::span<const events::Event> events) {
    touch.count(events);
    while (!events.empty()) {
      const CameraTime end = events.front().t + piece;
      const auto later = std::find_if(events.begin(), events.end(), [&](const events::Event& event) { return event.t >= end; });
      const auto count = static_cast<std::size_t>(later - events.begin());
      write_imu_before(events.front().t);
      recording.write_events(streams[0].id, events.first(count));
      events = events.subspan(count);
    }
  };
  film_whole(film, write_events, report_share);
  write_imu_before(std::nullopt);
  recording.close();
}

/// Writes events and truth.
FilmedSkin write_events_and_truth(const RunFolder& run, const DrawnRun& drawn, const CameraPixels& pixels, TouchCounter& touch,
                                  const std::function<void(double)>& report_share) {
  SkinFilm film = film_of(drawn, pixels);
  record(run.events(), drawn, film, touch, report_share);
  write_truth(run.truth(), truth_of(drawn, pixels, film.filmed()));
  return film.filmed();
}

/// Decides what to do for a run. @throws Error  if its folder is not a simulated run
PlannedRun plan_run(const RunFolder& run, const SimulateOptions& options) {
  PlannedRun planned{.outcome = {.run = run}};
  if (!fs::exists(fs::symlink_status(run.folder))) return planned;
  const std::optional<std::string> hash = settings_hash_in(run);
  if (!hash) {
    throw Error(run.folder.string() + ": exists and was not made by 'simulate'; expected another data folder, or a new run");
  }
  const bool same = *hash == hash_of(simulation_settings(options.physics, run.object, run.run, options.preset, options.seed));
  if (!same && !options.force) throw made_otherwise(run, options);
  planned.keeps_labels = same;
  planned.outcome.kind = same && is_whole(run) ? SimulatedRun::Kind::kept : SimulatedRun::Kind::replaced;
  if (planned.outcome.kind == SimulatedRun::Kind::kept) planned.outcome.bytes = bytes_in(run.folder);
  return planned;
}

/// The requested objects, by name. @throws Error  if one is unknown
std::vector<const ObjectModel*> objects_of(const SimulateOptions& options) {
  std::vector<const ObjectModel*> objects;
  if (options.objects.empty()) {
    for (const ObjectModel& object : options.physics.objects) objects.push_back(&object);
  }
  const std::set<std::string> asked(options.objects.begin(), options.objects.end());
  for (const std::string& name : asked) objects.push_back(&options.physics.object(name));
  std::sort(objects.begin(), objects.end(), [](const ObjectModel* a, const ObjectModel* b) { return a->name < b->name; });
  return objects;
}

/// Decides what to do for each requested run, before anything is changed.
std::vector<PlannedRun> plan_runs(const SimulateOptions& options, const std::vector<const ObjectModel*>& objects, int runs) {
  std::vector<PlannedRun> planned;
  for (const ObjectModel* object : objects) {
    for (int i = 1; i <= 99; ++i) {
      const std::string id = fmt::format("{:02}", i);
      const RunFolder run{options.data / object->name / id, object->name, id};
      if (i <= runs) {
        planned.push_back(plan_run(run, options));
      } else if (options.force && settings_hash_in(run)) {
        planned.push_back({.outcome = {.run = run, .kind = SimulatedRun::Kind::removed}});
      }
    }
  }
  return planned;
}

/// @param one_camera  its pixels, if all sessions have the same
/// @throws Error  if the run cannot be written, or its name was free and something has it meanwhile, which is kept
SimulatedRun make_run(const PlannedRun& planned, const SimulateOptions& options, const std::optional<CameraPixels>& one_camera,
                      const std::function<void(double)>& report_share) {
  const RunFolder& run = planned.outcome.run;
  WholeFile whole(run.folder, planned.outcome.kind == SimulatedRun::Kind::made ? IfThere::refuse : IfThere::replace);
  fs::create_directory(whole.path());
  const DrawnRun drawn = draw_run(options.physics, run.object, run.run, options.preset, options.seed);
  SimulatedRun made =
      simulate_run({whole.path(), run.object, run.run}, drawn, one_camera ? *one_camera : camera_pixels_of(drawn), report_share);
  // The run is made again identically, so its labels, which a person may have confirmed, stay valid.
  if (planned.keeps_labels && fs::exists(run.labels())) fs::copy_file(run.labels(), whole.path() / "labels.json");
  whole.commit();
  made.run = run;
  made.kind = planned.outcome.kind;
  return made;
}

}  // namespace

void simulate_events(const RunFolder& run, const DrawnRun& drawn, const CameraPixels& pixels) {
  TouchCounter touch(drawn);
  write_events_and_truth(run, drawn, pixels, touch, {});
}

RunSettings read_run_settings(const RunFolder& run) {
  const std::string where = run.truth().string();
  if (!fs::exists(run.truth())) throw Error(where + ": missing; expected a simulated run");
  nlohmann::json settings = member<nlohmann::json>(read_truth(run.truth()).parameters, "settings", where);
  const std::string hash = hash_of(settings);
  const auto preset = member<nlohmann::json>(settings, "preset", where);
  RunSettings read{.physics = {},
                   .object = member<std::string>(member<nlohmann::json>(settings, "object", where), "name", where),
                   .run = member<std::string>(settings, "run", where),
                   .preset = member<std::string>(preset, "name", where),
                   .seed = member<std::uint64_t>(settings, "seed", where)};
  nlohmann::json physics = settings;
  for (const char* other : {"preset", "object", "place", "run", "seed", "model_version"}) physics.erase(other);
  physics["presets"][read.preset] = {{"timings", member<nlohmann::json>(preset, "timings", where)},
                                     {"special_runs", member<bool>(preset, "special_runs", where)}};
  physics["objects"] = nlohmann::json::array({settings["object"]});
  read.physics = physics_from(physics, where);
  if (hash_of(simulation_settings(read.physics, read.object, read.run, read.preset, read.seed)) != hash)
    throw Error(where + ": its settings give another run in this version; expected a run that this version simulates");
  return read;
}

SimulatedRun simulate_run(const RunFolder& run, const DrawnRun& drawn, const CameraPixels& pixels,
                          const std::function<void(double)>& report_share) {
  TouchCounter touch(drawn);
  const FilmedSkin filmed = write_events_and_truth(run, drawn, pixels, touch, report_share);
  const std::uint64_t dropped_packages = write_robot(run.robot(), drawn);
  write_video(run.video(), run.video_times(), drawn);

  const RunClocks& clocks = drawn.clocks;
  const SimulationPhysics& physics = *drawn.physics;
  write_run_info(
      run,
      {.object = run.object,
       .run = run.run,
       .session = clocks.session,
       .simulated = true,
       .complete = true,
       .width = drawn.camera.size.width,
       .height = drawn.camera.size.height,
       .extra = {
           {"camera",
            {{"source", simulated_camera_name(drawn.seed)},
             {"readout_mode", readout_mode_of(drawn.camera)},
             {"readout_us", drawn.camera.readout_us}}},
           {"simulation",
            {{"settings_hash", hash_of(simulation_settings(physics, drawn.object.name, drawn.run, drawn.preset, drawn.seed))},
             {"physics", {{"source", physics.source}, {"hash", hash_of(json_of(physics))}}},
             {"preset", drawn.preset},
             {"seed", drawn.seed},
             {"model_version", simulation_model_version}}},
           {"software", {{"name", "tactile"}, {"version", version()}, {"revision", revision()}}},
           {"host_time_us",
            {{"begin", clocks.camera_start_us + clocks.host_from_camera_us},
             {"end", us_of(filmed.last_readout) + clocks.host_from_camera_us}}},
           {"dropped", {{"events", 0}, {"robot_packages", dropped_packages}, {"frames", 0}}},
           {"files", files_json(std::array{run.events(), run.robot(), run.video(), run.video_times(), run.truth()})}}});
  return {.run = run,
          .kind = SimulatedRun::Kind::made,
          .events = filmed.events,
          .duration_s = drawn.plan.end_s,
          .bytes = bytes_in(run.folder),
          .touch_events = touch.events(),
          .touch_s = touch.seconds()};
}

std::vector<SimulatedRun> simulate(const SimulateOptions& options, const ProgressCallback& progress) {
  const int runs = options.runs.value_or(options.physics.preset(options.preset).runs);
  if (runs < 1 || runs > 99) throw Error(fmt::format("simulate: {} runs per object; expected 1 to 99", runs));
  const std::vector<const ObjectModel*> objects = objects_of(options);
  const CommandLock command_lock(options.data, "tactile simulate", ".simulate.lock");
  const std::vector<PlannedRun> planned = plan_runs(options, objects, runs);
  for (const fs::path& object : folders_in(options.data, Links::skip)) remove_leftovers_in(object);
  std::optional<CameraPixels> one_camera;
  if (!options.physics.sessions.vary) {
    const SessionCamera camera = session_camera(options.physics.camera, options.physics.sessions, options.seed, {});
    one_camera = draw_camera_pixels(camera.options, camera.pixels_seed);
  }

  std::vector<SimulatedRun> outcomes;
  std::vector<std::size_t> to_make;
  for (std::size_t i = 0; i < planned.size(); ++i) {
    const SimulatedRun& outcome = outcomes.emplace_back(planned[i].outcome);
    if (outcome.kind == SimulatedRun::Kind::removed) remove_whole(outcome.run.folder);
    if (outcome.kind == SimulatedRun::Kind::made || outcome.kind == SimulatedRun::Kind::replaced) to_make.push_back(i);
  }

  if (!to_make.empty()) {
    constexpr std::uint64_t parts = 1000;
    std::vector<std::uint64_t> done(to_make.size(), 0);
    std::mutex guard;
    parallel_for(to_make.size(), options.threads, [&](std::size_t i) {
      SimulatedRun& outcome = outcomes[to_make[i]];
      const auto report_part = [&](double share) {
        const std::scoped_lock lock(guard);
        done[i] = static_cast<std::uint64_t>(share * parts);
        std::uint64_t sum = 0;
        for (const std::uint64_t part : done) sum += part;
        report_progress(progress, sum, parts * done.size(), outcome.run.name());
      };
      outcome = make_run(planned[to_make[i]], options, one_camera, [&](double share) { report_part(0.9 * share); });
      report_part(1.0);
    });
  }

  return outcomes;
}

}  // namespace tactile::simulation
