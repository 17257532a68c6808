#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "tactile/events/event.hpp"

namespace tactile::simulation {

/// The sensor's skin as seen by its camera: nine pairs of markers, a black one above a white one, on white skin.
///
/// A marker is 4.0 mm wide and 0.5 mm thick; the pitch is 12 mm along a strip of 40 mm (Faris et al., arXiv:2403.10120, figure
/// 2). The 40 mm fill the image's width. The distance between the rows is not published: with 9 mm, three rows fit the image's
/// height of 30 mm.
inline constexpr double marker_width_mm = 4.0;
inline constexpr double marker_thickness_mm = 0.5;
inline constexpr double column_pitch_mm = 12.0;
inline constexpr double row_pitch_mm = 9.0;
inline constexpr double view_width_mm = 40.0;
inline constexpr double view_height_mm = 30.0;
inline constexpr double eye_distance_mm = 55.0;  ///< from lens to skin: a tip at depth q appears larger by the factor 1 + q / 55

inline constexpr std::size_t marker_count = 9;  ///< pairs, row by row from the top left

/// The scale and position of the skin in the image.
struct SkinView {
  double px_per_mm = 16;
  double centre_x_px = 320;
  double centre_y_px = 240;
  double rotation_rad = 0;  ///< clockwise in the image, about the centre
};

/// The view with the whole skin in the middle of an image of this size: 640 x 480 has 16 px/mm, 320 x 240 has 8.
constexpr SkinView view_of_skin(events::SensorSize size) {
  return {.px_per_mm = std::min(size.width / view_width_mm, size.height / view_height_mm),
          .centre_x_px = 0.5 * size.width,
          .centre_y_px = 0.5 * size.height,
          .rotation_rad = 0};
}

/// A pair of markers in the image: `x`, `y` is the middle of the edge between black and white.
struct MarkerPose {
  double x = 0;      ///< [px]
  double y = 0;      ///< [px]
  double scale = 1;  ///< of its size at rest

  friend bool operator==(const MarkerPose&, const MarkerPose&) = default;
};

using SkinPose = std::array<MarkerPose, marker_count>;

/// The position of marker `index` from the middle of the skin: x to the right, y down [mm].
constexpr double marker_x_mm(std::size_t index) { return (static_cast<double>(index % 3) - 1.0) * column_pitch_mm; }
constexpr double marker_y_mm(std::size_t index) {
  const std::size_t row = index / 3;
  return (static_cast<double>(row) - 1.0) * row_pitch_mm;
}

/// The pose of a marker whose tip is pushed inward by `inward_mm` and sideways by (`aside_x_mm`, `aside_y_mm`).
inline MarkerPose marker_pose(const SkinView& view, std::size_t index, double inward_mm, double aside_x_mm, double aside_y_mm) {
  const double scale = 1.0 + inward_mm / eye_distance_mm;
  const double x_px = view.px_per_mm * (marker_x_mm(index) * scale + aside_x_mm);
  const double y_px = view.px_per_mm * (marker_y_mm(index) * scale + aside_y_mm);
  if (view.rotation_rad == 0) return {.x = view.centre_x_px + x_px, .y = view.centre_y_px + y_px, .scale = scale};
  const double c = std::cos(view.rotation_rad), s = std::sin(view.rotation_rad);
  return {.x = view.centre_x_px + c * x_px - s * y_px, .y = view.centre_y_px + s * x_px + c * y_px, .scale = scale};
}

inline SkinPose skin_at_rest(const SkinView& view) {
  SkinPose pose;
  for (std::size_t i = 0; i < marker_count; ++i) pose[i] = marker_pose(view, i, 0, 0, 0);
  return pose;
}

}  // namespace tactile::simulation
