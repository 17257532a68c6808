#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/core/time.hpp"
#include "tactile/simulation/drawn_value.hpp"
#include "tactile/simulation/object_model.hpp"
#include "tactile/simulation/run_clocks.hpp"
#include "tactile/simulation/run_plan.hpp"

namespace tactile {

/// What the webcam is like.
struct VideoPhysics {
  double rate_hz = 30;
  double rate_error = 0.005;      ///< the rate is off by up to this share
  double jitter_ms = 0.8;         ///< of each frame's time, standard deviation
  double lost_frame_share = 0.01;
  double exposure_steps_per_s = 0.15;
  Range exposure_step{0.90, 1.10};  ///< by which all grey levels change at once
  double noise_grey = 2.3;          ///< standard deviation of a pixel
  Range after_camera_s{0.05, 0.3};  ///< the film ends so much later than the camera
};

/// A film of a run: when its frames are taken, on its own clock from 0, uneven, with a frame left out now and then; and what they
/// show.
class SimulatedVideo {
 public:
  /// @param object, plan, clocks  must outlive it
  SimulatedVideo(const ObjectModel& object, const RunPlan& plan, const RunClocks& clocks, const VideoPhysics& physics,
                 Random random);

  const std::vector<VideoTime>& times() const { return times_; }
  /// 240 x 320 8-bit grey: the object on a table between sensor and finger, which the arm holds from above. Frame by frame, in
  /// order.
  cv::Mat draw(std::size_t index);

 private:
  const ObjectModel* object_;
  const RunPlan* plan_;
  const RunClocks* clocks_;
  VideoPhysics physics_;
  Random random_;
  std::vector<VideoTime> times_;
  std::vector<double> exposures_;  ///< a factor per frame
};

}  // namespace tactile
