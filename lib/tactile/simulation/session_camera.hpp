#pragma once

#include <cstdint>
#include <string_view>

#include "tactile/simulation/drawn_value.hpp"
#include "tactile/simulation/event_camera_options.hpp"

namespace tactile::simulation {

/// How the cameras of sessions differ. A range is that of a factor on the member of `camera`, drawn evenly.
struct SessionPhysics {
  bool vary = true;         ///< false: one camera for all runs of the data set
  bool same_pixels = true;  ///< all sessions have the same sensor: hot and dead pixels, and which pixels have higher thresholds
  Range readout{0.9985, 1.0115};
  Range threshold{0.95, 1.05};
  Range mismatch{0.9, 1.1};  ///< threshold_sigma
  Range bandwidth{0.9, 1.1};
  Range background{0.95, 1.05};
  Range hot_pixels{0.9, 1.1};
  Range skin{0.95, 1.05};
  Range black{0.9, 1.1};
  Range white{0.98, 1.02};
  Range blur{0.95, 1.1};
  double shift_mm = 0.05;       ///< of the skin in the image: standard deviation in each direction, added
  double rotation_rad = 0.002;  ///< standard deviation, added
};

template <class Fields>
void list_fields(Fields& fields, SessionPhysics& s) {
  fields("vary", s.vary);
  fields("same_pixels", s.same_pixels);
  fields("readout", s.readout, 0.5, 2.0);
  fields("threshold", s.threshold, 0.1, 10.0);
  fields("mismatch", s.mismatch, 0.0, 10.0);
  fields("bandwidth", s.bandwidth, 0.01, 100.0);
  fields("background", s.background, 0.0, 100.0);
  fields("hot_pixels", s.hot_pixels, 0.0, 100.0);
  fields("skin", s.skin, 0.1, 10.0);
  fields("black", s.black, 0.1, 10.0);
  fields("white", s.white, 0.1, 10.0);
  fields("blur", s.blur, 0.1, 10.0);
  fields("shift_mm", s.shift_mm, 0.0, 5.0);
  fields("rotation_rad", s.rotation_rad, 0.0, 0.05);
}

/// A camera as it is in one session.
struct SessionCamera {
  EventCameraOptions options;
  std::uint64_t pixels_seed = 0;  ///< of `draw_camera_pixels`
};

/// The camera of a session. Without variation it is the same for all sessions of the data set with this seed. The factor
/// `background` is also on leak and shot noise.
SessionCamera session_camera(const EventCameraOptions& camera, const SessionPhysics& sessions, std::uint64_t seed,
                             std::string_view session);

}  // namespace tactile::simulation
