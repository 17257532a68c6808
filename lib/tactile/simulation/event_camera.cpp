#include "tactile/simulation/event_camera.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "tactile/core/error.hpp"

namespace tactile {
namespace {

void check(const EventCameraOptions& o) {
  const auto need = [](bool met, const char* what) {
    if (!met) throw Error(fmt::format("simulated camera: {}", what));
  };
  need(o.size.width > 0 && o.size.height > 0 && o.size.width <= 32767 && o.size.height <= 32767,
       "the size is out of range; expected 1 to 32767 px a side");
  need(o.readout > 0us, "the time between read-outs is out of range; expected more than 0 us");
  need(o.threshold > 0 && o.threshold_sigma >= 0 && o.threshold_floor > 0, "a threshold is out of range; expected more than 0");
  need(o.residual >= 0 && o.residual <= 1, "the residual is out of range; expected 0 to 1");
  need(o.noise_hz >= 0 && o.noise_factor >= 0 && o.noise_spread_decades >= 0 && o.noise_on_share >= 0 && o.noise_on_share <= 1,
       "the noise is out of range; expected at least 0 Hz");
  need(o.hot_pixels >= 0 && o.hot_min_hz > 0 && o.hot_max_hz >= o.hot_min_hz,
       "the hot pixels are out of range; expected rates above 0 Hz");
  need(o.skin > 0 && o.black > 0 && o.white > 0 && o.veil >= 0, "a reflectance is out of range; expected more than 0");
  need(o.blur_px > 0, "the blur is out of range; expected more than 0 px");
}

CameraPixels::HotPixel draw_hot_pixel(const EventCameraOptions& options, Random& random) {
  const auto count = static_cast<std::uint64_t>(options.size.width) * static_cast<std::uint64_t>(options.size.height);
  const auto index = static_cast<std::uint32_t>(random.below(count));
  return {index, options.hot_min_hz * std::pow(options.hot_max_hz / options.hot_min_hz, random.uniform())};
}

int kept_hot_pixels(const EventCameraOptions& options) {
  return static_cast<int>(std::lround(options.hot_kept_share * options.hot_pixels));
}

}  // namespace

CameraPixels draw_camera_pixels(const EventCameraOptions& options, std::uint64_t seed) {
  check(options);
  Random random(seed);
  const auto count = static_cast<std::size_t>(options.size.width) * static_cast<std::size_t>(options.size.height);
  CameraPixels pixels;
  pixels.thresholds.reserve(count);
  pixels.noise_hz_up_to.reserve(count);
  // A log-normal with this spread has a mean above 1; the division keeps the mean rate what it is called.
  const double spread = options.noise_spread_decades * std::log(10.0);
  const double mean = std::exp(0.5 * spread * spread);
  double sum_hz = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double threshold = options.threshold + options.threshold_sigma * random.normal();
    pixels.thresholds.push_back(static_cast<float>(std::max(options.threshold_floor, threshold)));
    sum_hz += options.noise_hz * std::exp(spread * random.normal()) / mean;
    pixels.noise_hz_up_to.push_back(sum_hz);
  }
  for (int i = 0; i < kept_hot_pixels(options); ++i) pixels.hot.push_back(draw_hot_pixel(options, random));
  return pixels;
}

EventCamera::EventCamera(const CameraPixels& pixels, const EventCameraOptions& options, CameraTime start, std::uint64_t seed,
                         std::span<const MarkerPose> rest)
    : pixels_(pixels), options_(options), start_(start), random_(seed), poses_(rest.begin(), rest.end()) {
  check(options);
  const auto count = static_cast<std::size_t>(options.size.width) * static_cast<std::size_t>(options.size.height);
  if (pixels.thresholds.size() != count)
    throw Error("simulated camera: the pixels are those of another size; expected as many as the image has");
  skin_level_ = static_cast<float>(std::log(options_.skin + options_.veil));
  levels_.assign(count, skin_level_);
  remembered_.resize(count);
  last_fired_.assign(count, -1);
  column_.resize(static_cast<std::size_t>(options.size.width));
  row_levels_.resize(static_cast<std::size_t>(options.size.width));
  for (const MarkerPose& pose : poses_) {
    boxes_.push_back(box_of(pose));
    look_at(pose, boxes_.back(), true);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const double off = options_.residual * random_.uniform(-1.0, 1.0);
    remembered_[i] = levels_[i] + static_cast<float>(off) * pixels.thresholds[i];
  }
  std::vector<CameraPixels::HotPixel> hot = pixels.hot;
  for (int i = kept_hot_pixels(options_); i < options_.hot_pixels; ++i) hot.push_back(draw_hot_pixel(options_, random_));
  for (const auto& [index, hz] : hot) {
    const double between = 1e6 / (hz * static_cast<double>(options_.readout.count()));
    hot_.push_back({index, static_cast<std::int64_t>(between * random_.uniform()), between});
  }
}

double EventCamera::smooth_step(double distance_px) const {
  const double s = std::clamp(0.5 + 0.5 * distance_px / options_.blur_px, 0.0, 1.0);
  return s * s * (3.0 - 2.0 * s);
}

EventCamera::Box EventCamera::box_of(const MarkerPose& pose) const {
  const double half_width = 0.5 * marker_width_mm * px_per_mm * pose.scale + options_.blur_px + 1.0;
  const double half_height = marker_thickness_mm * px_per_mm * pose.scale + options_.blur_px + 1.0;
  const double left = pose.x - half_width, right = pose.x + half_width, top = pose.y - half_height, bottom = pose.y + half_height;
  if (!(left >= 0 && top >= 0 && right < options_.size.width && bottom < options_.size.height)) {
    throw Error(fmt::format("simulated camera: a marker at {:.1f}, {:.1f} px leaves the image; expected it inside {} x {} px",
                            pose.x, pose.y, options_.size.width, options_.size.height));
  }
  return {static_cast<int>(left), static_cast<int>(top), static_cast<int>(right) + 1, static_cast<int>(bottom) + 1};
}

/// Intensities in a box that holds one marker: skin + across(x) * (black_share(y) * (black - skin) + white_share(y) * (white -
/// skin)).
void EventCamera::look_at(const MarkerPose& pose, const Box& box, bool starting) {
  const double half_width = 0.5 * marker_width_mm * px_per_mm * pose.scale;
  const double thickness = marker_thickness_mm * px_per_mm * pose.scale;
  const auto width = static_cast<std::size_t>(box.right - box.left);
  for (std::size_t i = 0; i < width; ++i) {
    const double x = box.left + static_cast<double>(i) + 0.5;
    column_[i] = static_cast<float>(smooth_step(x - (pose.x - half_width)) - smooth_step(x - (pose.x + half_width)));
  }
  const CameraTime t = start_ + readout_ * options_.readout;
  for (int row = box.top; row < box.bottom; ++row) {
    const double y = row + 0.5;
    const double edge = smooth_step(y - pose.y);
    const double black_share = smooth_step(y - (pose.y - thickness)) - edge;
    const double white_share = edge - smooth_step(y - (pose.y + thickness));
    const double contrast = black_share * (options_.black - options_.skin) + white_share * (options_.white - options_.skin);
    const auto full = static_cast<float>(std::log(options_.skin + options_.veil + contrast));
    for (std::size_t i = 0; i < width; ++i) {
      const float across = column_[i];
      row_levels_[i] = across == 1.0F   ? full
                       : across == 0.0F ? skin_level_
                                        : std::log(static_cast<float>(options_.skin + options_.veil + across * contrast));
    }
    const std::size_t first =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(options_.size.width) + static_cast<std::size_t>(box.left);
    std::copy_n(row_levels_.data(), width, levels_.data() + first);
    if (starting) continue;
    float* remembered = remembered_.data() + first;
    const float* thresholds = pixels_.thresholds.data() + first;
    int any = 0;
    for (std::size_t i = 0; i < width; ++i) any |= static_cast<int>(std::fabs(row_levels_[i] - remembered[i]) > thresholds[i]);
    if (any == 0) continue;
    for (std::size_t i = 0; i < width; ++i) {
      const float change = row_levels_[i] - remembered[i];
      if (!(std::fabs(change) > thresholds[i])) continue;
      remembered[i] = row_levels_[i];
      last_fired_[first + i] = readout_;
      events_.push_back({.t = t,
                         .x = static_cast<std::int16_t>(box.left + static_cast<int>(i)),
                         .y = static_cast<std::int16_t>(row),
                         .on = static_cast<std::uint8_t>(change > 0)});
    }
  }
}

void EventCamera::fire_without_cause(std::uint32_t index, bool on) {
  if (last_fired_[index] == readout_) return;
  last_fired_[index] = readout_;
  remembered_[index] = levels_[index];
  const auto width = static_cast<std::uint32_t>(options_.size.width);
  events_.push_back({.t = start_ + readout_ * options_.readout,
                     .x = static_cast<std::int16_t>(index % width),
                     .y = static_cast<std::int16_t>(index / width),
                     .on = static_cast<std::uint8_t>(on)});
}

void EventCamera::add_noise() {
  const std::vector<double>& up_to = pixels_.noise_hz_up_to;
  const double mean = options_.noise_factor * up_to.back() * 1e-6 * static_cast<double>(options_.readout.count());
  for (std::uint64_t left = random_.poisson(mean); left > 0; --left) {
    const auto found = std::upper_bound(up_to.begin(), up_to.end(), random_.uniform() * up_to.back());
    const auto index = static_cast<std::uint32_t>(std::min<std::ptrdiff_t>(found - up_to.begin(), std::ssize(up_to) - 1));
    fire_without_cause(index, random_.uniform() < options_.noise_on_share);
  }
  for (Fire& hot : hot_) {
    if (hot.next_readout > readout_) continue;
    fire_without_cause(hot.index, random_.uniform() < options_.noise_on_share);
    // Half regular, half random: a hot pixel recharges before it can fire again.
    const double between = hot.readouts_between * (0.5 + 0.5 * random_.exponential());
    hot.next_readout = readout_ + std::max<std::int64_t>(1, std::llround(between));
  }
}

EventCamera::ReadOut EventCamera::read_out(std::span<const MarkerPose> poses) {
  assert(poses.size() == poses_.size() && "a read-out shows the markers that were there at the start");
  events_.clear();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i] == poses_[i]) continue;
    const Box now = box_of(poses[i]);
    const Box& then = boxes_[i];
    look_at(poses[i],
            {std::min(now.left, then.left), std::min(now.top, then.top), std::max(now.right, then.right),
             std::max(now.bottom, then.bottom)},
            false);
    boxes_[i] = now;
    poses_[i] = poses[i];
  }
  const std::size_t caused = events_.size();
  add_noise();
  ++readout_;
  std::sort(events_.begin(), events_.end(), [](const Event& a, const Event& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  return {events_, caused};
}

}  // namespace tactile
