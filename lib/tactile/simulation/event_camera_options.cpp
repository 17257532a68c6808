#include "tactile/simulation/event_camera_options.hpp"

#include <fmt/core.h>

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
  RangeCheck::need("hot_max_hz", o.hot_max_hz, o.hot_min_hz, 1e6);
  RangeCheck::need("dead_pixels", o.dead_pixels, 0, static_cast<double>(pixel_count(o.size) / 2));
  RangeCheck::need("veil", o.veil, 0, 10);
  RangeCheck::need("noise_factor", o.noise_factor, 0, 1000);
}

SkinView view_of(const EventCameraOptions& options) {
  SkinView view = view_of_skin(options.size);
  if (options.px_per_mm > 0) view.px_per_mm = options.px_per_mm;
  return view;
}

}  // namespace tactile::simulation
