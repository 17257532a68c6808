#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/core/time.hpp"
#include "tactile/robot/robot_log.hpp"
#include "tactile/simulation/event_camera.hpp"
#include "tactile/simulation/run_plan.hpp"
#include "tactile/simulation/skin_motion.hpp"

namespace tactile {

/// What the event camera saw of a run.
struct FilmedSkin {
  std::uint64_t events = 0;
  std::uint64_t caused = 0;                  ///< by moving markers; the others are noise
  std::optional<CameraTime> first_of_press;  ///< first event that the press caused
  std::optional<CameraTime> first_of_slip;   ///< first event that the lift caused
  CameraTime last_readout{};
};

/// The camera looking at the skin, one read-out after the other.
class SkinFilm {
 public:
  /// @param motion, pixels  must outlive the film
  SkinFilm(const SkinMotion& motion, const CameraPixels& pixels, const EventCameraOptions& options, CameraTime start,
           std::uint64_t seed);

  bool ended() const { return next_ == motion_->poses.size(); }
  double share_done() const { return static_cast<double>(next_) / static_cast<double>(motion_->poses.size()); }
  /// The next read-out's events, valid until the one after it; not to be called once it has ended.
  std::span<const Event> next();
  const FilmedSkin& filmed() const { return filmed_; }  ///< up to the last read-out

 private:
  const SkinMotion* motion_;
  EventCamera camera_;
  microseconds readout_;
  CameraTime start_;
  std::size_t next_ = 0;
  FilmedSkin filmed_;
};

/// Runs the film to its end and hands on the events in batches, ascending in time.
/// @param tell_share  told how much of the run is done, 0 to 1; may throw to end it
void film_whole(SkinFilm& film, const std::function<void(std::span<const Event>)>& use,
                const std::function<void(double)>& tell_share = {});

/// Likewise from the first read-out on, where nothing else is wanted of the film.
FilmedSkin film_skin(const SkinMotion& motion, const CameraPixels& pixels, const EventCameraOptions& options, CameraTime start,
                     std::uint64_t seed, const std::function<void(std::span<const Event>)>& use,
                     const std::function<void(double)>& tell_share = {});

struct LoggedRobot {
  RobotLog log;
  std::uint64_t dropped_packages = 0;
};

/// The arm's log at 125 Hz on its controller's clock, beyond both ends of the camera's recording: still but for the lift, which
/// goes up the base's z axis, with the noise that joint encoders leave in a speed, and a package lost now and then. Bit 0 of the
/// outputs rises with the stage's command where the robot gives it.
LoggedRobot log_robot(const RunPlan& plan, const RunClocks& clocks, Random& random);

/// When a webcam at about 30 frames/s takes its frames, on its own clock from 0: uneven, with a frame left out now and then.
std::vector<VideoTime> draw_frame_times(const RunPlan& plan, const RunClocks& clocks, Random& random);

/// One frame, 240 x 320 8-bit grey: the object on a table between sensor and finger, which the arm holds from above.
/// @param t_s  seconds since the camera's first read-out
cv::Mat draw_frame(const ObjectModel& object, const RunPlan& plan, double t_s, Random& random);

}  // namespace tactile
