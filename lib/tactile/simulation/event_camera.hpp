#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/core/time.hpp"
#include "tactile/events/event.hpp"
#include "tactile/simulation/background_noise.hpp"
#include "tactile/simulation/camera_pixels.hpp"
#include "tactile/simulation/event_camera_options.hpp"
#include "tactile/simulation/readout_clock.hpp"
#include "tactile/simulation/skin.hpp"

namespace tactile::simulation {

/// An event camera before moving markers.
///
/// A pixel remembers ln I at its last event. At a read-out with |ln I - remembered| > threshold it gives one event and then
/// remembers the present ln I (Faris et al., equation 1). A fast edge loses events, because a read-out has at most one per pixel.
/// ReadoutClock gives the times of the read-outs and the stamps of their events, which ascend; without a scan, x ascends within a
/// read-out, and y within x.
///
///   I = dark + light (veil + max(0, skin + sum over the markers of share (its reflectance - skin)))
///
/// - Bandwidth: a pixel does not see ln I but follows it, as a low-pass of first order with the cut-off
///   bandwidth_hz (bandwidth_floor + (1 - bandwidth_floor) I), so slower in the dark (as in v2e). This holds for what markers
///   change; flicker and the slow drift of the light are slower and are seen as they are.
/// - Slow drift of the light: each pixel is compared every `drift_rows` read-outs, unless a marker changes it.
/// - Refractory time: for this time after its event, a pixel is in reset. It gives no event and remembers the present ln I, so
/// changes
///   in this time are lost.
/// - Noise (background, leak, shot, hot and stuck pixels) is independent of the light's changes. An event of noise resets its
/// pixel
///   as any other event.
/// - The limit of a read-out is that of the transfer to the host: further pixels, in the order of the events, have fired and are
/// reset,
///   but their events are lost.
/// - Markers are cut off at the border of the image. Overlapping markers add up, or the nearer one hides the other (`hiding`).
/// - A rotated marker is drawn sheared: its ends stay upright.
/// - Shadow: a tip that is pushed inward by q darkens the skin below its marker by the share `shadow`, over shadow_mm_per_mm q.
///
/// Only pixels whose light changes are evaluated. So a still skin costs only its noise, unless the light flickers or drifts.
class EventCamera {
 public:
  static constexpr std::size_t max_markers = 32;
  static constexpr int drift_rows = 256;

  struct ReadOut {
    std::span<const events::Event> events;  ///< valid until the next read-out
    /// Events due to a moving marker; the others are noise or flicker. With flicker, all events on a moving marker count.
    std::size_t caused = 0;
    std::uint32_t caused_by = 0;           ///< bit i: marker i caused at least one of them
    std::span<const CameraTime> first_by;  ///< of each marker, the stamp of its first event if it caused any
  };

  /// @param pixels  must outlive the camera
  /// @param start   time of read-out 0
  /// @param seed    of the noise of this run
  /// @param rest    the markers before the first read-out, `max_markers` at most
  /// @throws Error  if an option is out of range, the pixels belong to another size, or there are too many markers
  EventCamera(const CameraPixels& pixels, const EventCameraOptions& options, CameraTime start, std::uint64_t seed,
              std::span<const MarkerPose> rest);

  double next_us() const { return clock_.next_us(); }  ///< when the next read-out begins, since the start

  /// The next read-out, with the poses of the markers at its start: as many as at the start.
  ReadOut read_out(std::span<const MarkerPose> poses);

 private:
  struct Box {
    int left = 0, top = 0, right = 0, bottom = 0;  ///< right and bottom are outside

    bool holds(int x, int y) const { return x >= left && x < right && y >= top && y < bottom; }
    bool meets(const Box& b) const { return left < b.right && b.left < right && top < b.bottom && b.top < bottom; }
    void take_in(const Box& b);
  };

  /// A marker in the image: a pixel's reflectance is the skin's plus across[x - box.left] * contrast_at(x, y).
  struct Marker {
    Box box;
    int full_left = 0, full_right = 0;  ///< from and to the columns where `across` is 1
    int strip_px = 1 << 16;             ///< a rotated marker consists of upright strips, each a little lower than the one before
    double scale = 1;
    std::vector<float> across;
    std::vector<float> contrast;  ///< of each strip, its rows
    std::vector<float> cover;     ///< the same: the share of the light that comes from the marker itself, with `hiding`

    int rows() const { return box.bottom - box.top; }
    std::size_t place(int x, int y) const { return static_cast<std::size_t>((x - box.left) / strip_px * rows() + y - box.top); }
    float across_at(int x) const { return across[static_cast<std::size_t>(x - box.left)]; }
  };

  /// Where pixels still follow the changes of a marker.
  struct Trail {
    Box area, recent;  ///< `recent` since `turn`; together they hold what changed in the last `settle_readouts_`
    std::int32_t turn = 0;
    std::int32_t drawn = -1'000'000;  ///< the last time
    double moved_px = 0;              ///< since then
    bool active = false;
  };

  /// A part of a row that is compared with the memory of its pixels; its intensities are in `intensities_`.
  struct Stretch {
    int row = 0, left = 0, right = 0;
    std::size_t intensity = 0;
    bool even = false;  ///< the same intensity for all
  };

  struct Fired {
    std::uint16_t x = 0, y = 0;
    std::uint8_t on = 0;
    std::uint8_t cause = 0;  ///< 0 noise, i + 1 marker i
  };

  /// When a hot pixel fires next.
  struct Hot {
    std::uint32_t index = 0;
    double on_share = 0;
    double next_readout = 0;
    double readouts_between = 0;
  };

  void place(const MarkerPose& pose, Marker& marker);
  void draw_strips(const MarkerPose& pose, double gradient, double shadow_px, Marker& marker);
  float reflectance_at(int x, int y) const;
  float intensity_of(float reflectance) const { return base_ + light_ * reflectance; }
  float level_at(int x, int y) const;
  std::size_t index_of(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(options_.size.width) + static_cast<std::size_t>(x);
  }
  void look_at_moved(std::size_t m, std::uint32_t moved, bool sideways);
  void look_at_change(const Marker& before, const Marker& now, bool sideways, std::uint8_t cause);
  void look_pixel_by_pixel(const Box& box, std::uint8_t cause);
  bool is_alone(std::size_t m, const Box& area, std::uint32_t moved) const;
  void follow(std::size_t m, std::uint32_t moved);
  void find_levels(const Marker& marker, int left_end, int right_end);
  bool moves_visibly(std::size_t m, const MarkerPose& pose);
  void look_at_area(const Box& area, const Marker& marker, bool at_once, std::uint8_t cause);
  void follow_row(int row, int left, int right, std::uint8_t cause);
  float kept_at(float level) const;
  void look_at_rows(int first, int step);
  void look_at_marker_rows(std::size_t m, int first, int step);
  void change_light(double t_s);
  void add_stretch(int row, int left, int right, const float* across, float contrast);
  void compare_stretches(std::uint8_t cause);
  void compare(const float* levels, int row, int left, int right, bool even, std::uint8_t cause);
  void fire(int x, int y, float level, bool on, std::uint8_t cause);
  void fire_without_cause(std::uint32_t index, bool on);
  void add_noise();
  void begin_to_follow();
  void draw_hot();
  void hold_in_reset();
  void sort_fired();
  ReadOut collect_fired();

  const CameraPixels& pixels_;
  EventCameraOptions options_;
  double px_per_mm_;
  double readout_s_;
  CameraTime start_;
  ReadoutClock clock_;
  Random random_;
  BackgroundNoise background_;
  std::int32_t readout_ = 0;
  std::int32_t blind_readouts_ = 1;  ///< read-outs without another event of a pixel, including that of its event
  float base_ = 0, light_ = 1;       ///< I = base + light * reflectance
  float skin_level_ = 0;
  std::vector<float> remembered_;         ///< ln I at the last event
  std::vector<std::int32_t> last_fired_;  ///< the pixel's last read-out with an event
  std::vector<MarkerPose> poses_;
  std::vector<Marker> markers_, before_;
  bool follows_ = false;  ///< pixels follow their light with a delay, or markers are rotated
  std::int32_t settle_readouts_ = 0;
  std::vector<float> kept_;  ///< of a pixel's distance from its light, per read-out, by ln I
  std::vector<float> seen_;  ///< what a pixel sees, if `follows_`
  std::vector<Trail> trails_;
  std::vector<Hot> hot_, stuck_;
  std::vector<std::uint32_t> in_reset_;  ///< pixels in reset for longer than one read-out
  std::vector<Fired> fired_, sorted_;
  std::vector<std::uint32_t> places_;
  std::vector<events::Event> events_;
  std::vector<CameraTime> first_by_;
  std::vector<float> columns_, intensities_, levels_, keeps_, strip_levels_, end_levels_;
  std::size_t intensity_count_ = 0;
  std::vector<Stretch> stretches_;
  std::vector<std::uint8_t> exceeds_;
};

}  // namespace tactile::simulation
