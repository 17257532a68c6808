#include "tactile/simulation/session_camera.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "tactile/core/fields.hpp"
#include "tactile/simulation/simulated_run.hpp"

namespace tactile::simulation {
namespace {

EventCameraOptions measured() { return with_camera("measured").camera; }

TEST(SessionCamera, DiffersFromSessionToSessionWithinTheStatedRanges) {
  const EventCameraOptions base = measured();
  const SessionPhysics sessions;
  std::set<double> thresholds;
  double shift_squares = 0, turn_squares = 0;
  constexpr int count = 400;
  const auto within = [](double value, double typical, const Range& factor) {
    EXPECT_GE(value, typical * factor.low - 1e-9);
    EXPECT_LE(value, typical * factor.high + 1e-9);
  };
  double least = 10, most = 0;
  for (int i = 0; i < count; ++i) {
    const EventCameraOptions o = session_camera(base, sessions, 1, std::to_string(i)).options;
    within(o.readout_us, base.readout_us, sessions.readout);
    within(o.threshold, base.threshold, sessions.threshold);
    within(o.threshold_sigma, base.threshold_sigma, sessions.mismatch);
    within(o.bandwidth_hz, base.bandwidth_hz, sessions.bandwidth);
    within(o.background_hz, base.background_hz, sessions.background);
    within(o.skin, base.skin, sessions.skin);
    within(o.black, base.black, sessions.black);
    within(o.white, base.white, sessions.white);
    within(o.blur_px, base.blur_px, sessions.blur);
    within(o.hot_pixels, base.hot_pixels, {sessions.hot_pixels.low - 0.002, sessions.hot_pixels.high + 0.002});  // whole pixels
    thresholds.insert(o.threshold);
    least = std::min(least, o.threshold / base.threshold);
    most = std::max(most, o.threshold / base.threshold);
    shift_squares += (o.shift_x_mm * o.shift_x_mm + o.shift_y_mm * o.shift_y_mm) / (2.0 * count);
    turn_squares += o.rotation_rad * o.rotation_rad / count;
    EXPECT_NO_THROW(check(o));
  }
  EXPECT_EQ(thresholds.size(), static_cast<std::size_t>(count));
  EXPECT_LT(least, sessions.threshold.low + 0.002) << "the whole range is used";
  EXPECT_GT(most, sessions.threshold.high - 0.002);
  EXPECT_NEAR(std::sqrt(shift_squares), sessions.shift_mm, 0.1 * sessions.shift_mm);
  EXPECT_NEAR(std::sqrt(turn_squares), sessions.rotation_rad, 0.2 * sessions.rotation_rad);
}

TEST(SessionCamera, IsTheSameForTheSameSessionAndSeed) {
  const EventCameraOptions base = measured();
  const auto json_of_camera = [&](std::uint64_t seed, const std::string& session) {
    SessionCamera camera = session_camera(base, {}, seed, session);
    return std::pair{json_of_fields(camera.options), camera.pixels_seed};
  };
  EXPECT_EQ(json_of_camera(1, "a"), json_of_camera(1, "a"));
  EXPECT_NE(json_of_camera(1, "a"), json_of_camera(1, "b"));
  EXPECT_NE(json_of_camera(1, "a"), json_of_camera(2, "a"));
}

TEST(SessionCamera, IsOneForAllWithoutVariation) {
  const EventCameraOptions base = measured();
  SessionPhysics sessions;
  sessions.vary = false;
  const SessionCamera a = session_camera(base, sessions, 1, "a"), b = session_camera(base, sessions, 1, "b");
  EXPECT_EQ(json_of_fields(a.options), json_of_fields(base));
  EXPECT_EQ(json_of_fields(b.options), json_of_fields(base));
  EXPECT_EQ(a.pixels_seed, b.pixels_seed);
  EXPECT_NE(a.pixels_seed, session_camera(base, sessions, 2, "a").pixels_seed);
}

TEST(SessionCamera, HasTheSamePixelsInAllSessionsIfItIsOneSensor) {
  SessionPhysics sessions;
  const auto seed_in = [&](std::uint64_t seed, const char* session) {
    return session_camera(measured(), sessions, seed, session).pixels_seed;
  };
  sessions.same_pixels = true;
  EXPECT_EQ(seed_in(1, "a"), seed_in(1, "b"));
  EXPECT_NE(seed_in(1, "a"), seed_in(2, "a"));
  sessions.same_pixels = false;
  EXPECT_NE(seed_in(1, "a"), seed_in(1, "b"));
}

TEST(SessionCamera, IsThatOfTheRunsOfOneSessionAndOfNoOther) {
  SimulationPhysics physics = default_physics();
  physics.sessions.same_pixels = false;
  int shared = 0, own = 0;
  for (const ObjectModel& object : physics.objects) {
    const DrawnRun one = draw_run(physics, object.name, "01", "tiny", 5), two = draw_run(physics, object.name, "02", "tiny", 5);
    const bool same_session = one.clocks.session == two.clocks.session;
    EXPECT_EQ(one.pixels_seed == two.pixels_seed, same_session);
    EXPECT_EQ(one.camera.threshold == two.camera.threshold, same_session);
    EXPECT_EQ(one.camera.rotation_rad == two.camera.rotation_rad, same_session);
    ++(same_session ? shared : own);
  }
  EXPECT_GT(shared, 0);
  EXPECT_GT(own, 0);
  SimulationPhysics one_camera = physics;
  one_camera.sessions.vary = false;
  std::set<std::uint64_t> seeds;
  for (const ObjectModel& object : physics.objects) seeds.insert(draw_run(one_camera, object.name, "01", "tiny", 5).pixels_seed);
  EXPECT_EQ(seeds.size(), 1U);
}

TEST(SessionCamera, MovesAndTurnsTheSkinInTheImage) {
  SimulationPhysics physics = with_camera("quiet");
  physics.sessions.vary = false;
  const DrawnRun straight = draw_run(physics, "fan", "01", "tiny", 1);
  physics.camera.shift_x_mm = 1;
  physics.camera.rotation_rad = 0.05;
  const DrawnRun turned = draw_run(physics, "fan", "01", "tiny", 1);
  ASSERT_EQ(straight.motion.poses.size(), turned.motion.poses.size());
  const double c = std::cos(0.05), s = std::sin(0.05);
  for (std::size_t k = 0; k < straight.motion.poses.size(); k += 500) {
    for (std::size_t m = 0; m < marker_count; ++m) {
      const double x = straight.motion.poses[k][m].x - 320, y = straight.motion.poses[k][m].y - 240;
      EXPECT_NEAR(turned.motion.poses[k][m].x, 320 + 16 + c * x - s * y, 1e-9);
      EXPECT_NEAR(turned.motion.poses[k][m].y, 240 + s * x + c * y, 1e-9);
    }
  }
}

}  // namespace
}  // namespace tactile::simulation
