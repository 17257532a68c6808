#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/core/time.hpp"
#include "tactile/events/event.hpp"
#include "tactile/simulation/skin.hpp"

namespace tactile {

/// The camera's pixels and the light they see. Thresholds are in ln of the intensity.
struct EventCameraOptions {
  SensorSize size{640, 480};
  microseconds readout{200};           ///< between two read-outs, > 0
  double threshold = 0.25;             ///< mean over the pixels, > 0
  double threshold_sigma = 0.03;       ///< between pixels, >= 0
  double threshold_floor = 0.01;       ///< no pixel is more sensitive than this, > 0
  double residual = 1.0;               ///< share of its threshold that a pixel's memory may be off at the start, 0 to 1
  double noise_hz = 0.05;              ///< events that nothing caused, mean per pixel, >= 0
  double noise_spread_decades = 0.15;  ///< of that rate between pixels, standard deviation of its log10, >= 0
  double noise_factor = 1.0;           ///< by which a run's noise differs from the camera's, with its light and warmth, >= 0
  double noise_on_share = 0.7;         ///< leakage only brightens; photons err both ways
  int hot_pixels = 24;                 ///< that fire all by themselves, >= 0
  double hot_min_hz = 100.0;           ///< their rates are spread evenly in the logarithm between these, > 0
  double hot_max_hz = 2500.0;
  double hot_kept_share = 0.8;  ///< of them belong to the camera, the others to a run
  double skin = 0.62;           ///< reflectances, > 0
  double black = 0.08;
  double white = 0.92;
  double veil = 0.02;    ///< stray light, as a reflectance, >= 0
  double blur_px = 1.5;  ///< an edge fades over twice this: smoothstep, about a Gaussian of 0.7 px, > 0
};

/// What belongs to the camera and stays for all of its runs: each pixel's threshold and noise, and most of the hot pixels.
struct CameraPixels {
  struct HotPixel {
    std::uint32_t index = 0;  ///< y * width + x
    double hz = 0;
  };

  std::vector<float> thresholds;       ///< row by row from the top
  std::vector<double> noise_hz_up_to;  ///< noise of all pixels up to and with this one, ascending
  std::vector<HotPixel> hot;
};

/// Drawn from `seed`. @throws Error  if an option is out of range
CameraPixels draw_camera_pixels(const EventCameraOptions& options, std::uint64_t seed);

/// An event camera before moving markers. A pixel remembers the ln of the intensity at its last event; at a read-out it gives one
/// event if ln I differs from that by more than its threshold, and then remembers the present ln I: a fast edge costs events, as
/// a read-out can hold only one of each pixel. All events of one read-out bear its time; x ascends within it, and y within x.
///
/// Only pixels near a marker that moved are looked at, so a still skin costs only its noise.
class EventCamera {
 public:
  struct ReadOut {
    std::span<const Event> events;  ///< valid until the next read-out
    std::size_t caused = 0;         ///< how many of them a moving marker caused; the others are noise
  };

  /// @param pixels  must outlive the camera
  /// @param start   time of read-out 0
  /// @param seed    of what changes from run to run
  /// @param rest    the markers at the start; their boxes must lie apart and inside the image, here and in every read-out
  EventCamera(const CameraPixels& pixels, const EventCameraOptions& options, CameraTime start, std::uint64_t seed,
              std::span<const MarkerPose> rest);

  /// The next read-out, with the markers where they are now: as many as at the start. @throws Error if a marker left the image
  ReadOut read_out(std::span<const MarkerPose> poses);

 private:
  struct Box {
    int left = 0, top = 0, right = 0, bottom = 0;  ///< right and bottom are outside
  };
  struct Fire {
    std::uint32_t index = 0;
    std::int64_t next_readout = 0;
    double readouts_between = 0;
  };

  double smooth_step(double distance_px) const;
  Box box_of(const MarkerPose& pose) const;
  void look_at(const MarkerPose& pose, const Box& box, bool starting);
  void add_noise();
  void fire_without_cause(std::uint32_t index, bool on);

  const CameraPixels& pixels_;
  EventCameraOptions options_;
  CameraTime start_;
  Random random_;
  std::int64_t readout_ = 0;
  float skin_level_ = 0;
  std::vector<float> levels_;      ///< ln I now
  std::vector<float> remembered_;  ///< ln I at the last event
  std::vector<MarkerPose> poses_;
  std::vector<Box> boxes_;
  std::vector<Fire> hot_;
  std::vector<Event> events_;
  std::vector<std::int64_t> last_fired_;  ///< the pixel's last read-out with an event: it has one at most
  std::vector<float> column_, row_levels_;
};

}  // namespace tactile
