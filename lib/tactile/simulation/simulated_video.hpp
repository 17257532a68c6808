#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/core/time.hpp"
#include "tactile/simulation/drawn_value.hpp"
#include "tactile/simulation/object_model.hpp"
#include "tactile/simulation/run_clocks.hpp"
#include "tactile/simulation/run_plan.hpp"

namespace tactile::simulation {

/// Properties of the webcam.
struct VideoPhysics {
  double rate_hz = 30;
  double rate_error = 0.005;  ///< largest relative error of the rate
  double jitter_ms = 0.8;     ///< of each frame's time, standard deviation
  double lost_frame_share = 0.01;
  double exposure_steps_per_s = 0.15;
  Range exposure_step{0.90, 1.10};  ///< factor on all grey levels; their product stays between 0.7 and 1.4
  double noise_grey = 2.3;          ///< standard deviation of a pixel
  /// Of H.264, 0 to 51. At 20 about a third of this noise remains in a frame, at 24 almost none.
  int quantiser = 20;
  Range after_camera_s{0.05, 0.3};  ///< time from the end of the camera to the end of the film
};

template <class Fields>
void list_fields(Fields& fields, VideoPhysics& video) {
  fields("rate_hz", video.rate_hz, 1.0, 240.0);
  fields("rate_error", video.rate_error, 0.0, 0.2);
  fields("jitter_ms", video.jitter_ms, 0.0, 100.0);
  fields("lost_frame_share", video.lost_frame_share, 0.0, 0.9);
  fields("exposure_steps_per_s", video.exposure_steps_per_s, 0.0, 100.0);
  fields("exposure_step", video.exposure_step, 0.1, 10.0);
  fields("noise_grey", video.noise_grey, 0.0, 30.0);
  fields("quantiser", video.quantiser, 0, 51);
  fields("after_camera_s", video.after_camera_s, 0.0, 60.0);
}

/// The film of a run: the times of its frames, on its own clock from 0, uneven and with lost frames, and the pictures.
class SimulatedVideo {
 public:
  /// @param plan, clocks  must outlive it
  SimulatedVideo(const ObjectModel& object, const RunPlan& plan, const RunClocks& clocks, const VideoPhysics& physics,
                 Random random);

  const std::vector<VideoTime>& times() const { return times_; }
  const std::vector<double>& exposures() const { return exposures_; }  ///< a factor per frame on all grey levels
  /// 240 x 320 8-bit grey: the object on a table, between sensor and finger, which the arm holds from above.
  cv::Mat draw(std::size_t index);

 private:
  const RunPlan* plan_;
  const RunClocks* clocks_;
  double half_width_px_, height_px_, grey_;  ///< of the object
  double closed_mm_;                         ///< the stage's travel at which the gap between sensor and object closes
  std::vector<VideoTime> times_;
  std::vector<double> exposures_;
  std::vector<std::size_t> noise_begins_;  ///< a place in `noise_` per frame
  std::vector<std::int8_t> noise_;         ///< more values than a frame has pixels
  cv::Mat still_;                          ///< the still part of the picture, at `still_exposure_`
  double still_exposure_ = 0;
};

}  // namespace tactile::simulation
