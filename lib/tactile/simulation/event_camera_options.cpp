#include "tactile/simulation/event_camera_options.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <string_view>

#include "tactile/core/error.hpp"

namespace tactile::simulation {
namespace {

/// Throws where a field is out of its range.
struct RangeCheck {
  static void need(std::string_view name, double value, double low, double high) {
    if (!(value >= low && value <= high))
      throw Error(fmt::format("simulated camera: {} is {}; expected {} to {}", name, value, low, high));
  }
  void operator()(std::string_view name, double& value, double low, double high) const { need(name, value, low, high); }
  void operator()(std::string_view name, int& value, double low, double high) const { need(name, value, low, high); }
  void operator()(std::string_view name, const std::vector<double>& values, double low, double high) const {
    need(fmt::format("the number of {}", name), static_cast<double>(values.size()), 1, 1000);
    for (const double value : values) need(name, value, low, high);
  }
  void operator()(std::string_view, bool) const {}
  void operator()(std::string_view, const std::string&) const {}
  void operator()(std::string_view name, microseconds& value, double low, double high) const {
    need(name, static_cast<double>(value.count()), low, high);
  }
  void operator()(std::string_view name, events::SensorSize& size, double low, double high) const {
    need(name, size.width, low, high);
    need(name, size.height, low, high);
  }
};

}  // namespace

void check(const EventCameraOptions& options) {
  EventCameraOptions o = options;
  RangeCheck fields;
  list_fields(fields, o);
  if (!std::is_sorted(o.hot_hz.begin(), o.hot_hz.end()) || !std::is_sorted(o.hot_on_shares.begin(), o.hot_on_shares.end()))
    throw Error("simulated camera: hot_hz or hot_on_shares falls; expected ascending numbers");
  RangeCheck::need("dead_pixels", o.dead_pixels, 0, static_cast<double>(pixel_count(o.size) / 2));
  RangeCheck::need("veil", o.veil, 0, 10);
  RangeCheck::need("noise_factor", o.noise_factor, 0, 1000);
}

SkinView view_of(const EventCameraOptions& options) {
  SkinView view = view_of_skin(options.size);
  if (options.px_per_mm > 0) view.px_per_mm = options.px_per_mm;
  view.centre_x_px += view.px_per_mm * options.shift_x_mm;
  view.centre_y_px += view.px_per_mm * options.shift_y_mm;
  view.rotation_rad = options.rotation_rad;
  return view;
}

}  // namespace tactile::simulation
