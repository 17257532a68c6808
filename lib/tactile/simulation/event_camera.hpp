#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/core/time.hpp"
#include "tactile/events/event.hpp"
#include "tactile/simulation/skin.hpp"

namespace tactile {

/// The camera's pixels and the light they see. Thresholds are in ln of the intensity; intensities are reflectances under constant
/// light, so 1 is white paper.
///
/// Sources: v2e and ESIM for thresholds, dark current, leak and shot noise; Faris et al., arXiv:2403.10120, for the read-out and
/// for hot pixels that fire more than useful ones. How many hot and dead pixels a camera has, how fast these come and go, and
/// what share of their events is ON are assumptions.
struct EventCameraOptions {
  SensorSize size{640, 480};
  double px_per_mm = 0;  ///< 0: as large as the whole skin fits into the image; see view_of
  microseconds readout{200};

  double threshold = 0.25;        ///< mean over the pixels
  double threshold_sigma = 0.03;  ///< between pixels
  double threshold_floor = 0.01;  ///< no pixel is more sensitive than this
  double residual = 1.0;          ///< share of its threshold that a pixel's memory may be off at the start
  /// For so long after an event a pixel is held in reset. No more than a read-out, as hot pixels of this kind of sensor reach one
  /// event in each: the read-out itself is the dead time. v2e's 500 us is that of another sensor.
  microseconds refractory{200};

  double leak_hz = 0.02;             ///< ON events out of nothing, mean per pixel
  double leak_spread_decades = 0.1;  ///< of that rate between pixels, standard deviation of its log10
  double shot_hz = 0.06;             ///< ON and OFF alike, in the dark; 1/4 of it at white
  int hot_pixels = 24;               ///< that fire all by themselves
  double hot_min_hz = 100.0;         ///< their rates are spread evenly in the logarithm between these
  double hot_max_hz = 2500.0;
  double hot_on_share = 0.7;
  double hot_turnover = 0.05;  ///< chance that a hot pixel is healed by the next run, and another one born
  int dead_pixels = 4;         ///< that never fire; at most half of all
  int readout_limit = 28'000;  ///< events of one read-out that reach the host: 140 Mev/s at 5000 read-outs/s, as measured

  double skin = 0.62;  ///< reflectances
  double black = 0.08;
  double white = 0.92;
  double dark = 0.001;       ///< the pixels' own dark current, as a reflectance: keeps ln I finite without light
  double blur_px = 1.5;      ///< an edge fades over twice this: smoothstep, about a Gaussian of 0.7 px
  double flicker_depth = 0;  ///< the light is 1 + depth sin(2 pi hz t), t from the first read-out
  double flicker_hz = 100;

  // What differs from run to run; not among the fields.
  double veil = 0.02;         ///< stray light, as a reflectance, >= 0
  double noise_factor = 1.0;  ///< by which leak and shot noise differ, with the run's warmth, >= 0
  std::size_t run_index = 0;  ///< among the camera's runs: decides which hot pixels there are
};

template <class Fields>
void list_fields(Fields& fields, EventCameraOptions& o) {
  fields("size", o.size, 1, 4096);
  fields("px_per_mm", o.px_per_mm, 0, 1000);
  fields("readout_us", o.readout, 1, 1'000'000);
  fields("threshold", o.threshold, 1e-6, 1e3);
  fields("threshold_sigma", o.threshold_sigma, 0, 1e3);
  fields("threshold_floor", o.threshold_floor, 1e-6, 1e3);
  fields("residual", o.residual, 0, 1);
  fields("refractory_us", o.refractory, 0, 10'000'000);
  fields("leak_hz", o.leak_hz, 0, 10'000);
  fields("leak_spread_decades", o.leak_spread_decades, 0, 2);
  fields("shot_hz", o.shot_hz, 0, 10'000);
  fields("hot_pixels", o.hot_pixels, 0, 100'000);
  fields("hot_min_hz", o.hot_min_hz, 1e-3, 1e6);
  fields("hot_max_hz", o.hot_max_hz, 1e-3, 1e6);
  fields("hot_on_share", o.hot_on_share, 0, 1);
  fields("hot_turnover", o.hot_turnover, 0, 1);
  fields("dead_pixels", o.dead_pixels, 0, 4096 * 4096 / 2);
  fields("readout_limit", o.readout_limit, 0, 4096 * 4096);
  fields("skin", o.skin, 0, 10);
  fields("black", o.black, 0, 10);
  fields("white", o.white, 0, 10);
  fields("dark", o.dark, 1e-6, 1);
  fields("blur_px", o.blur_px, 0.01, 100);
  fields("flicker_depth", o.flicker_depth, 0, 0.99);
  fields("flicker_hz", o.flicker_hz, 0, 100'000);
}

/// @throws Error  naming the first option that is out of its range
void check(const EventCameraOptions& options);

/// Where this camera sees the skin: in the middle of its image.
SkinView view_of(const EventCameraOptions& options);

/// A pixel that fires all by itself.
struct SimulatedHotPixel {
  std::uint32_t index = 0;  ///< y * width + x
  double hz = 0;

  friend bool operator==(const SimulatedHotPixel&, const SimulatedHotPixel&) = default;
};

/// Draws pixels with chances in proportion to their weights, each draw in constant time (Walker's alias method).
class PixelLottery {
 public:
  PixelLottery() = default;
  explicit PixelLottery(const std::vector<double>& weights);  ///< each >= 0

  double weight_sum() const { return weight_sum_; }
  std::uint32_t draw(Random& random) const;  ///< only if the sum is not 0

 private:
  double weight_sum_ = 0;
  std::vector<float> keep_;  ///< chance that a pixel drawn evenly is taken, rather than `other_`
  std::vector<std::uint32_t> other_;
};

/// What belongs to the camera and stays for all of its runs.
struct CameraPixels {
  std::vector<float> thresholds;  ///< row by row from the top; infinite where a pixel is dead
  PixelLottery leak;              ///< weights 1 in the mean
  PixelLottery shot;              ///< weights threshold / the pixel's threshold
  // Of what hot pixels are drawn.
  std::uint64_t hot_seed = 0;
  int hot_pixels = 0;
  double hot_min_hz = 0, hot_max_hz = 0, hot_turnover = 0;
};

/// Drawn from `seed`. The members of a run do not matter. @throws Error  if an option is out of range
CameraPixels draw_camera_pixels(const EventCameraOptions& options, std::uint64_t seed);

/// The hot pixels in the camera's run `run_index`, `hot_pixels` of them. Between two runs each is healed with the chance
/// `hot_turnover`; then another one is born, elsewhere and with a rate of its own. No dead pixel is hot.
std::vector<SimulatedHotPixel> hot_pixels_of_run(const CameraPixels& pixels, std::size_t run_index);

/// An event camera before moving markers.
///
/// A pixel remembers ln I at its last event; at a read-out with |ln I - remembered| > threshold it gives one event and then
/// remembers the present ln I (Faris et al., equation 1). A fast edge costs events, as a read-out can hold only one of each
/// pixel. All events of one read-out bear its time; x ascends within it, and y within x.
///
///   I = dark + light (veil + max(0, skin + sum over the markers of share (its reflectance - skin)))
///
/// - Refractory: until that time after its event has passed, a pixel is held in reset. It gives no event, and keeps remembering
/// the
///   present ln I; what changes meanwhile is lost.
/// - Noise (leak, shot, hot pixels) is independent of time and of each other; an event of noise resets its pixel as any other
/// does.
/// - The limit of a read-out is that of the way to the host: the pixels beyond it, in the order of the events, have fired and are
///   reset, but their events are lost.
/// - A marker is cut off where it leaves the image; markers that overlap add up.
///
/// Only pixels whose light changes are looked at, so a still skin costs only its noise, unless the light flickers.
class EventCamera {
 public:
  static constexpr std::size_t max_markers = 32;

  struct ReadOut {
    std::span<const Event> events;  ///< valid until the next read-out
    /// How many of them a moving marker caused; the others are noise, or the light's flicker. Where light flickers, all that
    /// fires on a moving marker counts as caused by it.
    std::size_t caused = 0;
    std::uint32_t caused_by = 0;  ///< bit i: marker i caused at least one of them
  };

  /// @param pixels  must outlive the camera
  /// @param start   time of read-out 0
  /// @param seed    of what changes from run to run
  /// @param rest    the markers before the first read-out, `max_markers` at most
  /// @throws Error  if an option is out of range, the pixels are those of another size, or there are too many markers
  EventCamera(const CameraPixels& pixels, const EventCameraOptions& options, CameraTime start, std::uint64_t seed,
              std::span<const MarkerPose> rest);

  /// The next read-out, with the markers where they are now: as many as at the start.
  ReadOut read_out(std::span<const MarkerPose> poses);

 private:
  struct Box {
    int left = 0, top = 0, right = 0, bottom = 0;  ///< right and bottom are outside

    bool holds(int x, int y) const { return x >= left && x < right && y >= top && y < bottom; }
    bool meets(const Box& b) const { return left < b.right && b.left < right && top < b.bottom && b.top < bottom; }
    void take_in(const Box& b);
  };

  /// A marker in the image: a pixel's reflectance is the skin's plus across[x - box.left] * contrast[y - box.top].
  struct Marker {
    Box box;
    int full_left = 0, full_right = 0;  ///< from and to the columns where `across` is 1
    std::vector<float> across;
    std::vector<float> contrast;
  };

  /// A stretch of a row to be compared with what its pixels remember; its intensities stand in `intensities_`.
  struct Stretch {
    int row = 0, left = 0, right = 0;
    std::size_t intensity = 0;
    bool even = false;  ///< all see the same intensity
  };

  struct Fired {
    std::uint16_t x = 0, y = 0;
    std::uint8_t on = 0;
    std::uint8_t cause = 0;  ///< 0 noise, i + 1 marker i
  };

  /// When a hot pixel fires next.
  struct Hot {
    std::uint32_t index = 0;
    double next_readout = 0;
    double readouts_between = 0;
  };

  void place(const MarkerPose& pose, Marker& marker);
  float reflectance_at(int x, int y) const;
  float intensity_of(float reflectance) const { return base_ + light_ * reflectance; }
  float level_at(int x, int y) const;
  std::size_t index_of(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(options_.size.width) + static_cast<std::size_t>(x);
  }
  void look_at_change(const Marker& before, const Marker& now, bool sideways, std::uint8_t cause);
  void look_pixel_by_pixel(const Box& box, std::uint8_t cause);
  void look_at_all();
  void add_stretch(int row, int left, int right, const float* across, float contrast);
  void compare_stretches(std::uint8_t cause);
  void compare(const float* levels, int row, int left, int right, bool even, std::uint8_t cause);
  void fire(int x, int y, float level, bool on, std::uint8_t cause);
  void fire_without_cause(std::uint32_t index, bool on);
  void add_noise();
  void hold_in_reset();
  void sort_fired();

  const CameraPixels& pixels_;
  EventCameraOptions options_;
  double px_per_mm_;
  double readout_s_;
  CameraTime start_;
  Random random_;
  std::int32_t readout_ = 0;
  std::int32_t blind_readouts_ = 1;  ///< a pixel gives no event in so many read-outs, that of its event included
  float base_ = 0, light_ = 1;       ///< I = base + light * reflectance
  float skin_level_ = 0;
  std::vector<float> remembered_;         ///< ln I at the last event
  std::vector<std::int32_t> last_fired_;  ///< the pixel's last read-out with an event
  std::vector<MarkerPose> poses_;
  std::vector<Marker> markers_, before_;
  std::vector<Hot> hot_;
  std::vector<std::uint32_t> in_reset_;  ///< pixels that are blind for longer than the read-out of their event
  std::vector<Fired> fired_, sorted_;
  std::vector<std::uint32_t> places_;
  std::vector<Event> events_;
  std::vector<float> columns_, intensities_;
  std::size_t intensity_count_ = 0;
  std::vector<Stretch> stretches_;
  std::vector<std::uint8_t> exceeds_;
};

}  // namespace tactile
