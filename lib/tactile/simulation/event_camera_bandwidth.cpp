// Pixels that follow their light with a delay, around markers that move or have just moved.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <utility>

#include "tactile/simulation/event_camera.hpp"
#include "tactile/simulation/fast_log.hpp"

namespace tactile::simulation {
namespace {

// ln I of the table of `kept_`.
constexpr float lowest_level = -10.0F, level_step = 1.0F / 64;
constexpr std::size_t level_count = 64 * 14;
constexpr double settled_share = 0.01;  // of a change, when it is over
constexpr double drawn_again_px = 0.004, most_at_once_px = 0.01;
constexpr std::int32_t creeping_readouts = 8;  // from one drawing to the next: so slow that pixels keep up

}  // namespace

/// Prepares the pixels' delay. Flicker is seen as it is: it changes all pixels at once.
void EventCamera::begin_to_follow() {
  const bool delays = options_.bandwidth_hz > 0 && !(options_.flicker_depth > 0);
  follows_ = delays || options_.rotation_rad != 0;
  if (!follows_) return;
  seen_ = remembered_;
  kept_.assign(level_count, 0.0F);
  settle_readouts_ = 0;
  if (!delays) return;
  const auto kept = [&](double intensity) {
    const double floor = options_.bandwidth_floor, hz = options_.bandwidth_hz * (floor + (1.0 - floor) * intensity);
    return std::exp(-2.0 * std::numbers::pi * hz * readout_s_);
  };
  for (std::size_t i = 0; i < level_count; ++i)
    kept_[i] = static_cast<float>(kept(std::exp(static_cast<double>(lowest_level + level_step * static_cast<float>(i)))));
  const double darkest = std::min({options_.black, options_.white, options_.skin}) + options_.veil + options_.dark;
  constexpr double most_readouts = 10'000;
  settle_readouts_ = static_cast<std::int32_t>(
      std::min(most_readouts, std::ceil(std::log(settled_share) / std::log(std::min(0.9999, kept(darkest))))));
}

float EventCamera::kept_at(float level) const {
  const float place = (level - lowest_level) / level_step + 0.5F;
  return kept_[static_cast<std::size_t>(std::clamp(place, 0.0F, static_cast<float>(level_count - 1)))];
}

/// Whether a marker has moved so far that it is drawn again, and how far.
bool EventCamera::moves_visibly(std::size_t m, const MarkerPose& pose) {
  const MarkerPose& drawn = poses_[m];
  const double size_px = marker_width_mm * px_per_mm_;
  trails_[m].moved_px =
      std::max({std::abs(pose.x - drawn.x), std::abs(pose.y - drawn.y), size_px * std::abs(pose.scale - drawn.scale)});
  return trails_[m].moved_px > drawn_again_px;
}

/// Evaluates what marker `m` changes or has changed lately. @param moved  bit i: marker i has moved
void EventCamera::follow(std::size_t m, std::uint32_t moved) {
  Trail& trail = trails_[m];
  const Marker& now = markers_[m];
  bool at_once = false;
  if ((moved >> m & 1U) != 0) {
    Box changed = now.box;
    changed.take_in(before_[m].box);
    if (!trail.active || readout_ - trail.turn > settle_readouts_) {
      trail.area = trail.active ? trail.recent : changed;
      trail.recent = changed;
      trail.turn = readout_;
    }
    at_once = !trail.active && trail.moved_px < most_at_once_px && readout_ - trail.drawn >= creeping_readouts;
    trail.active = true;
    trail.drawn = readout_;
    trail.recent.take_in(changed);
    trail.area.take_in(changed);
  }
  if (!trail.active) return;
  const auto cause = static_cast<std::uint8_t>(m + 1);
  if (is_alone(m, trail.area, moved))
    look_at_area(trail.area, now, at_once, cause);
  else
    look_pixel_by_pixel(trail.area, cause);
  if (at_once || readout_ - trail.drawn > settle_readouts_) trail.active = false;
}

/// ln I of a marker's strips, and of the columns where it fades, row by row.
void EventCamera::find_levels(const Marker& marker, int left_end, int right_end) {
  const auto skin = static_cast<float>(options_.skin);
  strip_levels_.resize(marker.contrast.size());
  for (std::size_t i = 0; i < strip_levels_.size(); ++i)
    strip_levels_[i] = intensity_of(std::max(0.0F, skin + marker.contrast[i]));
  take_logs(strip_levels_.data(), strip_levels_.size());
  end_levels_.clear();
  const Box& box = marker.box;
  const auto rows = static_cast<std::size_t>(marker.rows());
  for (const auto& [from, to] : {std::pair{box.left, left_end}, std::pair{right_end, box.right}}) {
    for (int x = from; x < to; ++x) {
      const float* contrast = marker.contrast.data() + marker.place(x, box.top);
      const float across = marker.across_at(x);
      for (std::size_t row = 0; row < rows; ++row)
        end_levels_.push_back(intensity_of(std::max(0.0F, skin + across * contrast[row])));
    }
  }
  take_logs(end_levels_.data(), end_levels_.size());
}

/// Evaluates an area in which there is one marker. @param at_once  pixels see their light without delay
void EventCamera::look_at_area(const Box& area, const Marker& marker, bool at_once, std::uint8_t cause) {
  constexpr int together = 8;
  const Box& box = marker.box;
  const int left_end = std::min(marker.full_left, box.right), right_end = std::max(left_end, marker.full_right);
  find_levels(marker, left_end, right_end);
  const auto kept = [&](float level) { return at_once ? 0.0F : kept_at(level); };
  const float skin_kept = kept(skin_level_);
  const auto width = static_cast<std::size_t>(area.right - area.left) + together;
  levels_.assign(width, skin_level_);
  keeps_.assign(width, skin_kept);
  const auto lay = [&](int x, float level, float keep) {
    levels_[static_cast<std::size_t>(x - area.left)] = level;
    keeps_[static_cast<std::size_t>(x - area.left)] = keep;
  };
  const int rows = marker.rows(), right_columns = std::max(0, box.right - right_end);
  for (int row = area.top; row < area.bottom; ++row) {
    const int row_of_marker = row - box.top;
    if (row == box.bottom) {
      std::fill(levels_.begin(), levels_.end(), skin_level_);
      std::fill(keeps_.begin(), keeps_.end(), skin_kept);
    }
    if (row_of_marker >= 0 && row_of_marker < rows) {
      const float* end = end_levels_.data() + row_of_marker;
      for (int x = box.left; x < left_end; ++x, end += rows) lay(x, *end, kept(*end));
      // Strips are laid eight columns at a time; what is too much is laid again.
      for (int x = left_end; x < right_end;) {
        const int strip = (x - box.left) / marker.strip_px;
        const int strip_end = std::min<int>(right_end, box.left + (strip + 1) * marker.strip_px);
        const float level = strip_levels_[static_cast<std::size_t>(strip * rows + row_of_marker)], keep = kept(level);
        for (; x < strip_end; x += together) {
          std::fill_n(levels_.data() + (x - area.left), together, level);
          std::fill_n(keeps_.data() + (x - area.left), together, keep);
        }
        x = strip_end;
      }
      for (int x = right_end; x < box.right; ++x, end += rows) lay(x, *end, kept(*end));
      for (int x = box.right; x < std::min(area.right, box.right - right_columns + together); ++x) lay(x, skin_level_, skin_kept);
    }
    follow_row(row, area.left, area.right, cause);
  }
}

/// Moves what the pixels of a row see towards `levels_`, and fires those that differ too much from their memory.
void EventCamera::follow_row(int row, int left, int right, std::uint8_t cause) {
  const std::size_t first = index_of(left, row), count = static_cast<std::size_t>(right - left);
  constexpr std::size_t together = 8;
  exceeds_.resize(count + together);
  const float* const remembered = remembered_.data() + first;
  const float* const thresholds = pixels_.thresholds.data() + first;
  const float *const levels = levels_.data(), *const keeps = keeps_.data();
  float* const seen = seen_.data() + first;
  std::uint8_t* const exceeds = exceeds_.data();
  for (std::size_t i = 0; i < count; ++i) {
    const float now = levels[i] + keeps[i] * (seen[i] - levels[i]);
    seen[i] = now;
    exceeds[i] = static_cast<std::uint8_t>(std::fabs(now - remembered[i]) > thresholds[i]);
  }
  std::fill_n(exceeds + count, together, std::uint8_t{0});
  for (std::size_t i = 0; i < count; i += together) {
    std::uint64_t any = 0;
    std::memcpy(&any, exceeds + i, together);
    if (any == 0) continue;
    for (std::size_t k = i; k < i + together; ++k) {
      if (exceeds[k] != 0) fire(left + static_cast<int>(k), row, seen[k], seen[k] > remembered[k], cause);
    }
  }
}

}  // namespace tactile::simulation
