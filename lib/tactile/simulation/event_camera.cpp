#include "tactile/simulation/event_camera.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>

#include "tactile/core/error.hpp"

namespace tactile::simulation {
namespace {

constexpr double shot_share_at_white = 0.25;    // of the shot noise in the dark (v2e)
constexpr std::int32_t long_ago = -20'000'000;  // in read-outs, longer than any reset

/// ln of each value, which must be positive and normal: x = 2^k m with m from 1/sqrt(2) to sqrt(2), and
/// ln m = 2 (s + s^3/3 + s^5/5 + s^7/7 + s^9/9) with s = (m - 1) / (m + 1), accurate to float. The simple steps allow the
/// compiler to vectorise.
void take_logs(float* values, std::size_t count) {
  constexpr std::uint32_t root_half = 0x3f3504f3;  // 1/sqrt(2)
  for (std::size_t i = 0; i < count; ++i) {
    const auto bits = std::bit_cast<std::uint32_t>(values[i]);
    const std::int32_t k = static_cast<std::int32_t>(bits - root_half) >> 23;
    const auto m = std::bit_cast<float>(bits - (static_cast<std::uint32_t>(k) << 23));
    const float s = (m - 1.0F) / (m + 1.0F), q = s * s;
    const float series = q * (1.0F / 3 + q * (1.0F / 5 + q * (1.0F / 7 + q * (1.0F / 9))));
    values[i] = static_cast<float>(k) * std::numbers::ln2_v<float> + (2.0F * s + 2.0F * s * series);
  }
}

float log_of(float value) {
  take_logs(&value, 1);
  return value;
}

/// A blurred edge: values[i] = smoothstep of (i + 0.5 - edge) over `blur` on both sides of it, 0 to 1.
void draw_edge(double edge, double blur, float* values, int count) {
  const auto inside = [&](double i) { return i > 0 ? static_cast<int>(std::min<double>(i, count)) : 0; };
  const int from = inside(std::floor(edge - blur)), to = inside(std::ceil(edge + blur));
  std::fill(values, values + from, 0.0F);
  for (int i = from; i < to; ++i) {
    const double s = std::clamp(0.5 + 0.5 * (i + 0.5 - edge) / blur, 0.0, 1.0);
    values[i] = static_cast<float>(s * s * (3.0 - 2.0 * s));
  }
  std::fill(values + to, values + count, 1.0F);
}

}  // namespace

void EventCamera::Box::take_in(const Box& b) {
  left = std::min(left, b.left);
  top = std::min(top, b.top);
  right = std::max(right, b.right);
  bottom = std::max(bottom, b.bottom);
}

EventCamera::EventCamera(const CameraPixels& pixels, const EventCameraOptions& options, CameraTime start, std::uint64_t seed,
                         std::span<const MarkerPose> rest)
    : pixels_(pixels),
      options_(options),
      px_per_mm_(view_of(options).px_per_mm),
      readout_s_(1e-6 * static_cast<double>(options.readout.count())),
      start_(start),
      random_(seed),
      poses_(rest.begin(), rest.end()),
      markers_(rest.size()),
      before_(rest.size()) {
  check(options);
  const std::size_t count = pixel_count(options.size);
  if (pixels.thresholds.size() != count)
    throw Error("simulated camera: the pixels are those of another size; expected as many as the image has");
  if (rest.size() > max_markers)
    throw Error(fmt::format("simulated camera: {} markers; expected {} at most", rest.size(), max_markers));
  const std::int64_t blind = (options.refractory + options.readout - microseconds{1}) / options.readout;
  blind_readouts_ = static_cast<std::int32_t>(std::max<std::int64_t>(1, blind));
  base_ = static_cast<float>(options.dark + options.veil);
  skin_level_ = log_of(intensity_of(static_cast<float>(options.skin)));

  remembered_.assign(count, skin_level_);
  last_fired_.assign(count, long_ago);
  for (std::size_t m = 0; m < poses_.size(); ++m) place(poses_[m], markers_[m]);
  for (const Marker& marker : markers_) {
    for (int y = marker.box.top; y < marker.box.bottom; ++y) {
      for (int x = marker.box.left; x < marker.box.right; ++x) remembered_[index_of(x, y)] = level_at(x, y);
    }
  }
  if (options.residual > 0) {
    for (std::size_t i = 0; i < count; ++i) {
      const auto off = static_cast<float>(options.residual * random_.uniform(-1.0, 1.0));
      if (!std::isinf(pixels.thresholds[i])) remembered_[i] += off * pixels.thresholds[i];
    }
  }
  for (const auto& [index, hz] : hot_pixels_of_run(pixels, options.run_index)) {
    const double between = std::max(0.01, 1.0 / (hz * readout_s_));  // at most one event per read-out
    hot_.push_back({index, between * random_.uniform(), between});
  }
}

void EventCamera::place(const MarkerPose& pose, Marker& marker) {
  const double half_width = 0.5 * marker_width_mm * px_per_mm_ * pose.scale;
  const double thickness = marker_thickness_mm * px_per_mm_ * pose.scale, blur = options_.blur_px;
  const auto inside = [](double px, int size) { return px > 0 ? static_cast<int>(std::min<double>(px, size)) : 0; };
  Box& box = marker.box;
  const auto [width, height] = options_.size;
  // From and to the first pixel whose middle an edge's blur does not reach.
  box = {inside(pose.x - half_width - blur + 0.5, width), inside(pose.y - thickness - blur + 0.5, height),
         inside(pose.x + half_width + blur + 0.5, width), inside(pose.y + thickness + blur + 0.5, height)};
  if (box.left >= box.right || box.top >= box.bottom) box = {};
  const int columns = box.right - box.left, rows = box.bottom - box.top;
  columns_.resize(static_cast<std::size_t>(std::max(columns, 2 * rows)));

  marker.across.resize(static_cast<std::size_t>(columns));
  draw_edge(pose.x - half_width - box.left, blur, marker.across.data(), columns);
  draw_edge(pose.x + half_width - box.left, blur, columns_.data(), columns);
  for (std::size_t i = 0; i < marker.across.size(); ++i) marker.across[i] -= columns_[i];
  marker.full_left = inside(pose.x - half_width + blur + 0.5, width);
  marker.full_right = inside(pose.x + half_width - blur + 0.5, width);
  if (marker.full_left >= marker.full_right) marker.full_left = marker.full_right = box.right;

  marker.contrast.resize(static_cast<std::size_t>(rows));
  float *const middle = columns_.data(), *const lower = middle + rows;
  draw_edge(pose.y - thickness - box.top, blur, marker.contrast.data(), rows);
  draw_edge(pose.y - box.top, blur, middle, rows);
  draw_edge(pose.y + thickness - box.top, blur, lower, rows);
  const auto black = static_cast<float>(options_.black - options_.skin),
             white = static_cast<float>(options_.white - options_.skin);
  for (int i = 0; i < rows; ++i) {
    float& contrast = marker.contrast[static_cast<std::size_t>(i)];
    contrast = black * (contrast - middle[i]) + white * (middle[i] - lower[i]);
  }
}

/// Reflectance of the skin with its markers.
float EventCamera::reflectance_at(int x, int y) const {
  auto reflectance = static_cast<float>(options_.skin);
  for (const Marker& marker : markers_) {
    if (!marker.box.holds(x, y)) continue;
    reflectance += marker.across[static_cast<std::size_t>(x - marker.box.left)] *
                   marker.contrast[static_cast<std::size_t>(y - marker.box.top)];
  }
  return std::max(0.0F, reflectance);
}

float EventCamera::level_at(int x, int y) const { return log_of(intensity_of(reflectance_at(x, y))); }

/// @param across  of each column from `left` on; nullptr: all 1
void EventCamera::add_stretch(int row, int left, int right, const float* across, float contrast) {
  if (left >= right) return;
  const auto skin = static_cast<float>(options_.skin);
  const auto count = static_cast<std::size_t>(right - left), first = intensity_count_;
  const bool even = across == nullptr;
  intensity_count_ += even ? 1 : count;
  if (intensities_.size() < intensity_count_) intensities_.resize(2 * intensity_count_);
  stretches_.push_back({row, left, right, first, even});
  float* intensities = intensities_.data() + first;
  if (even) {
    *intensities = intensity_of(std::max(0.0F, skin + contrast));
  } else {
    for (std::size_t i = 0; i < count; ++i) intensities[i] = intensity_of(std::max(0.0F, skin + across[i] * contrast));
  }
}

void EventCamera::compare_stretches(std::uint8_t cause) {
  take_logs(intensities_.data(), intensity_count_);
  for (const Stretch& s : stretches_) compare(intensities_.data() + s.intensity, s.row, s.left, s.right, s.even, cause);
  stretches_.clear();
  intensity_count_ = 0;
}

/// Fires the pixels of a row whose ln I differs too much from their memory.
/// @param levels  ln I of each pixel, or one value for all if `even`
void EventCamera::compare(const float* levels, int row, int left, int right, bool even, std::uint8_t cause) {
  const std::size_t first = index_of(left, row), count = static_cast<std::size_t>(right - left);
  const float* remembered = remembered_.data() + first;
  const float* thresholds = pixels_.thresholds.data() + first;
  if (!even) {  // a few pixels at a marker's end
    for (std::size_t i = 0; i < count; ++i) {
      const float change = levels[i] - remembered[i];
      if (std::fabs(change) > thresholds[i]) fire(left + static_cast<int>(i), row, levels[i], change > 0, cause);
    }
    return;
  }
  // One byte per pixel; eight are tested at once.
  const float level = *levels;
  constexpr std::size_t together = 8;
  exceeds_.resize(count + together);
  std::uint8_t* exceeds = exceeds_.data();
  for (std::size_t i = 0; i < count; ++i)
    exceeds[i] = static_cast<std::uint8_t>(std::fabs(level - remembered[i]) > thresholds[i]);
  std::fill_n(exceeds + count, together, std::uint8_t{0});
  for (std::size_t i = 0; i < count; i += together) {
    std::uint64_t any = 0;
    std::memcpy(&any, exceeds + i, together);
    for (; any != 0; any &= any - 1) {
      const auto byte = static_cast<std::size_t>(std::countr_zero(any)) / 8;
      const std::size_t fired = i + (std::endian::native == std::endian::little ? byte : together - 1 - byte);
      fire(left + static_cast<int>(fired), row, level, level > remembered[fired], cause);
    }
  }
}

/// Evaluates the pixels whose light differs between the two markers; either may be empty.
/// @param sideways  whether any column may differ
void EventCamera::look_at_change(const Marker& before, const Marker& now, bool sideways, std::uint8_t cause) {
  const bool was = !before.across.empty(), is = !now.across.empty();
  if (!was && !is) return;
  Box all = is ? now.box : before.box;
  if (was) all.take_in(before.box);
  columns_.assign(static_cast<std::size_t>(all.right - all.left), 0.0F);
  const auto across_from = [&](int column) { return columns_.data() + (column - all.left); };
  std::copy(now.across.begin(), now.across.end(), columns_.begin() + (is ? now.box.left - all.left : 0));
  const int full_left = is ? now.full_left : all.right, full_right = is ? now.full_right : all.right;
  // The columns at the ends of both.
  const int left_end = was && is ? std::max(before.full_left, now.full_left) : all.right;
  const int right_end = was && is ? std::max(left_end, std::min(before.full_right, now.full_right)) : all.right;
  const auto contrast_at = [](const Marker& marker, int row) {
    return row >= marker.box.top && row < marker.box.bottom ? marker.contrast[static_cast<std::size_t>(row - marker.box.top)]
                                                            : 0.0F;
  };
  for (int row = all.top; row < all.bottom; ++row) {
    const float contrast = contrast_at(now, row);
    if (contrast != contrast_at(before, row)) {
      add_stretch(row, all.left, full_left, across_from(all.left), contrast);
      add_stretch(row, full_left, full_right, nullptr, contrast);
      add_stretch(row, full_right, all.right, across_from(full_right), contrast);
    } else if (contrast != 0.0F && sideways) {
      add_stretch(row, all.left, left_end, across_from(all.left), contrast);
      add_stretch(row, right_end, all.right, across_from(right_end), contrast);
    }
  }
  compare_stretches(cause);
}

void EventCamera::look_pixel_by_pixel(const Box& box, std::uint8_t cause) {
  for (int row = box.top; row < box.bottom; ++row) {
    for (int x = box.left; x < box.right; ++x) {
      const float level = level_at(x, row);
      compare(&level, row, x, x + 1, false, cause);
    }
  }
}

/// Evaluates the whole image, because the light has changed.
void EventCamera::look_at_all() {
  const std::size_t count = markers_.size();
  std::vector<const Box*> boxes;
  for (std::size_t m = 0; m < count; ++m) {
    const Box& box = markers_[m].box;
    if (box.left < box.right) boxes.push_back(&box);
    bool alone = true;
    for (std::size_t n = 0; n < count; ++n) alone = alone && (n == m || !markers_[n].box.meets(box));
    if (!alone) {
      look_pixel_by_pixel(box, 0);
      continue;
    }
    for (int row = box.top; row < box.bottom; ++row)
      add_stretch(row, box.left, box.right, markers_[m].across.data(),
                  markers_[m].contrast[static_cast<std::size_t>(row - box.top)]);
    compare_stretches(0);
  }
  std::sort(boxes.begin(), boxes.end(), [](const Box* a, const Box* b) { return a->left < b->left; });
  for (int row = 0; row < options_.size.height; ++row) {
    const auto compare_skin = [&](int left, int right) {
      if (left < right) compare(&skin_level_, row, left, right, true, 0);
    };
    int seen = 0;
    for (const Box* box : boxes) {
      if (row < box->top || row >= box->bottom) continue;
      compare_skin(seen, box->left);
      seen = std::max(seen, box->right);
    }
    compare_skin(seen, options_.size.width);
  }
}

void EventCamera::fire(int x, int y, float level, bool on, std::uint8_t cause) {
  const std::size_t index = index_of(x, y);
  if (readout_ - last_fired_[index] < blind_readouts_) return;
  last_fired_[index] = readout_;
  remembered_[index] = level;
  fired_.push_back({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y), static_cast<std::uint8_t>(on), cause});
  if (blind_readouts_ > 1) in_reset_.push_back(static_cast<std::uint32_t>(index));
}

void EventCamera::fire_without_cause(std::uint32_t index, bool on) {
  if (readout_ - last_fired_[index] < blind_readouts_) return;
  const int x = static_cast<int>(index) % options_.size.width, y = static_cast<int>(index) / options_.size.width;
  fire(x, y, level_at(x, y), on, 0);
}

void EventCamera::add_noise() {
  // With more draws, every pixel has an event.
  const std::uint64_t enough = 16 * pixels_.thresholds.size();
  const auto draws = [&](double hz, const PixelLottery& lottery) {
    const double mean = hz * options_.noise_factor * readout_s_ * lottery.weight_sum();
    return mean > 0 ? std::min(enough, random_.poisson(mean)) : 0;
  };
  for (std::uint64_t left = draws(options_.leak_hz, pixels_.leak); left > 0; --left)
    fire_without_cause(pixels_.leak.draw(random_), true);
  for (std::uint64_t left = draws(options_.shot_hz, pixels_.shot); left > 0; --left) {
    const std::uint32_t index = pixels_.shot.draw(random_);
    const double chance = random_.uniform();
    const auto i = static_cast<int>(index);
    const float brightness =
        intensity_of(reflectance_at(i % options_.size.width, i / options_.size.width)) - static_cast<float>(options_.dark);
    const double kept = 1.0 - (1.0 - shot_share_at_white) * std::min(1.0, static_cast<double>(brightness));
    if (chance < kept) fire_without_cause(index, chance < 0.5 * kept);
  }
  for (Hot& hot : hot_) {
    if (hot.next_readout > readout_) continue;
    fire_without_cause(hot.index, random_.uniform() < options_.hot_on_share);
    // Half regular, half random: a hot pixel recharges before it fires again. Several times in a read-out give one event.
    while (hot.next_readout <= readout_) hot.next_readout += hot.readouts_between * (0.5 + 0.5 * random_.exponential());
  }
}

void EventCamera::hold_in_reset() {
  std::erase_if(in_reset_, [&](std::uint32_t index) {
    remembered_[index] = level_at(static_cast<int>(index) % options_.size.width, static_cast<int>(index) / options_.size.width);
    return readout_ + 1 - last_fired_[index] >= blind_readouts_;
  });
}

/// Sorts by x, then y, with two stable counting sorts, because there are few different values.
void EventCamera::sort_fired() {
  if (fired_.size() < 32) {
    std::sort(fired_.begin(), fired_.end(), [](const Fired& a, const Fired& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
    return;
  }
  sorted_.resize(fired_.size());
  const auto sort_by = [&](auto place_of, int places) {
    places_.assign(static_cast<std::size_t>(places) + 1, 0);
    for (const Fired& fired : fired_) ++places_[place_of(fired) + 1U];
    for (std::size_t i = 1; i < places_.size(); ++i) places_[i] += places_[i - 1];
    for (const Fired& fired : fired_) sorted_[places_[place_of(fired)]++] = fired;
    fired_.swap(sorted_);
  };
  sort_by([](const Fired& fired) { return fired.y; }, options_.size.height);
  sort_by([](const Fired& fired) { return fired.x; }, options_.size.width);
}

/// Evaluates the pixels of marker `m`, which has moved. @param moved  bit i: marker i has moved
void EventCamera::look_at_moved(std::size_t m, std::uint32_t moved, bool sideways) {
  const Marker &before = before_[m], &now = markers_[m];
  const auto cause = static_cast<std::uint8_t>(m + 1);
  bool alone = true;
  for (std::size_t n = 0; n < markers_.size(); ++n) {
    if (n == m) continue;
    const bool meets = markers_[n].box.meets(before.box) || markers_[n].box.meets(now.box) ||
                       ((moved >> n & 1U) != 0 && (before_[n].box.meets(before.box) || before_[n].box.meets(now.box)));
    alone = alone && !meets;
  }
  if (!alone) {
    look_pixel_by_pixel(before.box, cause);
    look_pixel_by_pixel(now.box, cause);
  } else if (before.box.meets(now.box)) {
    look_at_change(before, now, sideways, cause);
  } else {
    look_at_change(before, {}, true, cause);
    look_at_change({}, now, true, cause);
  }
}

/// The events of this read-out, sorted and limited.
EventCamera::ReadOut EventCamera::collect_fired() {
  sort_fired();
  fired_.resize(std::min(fired_.size(), static_cast<std::size_t>(options_.readout_limit)));
  ReadOut seen;
  events_.resize(fired_.size());
  const CameraTime t = start_ + readout_ * options_.readout;
  for (std::size_t i = 0; i < fired_.size(); ++i) {
    const Fired& fired = fired_[i];
    events_[i] = {.t = t, .x = static_cast<std::int16_t>(fired.x), .y = static_cast<std::int16_t>(fired.y), .on = fired.on};
    if (fired.cause == 0) continue;
    ++seen.caused;
    seen.caused_by |= 1U << (fired.cause - 1U);
  }
  seen.events = events_;
  fired_.clear();
  return seen;
}

EventCamera::ReadOut EventCamera::read_out(std::span<const MarkerPose> poses) {
  assert(poses.size() == poses_.size() && "a read-out shows the markers that were there at the start");
  const bool flickers = options_.flicker_depth > 0;
  if (flickers) {
    const double phase = 2.0 * std::numbers::pi * options_.flicker_hz * readout_s_ * readout_;
    const double light = 1.0 + options_.flicker_depth * std::sin(phase);
    light_ = static_cast<float>(light);
    base_ = static_cast<float>(options_.dark + light * options_.veil);
    skin_level_ = log_of(intensity_of(static_cast<float>(options_.skin)));
  }
  std::uint32_t moved = 0, sideways = 0;
  for (std::size_t m = 0; m < poses.size(); ++m) {
    if (poses[m] == poses_[m]) continue;
    moved |= 1U << m;
    if (poses[m].x != poses_[m].x || poses[m].scale != poses_[m].scale) sideways |= 1U << m;
    poses_[m] = poses[m];
    std::swap(before_[m], markers_[m]);
    place(poses[m], markers_[m]);
  }
  for (std::size_t m = 0; m < poses.size(); ++m) {
    if ((moved >> m & 1U) != 0) look_at_moved(m, moved, (sideways >> m & 1U) != 0);
  }
  if (flickers) look_at_all();
  add_noise();
  if (!in_reset_.empty()) hold_in_reset();
  const ReadOut seen = collect_fired();
  ++readout_;
  return seen;
}

}  // namespace tactile::simulation
