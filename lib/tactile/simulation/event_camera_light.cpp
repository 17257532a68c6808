// The light of the skin and its markers, and which pixels answer it.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "tactile/simulation/event_camera.hpp"
#include "tactile/simulation/fast_log.hpp"

namespace tactile::simulation {
namespace {

/// The strips of a rotated marker are so narrow that one is at most a quarter of a pixel lower than the one before.
int strip_width(double gradient) {
  if (gradient == 0) return 1 << 16;
  return std::clamp(static_cast<int>(0.25 / std::abs(gradient)), 1, 1 << 16);
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

void EventCamera::place(const MarkerPose& pose, Marker& marker) {
  const double half_width = 0.5 * marker_width_mm * px_per_mm_ * pose.scale;
  const double thickness = marker_thickness_mm * px_per_mm_ * pose.scale, blur = options_.blur_px;
  const double inward_mm = std::max(0.0, (pose.scale - 1.0) * eye_distance_mm);
  const double shadow_px = options_.shadow > 0 ? options_.shadow_mm_per_mm * inward_mm * px_per_mm_ : 0.0;
  const double gradient = std::tan(options_.rotation_rad), rise = std::abs(gradient) * (half_width + blur);
  const auto inside = [](double px, int size) { return px > 0 ? static_cast<int>(std::min<double>(px, size)) : 0; };
  Box& box = marker.box;
  const auto [width, height] = options_.size;
  // From and to the first pixel whose middle an edge's blur does not reach.
  box = {inside(pose.x - half_width - blur + 0.5, width), inside(pose.y - thickness - rise - blur + 0.5, height),
         inside(pose.x + half_width + blur + 0.5, width), inside(pose.y + thickness + shadow_px + rise + blur + 0.5, height)};
  if (box.left >= box.right || box.top >= box.bottom) box = {};
  const int columns = box.right - box.left, rows = box.bottom - box.top;
  columns_.resize(static_cast<std::size_t>(std::max(columns, 3 * rows)));

  marker.scale = pose.scale;
  marker.across.resize(static_cast<std::size_t>(columns));
  draw_edge(pose.x - half_width - box.left, blur, marker.across.data(), columns);
  draw_edge(pose.x + half_width - box.left, blur, columns_.data(), columns);
  for (std::size_t i = 0; i < marker.across.size(); ++i) marker.across[i] -= columns_[i];
  marker.full_left = inside(pose.x - half_width + blur + 0.5, width);
  marker.full_right = inside(pose.x + half_width - blur + 0.5, width);
  if (marker.full_left >= marker.full_right) marker.full_left = marker.full_right = box.right;
  marker.strip_px = strip_width(gradient);
  draw_strips(pose, gradient, shadow_px, marker);
}

/// Draws the rows of each strip.
void EventCamera::draw_strips(const MarkerPose& pose, double gradient, double shadow_px, Marker& marker) {
  const double thickness = marker_thickness_mm * px_per_mm_ * pose.scale, blur = options_.blur_px;
  const auto black = static_cast<float>(options_.black - options_.skin),
             white = static_cast<float>(options_.white - options_.skin),
             shadow = static_cast<float>(-options_.shadow * options_.skin);
  const Box& box = marker.box;
  const int rows = marker.rows(), strips = (box.right - box.left + marker.strip_px - 1) / marker.strip_px;
  marker.contrast.resize(static_cast<std::size_t>(strips) * static_cast<std::size_t>(rows));
  marker.cover.resize(options_.hiding ? marker.contrast.size() : 0);
  float *const middle = columns_.data(), *const lower = middle + rows, *const end = lower + rows;
  for (int strip = 0; strip < strips; ++strip) {
    double y = pose.y - box.top;
    if (gradient != 0) y += gradient * (box.left + (strip + 0.5) * marker.strip_px - pose.x);
    float* const contrasts = marker.contrast.data() + static_cast<std::ptrdiff_t>(strip) * rows;
    draw_edge(y - thickness, blur, contrasts, rows);
    draw_edge(y, blur, middle, rows);
    draw_edge(y + thickness, blur, lower, rows);
    if (shadow_px > 0) draw_edge(y + thickness + shadow_px, blur, end, rows);
    for (int i = 0; i < rows; ++i) {
      const float upper = contrasts[i];
      contrasts[i] = black * (upper - middle[i]) + white * (middle[i] - lower[i]);
      if (shadow_px > 0) contrasts[i] += shadow * (lower[i] - end[i]);
      if (options_.hiding) marker.cover[static_cast<std::size_t>(strip * rows + i)] = upper - lower[i];
    }
  }
}

/// Reflectance of the skin with its markers.
float EventCamera::reflectance_at(int x, int y) const {
  auto reflectance = static_cast<float>(options_.skin);
  const Marker* nearest = nullptr;
  for (const Marker& marker : markers_) {
    if (!marker.box.holds(x, y)) continue;
    const float own = marker.across_at(x) * marker.contrast[marker.place(x, y)];
    if (!options_.hiding || nearest == nullptr) {
      reflectance += own;
      nearest = &marker;
      continue;
    }
    // The nearer of two hides what the other one adds.
    const bool hides = marker.scale > nearest->scale;
    const Marker& upper = hides ? marker : *nearest;
    const float left = 1.0F - upper.across_at(x) * upper.cover[upper.place(x, y)], skin = static_cast<float>(options_.skin);
    reflectance = hides ? skin + (reflectance - skin) * left + own : reflectance + own * left;
    nearest = &upper;
  }
  return std::max(0.0F, reflectance);
}

/// ln I of the light, whether a pixel sees it already or not.
float EventCamera::level_at(int x, int y) const {
  for (const Marker& marker : markers_) {
    if (marker.box.holds(x, y)) return log_of(intensity_of(reflectance_at(x, y)));
  }
  return skin_level_;
}

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
      if (!follows_) {
        compare(&level, row, x, x + 1, false, cause);
        continue;
      }
      levels_.assign(1, level);
      keeps_.assign(1, kept_at(level));
      follow_row(row, x, x + 1, cause);
    }
  }
}

/// Evaluates every `step`-th row of the image from `first` on, because the light has changed.
void EventCamera::look_at_rows(int first, int step) {
  const std::size_t count = markers_.size();
  std::vector<const Box*> boxes;
  for (std::size_t m = 0; m < count; ++m) {
    const Box& box = trails_[m].active ? trails_[m].area : markers_[m].box;
    if (box.left < box.right) boxes.push_back(&box);
    if (!trails_[m].active) look_at_marker_rows(m, first, step);
  }
  std::sort(boxes.begin(), boxes.end(), [](const Box* a, const Box* b) { return a->left < b->left; });
  for (int row = first; row < options_.size.height; row += step) {
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

void EventCamera::look_at_marker_rows(std::size_t m, int first, int step) {
  const Marker& marker = markers_[m];
  const Box& box = marker.box;
  const bool alone = is_alone(m, box, 0);
  const int above = std::max(0, box.top - first + step - 1) / step;
  for (int row = first + above * step; row < box.bottom; row += step) {
    for (int x = box.left; x < box.right;) {
      const int end = alone ? std::min(box.right, box.left + ((x - box.left) / marker.strip_px + 1) * marker.strip_px) : x + 1;
      if (alone) {
        add_stretch(row, x, end, marker.across.data() + (x - box.left), marker.contrast[marker.place(x, row)]);
      } else {
        const float level = level_at(x, row);
        compare(&level, row, x, end, false, 0);
      }
      x = end;
    }
  }
  compare_stretches(0);
}

/// Whether no other marker is or was there. @param moved  bit i: marker i has moved
bool EventCamera::is_alone(std::size_t m, const Box& area, std::uint32_t moved) const {
  for (std::size_t n = 0; n < markers_.size(); ++n) {
    if (n == m) continue;
    if (markers_[n].box.meets(area) || ((moved >> n & 1U) != 0 && before_[n].box.meets(area))) return false;
  }
  return true;
}

/// Evaluates the pixels of marker `m`, which has moved. @param moved  bit i: marker i has moved
void EventCamera::look_at_moved(std::size_t m, std::uint32_t moved, bool sideways) {
  const Marker &before = before_[m], &now = markers_[m];
  const auto cause = static_cast<std::uint8_t>(m + 1);
  if (!is_alone(m, before.box, moved) || !is_alone(m, now.box, moved)) {
    look_pixel_by_pixel(before.box, cause);
    look_pixel_by_pixel(now.box, cause);
  } else if (before.box.meets(now.box)) {
    look_at_change(before, now, sideways, cause);
  } else {
    look_at_change(before, {}, true, cause);
    look_at_change({}, now, true, cause);
  }
}

}  // namespace tactile::simulation
