#include "tactile/simulation/session_camera.hpp"

#include <algorithm>
#include <cmath>

#include "tactile/core/random.hpp"

namespace tactile::simulation {

SessionCamera session_camera(const EventCameraOptions& camera, const SessionPhysics& sessions, std::uint64_t seed,
                             std::string_view session) {
  const std::uint64_t one_sensor = seed_for(seed, {"camera"});
  if (!sessions.vary) return {.options = camera, .pixels_seed = one_sensor};
  Random random(seed_for(seed, {"camera of a session", session}));
  EventCameraOptions o = camera;
  o.readout_us = std::clamp(o.readout_us * drawn(sessions.readout, random), 1.0, 1e6);
  o.threshold *= drawn(sessions.threshold, random);
  o.threshold_sigma *= drawn(sessions.mismatch, random);
  o.bandwidth_hz *= drawn(sessions.bandwidth, random);
  const double background = drawn(sessions.background, random);
  o.background_hz *= background;
  o.leak_hz *= background;
  o.shot_hz *= background;
  o.hot_pixels = static_cast<int>(std::lround(o.hot_pixels * drawn(sessions.hot_pixels, random)));
  // Paper reflects no more than all light.
  const auto reflectance = [&](double typical, const Range& factor) {
    return std::min(typical * drawn(factor, random), std::max(typical, 1.0));
  };
  o.skin = reflectance(o.skin, sessions.skin);
  o.black = reflectance(o.black, sessions.black);
  o.white = reflectance(o.white, sessions.white);
  o.blur_px *= drawn(sessions.blur, random);
  o.shift_x_mm += cut_normal(sessions.shift_mm, random);
  o.shift_y_mm += cut_normal(sessions.shift_mm, random);
  o.rotation_rad += cut_normal(sessions.rotation_rad, random);
  return {.options = o, .pixels_seed = sessions.same_pixels ? one_sensor : seed_for(seed, {"pixels of a session", session})};
}

}  // namespace tactile::simulation
