#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "tactile/simulation/event_camera.hpp"
#include "tactile/simulation/object_model.hpp"
#include "tactile/simulation/run_plan.hpp"
#include "tactile/simulation/simulated_devices.hpp"
#include "tactile/simulation/skin_motion.hpp"
#include "tactile/simulation/truth.hpp"

namespace tactile {

/// A size of data set.
struct SimulationPreset {
  std::string name;
  int runs = 0;  ///< per object
  RunTimings timings;
};

/// "tiny" (2 runs of about 2.5 s) or "quick" (3 of about 4 s). @throws Error if it is neither
const SimulationPreset& simulation_preset(std::string_view name);

inline constexpr int simulation_model_version = 1;  ///< raised whenever the same settings give other runs than before

/// The camera that serves all runs of a data set with this seed.
EventCameraOptions simulated_camera_options();
CameraPixels simulated_camera_pixels(std::uint64_t seed);
std::string simulated_camera_name(std::uint64_t seed);  ///< "DVXplorer_SIM00001"

/// What a run is made from, whole: equal settings make equal runs. `run` is its id, such as "01".
nlohmann::json simulation_settings(const ObjectModel& object, std::string_view run, const SimulationPreset& preset,
                                   std::uint64_t seed);

/// A run before a camera, a robot or a webcam has seen anything of it: all that is drawn beforehand.
struct DrawnRun {
  ObjectModel object;
  std::string run;
  SimulationPreset preset;
  std::uint64_t seed = 1;  ///< of the data set
  RunPlan plan;
  RunClocks clocks;
  EventCameraOptions camera;
  SkinMotion motion;

  CameraTime start() const { return camera_time(clocks.camera_start_us); }  ///< the camera's first read-out
  std::uint64_t seed_for_use(std::string_view use) const;
};

/// Draws from the seed, the object's name and the run's.
DrawnRun draw_run(const ObjectModel& object, std::string run, const SimulationPreset& preset, std::uint64_t seed);

/// The camera's film of the run. `drawn` and `pixels` must outlive it.
SkinFilm film_of(const DrawnRun& drawn, const CameraPixels& pixels);

// Where a recording ended before the run did, at `until`, the robot and the video end just after it, and motion that comes later
// is no part of the truth; an interval that was going on ends there.

/// Writes `robot.csv`; returns how many packages were lost on the way to it.
std::uint64_t write_robot(const std::filesystem::path& file, const DrawnRun& drawn, std::optional<CameraTime> until = {});
void write_video(const std::filesystem::path& film, const std::filesystem::path& times, const DrawnRun& drawn,
                 std::optional<CameraTime> until = {});
Truth truth_of(const DrawnRun& drawn, const FilmedSkin& filmed, std::optional<CameraTime> until = {});

}  // namespace tactile
