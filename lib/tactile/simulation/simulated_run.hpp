#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/events/other_streams.hpp"
#include "tactile/events/stream.hpp"
#include "tactile/simulation/event_camera.hpp"
#include "tactile/simulation/physics.hpp"
#include "tactile/simulation/run_clocks.hpp"
#include "tactile/simulation/run_plan.hpp"
#include "tactile/simulation/skin_film.hpp"
#include "tactile/simulation/skin_motion.hpp"
#include "tactile/simulation/truth.hpp"

namespace tactile {

inline constexpr int simulation_model_version = 2;  ///< raised whenever the same settings give other runs than before

/// The camera that serves all runs of a data set with this seed. @throws Error  if the physics ask for what no camera is
CameraPixels simulated_camera_pixels(const SimulationPhysics& physics, std::uint64_t seed);
std::string simulated_camera_name(std::uint64_t seed);  ///< "DVXplorer_SIM00001"

/// What a run is made from, whole: equal settings make equal runs.
/// @param run     its id, such as "01"
/// @throws Error  if there is no such object or preset
nlohmann::json simulation_settings(const SimulationPhysics& physics, std::string_view object, std::string_view run,
                                   std::string_view preset, std::uint64_t seed);

/// A run before a camera, a robot or a webcam has seen anything of it: all that is drawn beforehand.
struct DrawnRun {
  const SimulationPhysics* physics = nullptr;
  ObjectModel object;
  std::string run;
  std::string preset;
  std::uint64_t seed = 1;  ///< of the data set
  RunPlan plan;
  RunClocks clocks;
  EventCameraOptions camera;  ///< as it is in this run
  SkinMotion motion;

  CameraTime start() const { return camera_time(clocks.camera_start_us); }  ///< the camera's first read-out
  std::uint64_t seed_for_use(std::string_view use) const;
};

/// Draws from the seed, the object's name and the run's. `physics` must outlive the run.
/// @throws Error  if there is no such object or preset
DrawnRun draw_run(const SimulationPhysics& physics, std::string_view object, std::string run, std::string_view preset,
                  std::uint64_t seed);

/// The camera's film of the run. `drawn` and `pixels` must outlive it.
SkinFilm film_of(const DrawnRun& drawn, const CameraPixels& pixels);

Stream simulated_imu_stream(std::string source);       ///< id 1, "imu"
std::vector<ImuSample> imu_of(const DrawnRun& drawn);  ///< whether or not the run's plan has it recorded

// Where a recording ended before the run did, at `until`, the robot and the video end just after it, and motion that comes later
// is no part of the truth; an interval that was going on ends there.

/// Writes `robot.csv`; returns how many packages were lost on the way to it.
std::uint64_t write_robot(const std::filesystem::path& file, const DrawnRun& drawn, std::optional<CameraTime> until = {});
void write_video(const std::filesystem::path& film, const std::filesystem::path& times, const DrawnRun& drawn,
                 std::optional<CameraTime> until = {});
Truth truth_of(const DrawnRun& drawn, const CameraPixels& pixels, const FilmedSkin& filmed, std::optional<CameraTime> until = {});

}  // namespace tactile
