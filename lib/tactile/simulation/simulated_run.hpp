#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/core/truth.hpp"
#include "tactile/events/other_streams.hpp"
#include "tactile/events/stream.hpp"
#include "tactile/simulation/event_camera.hpp"
#include "tactile/simulation/physics.hpp"
#include "tactile/simulation/run_clocks.hpp"
#include "tactile/simulation/run_plan.hpp"
#include "tactile/simulation/skin_film.hpp"
#include "tactile/simulation/skin_motion.hpp"

namespace tactile::simulation {

inline constexpr int simulation_model_version = 3;  ///< increased whenever the same settings give other runs

std::string simulated_camera_name(std::uint64_t seed);  ///< "DVXplorer_SIM00001"

/// The complete settings of a run: equal settings give equal runs.
/// @param run     its id, such as "01"
/// @throws Error  if there is no such object or preset
nlohmann::json simulation_settings(const SimulationPhysics& physics, std::string_view object, std::string_view run,
                                   std::string_view preset, std::uint64_t seed);

/// A run with all its random draws, before camera, robot and webcam record it.
struct DrawnRun {
  const SimulationPhysics* physics = nullptr;
  ObjectModel object;
  std::string run;
  std::string preset;
  std::uint64_t seed = 1;  ///< of the data set
  RunPlan plan;
  RunClocks clocks;
  EventCameraOptions camera;      ///< with the values of this session and run
  std::uint64_t pixels_seed = 0;  ///< of the camera's pixels: equal in all runs of a session
  SkinMotion motion;

  CameraTime start() const { return camera_time(clocks.camera_start_us); }  ///< the camera's first read-out
  std::uint64_t seed_for_use(std::string_view use) const;
};

/// Draws from the seed, the object's name and the run's. `physics` must outlive the run.
/// @param camera  instead of that of the run's session
/// @throws Error  if there is no such object or preset
DrawnRun draw_run(const SimulationPhysics& physics, std::string_view object, std::string run, std::string_view preset,
                  std::uint64_t seed, const std::optional<SessionCamera>& camera = {});

/// The pixels of the camera of the run. @throws Error  if the physics of the camera are invalid
CameraPixels camera_pixels_of(const DrawnRun& drawn);

/// The camera's film of the run. `drawn` and `pixels` must outlive it.
SkinFilm film_of(const DrawnRun& drawn, const CameraPixels& pixels);

events::Stream simulated_imu_stream(std::string source);       ///< id 1, "imu"
std::vector<events::ImuSample> imu_of(const DrawnRun& drawn);  ///< even if the plan records none

// If the recording ends before the run, at `until`, robot and video end just after it. The truth omits later motion, and an
// interval in progress ends there.

/// Writes `robot.csv`. @return  the number of lost packages
std::uint64_t write_robot(const std::filesystem::path& file, const DrawnRun& drawn, std::optional<CameraTime> until = {});
void write_video(const std::filesystem::path& film, const std::filesystem::path& times, const DrawnRun& drawn,
                 std::optional<CameraTime> until = {});
Truth truth_of(const DrawnRun& drawn, const CameraPixels& pixels, const FilmedSkin& filmed, std::optional<CameraTime> until = {});

}  // namespace tactile::simulation
