#include "tactile/simulation/event_camera.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <utility>

#include "tactile/core/error.hpp"

namespace tactile {
namespace {

/// No noise, every pixel alike and just reset.
EventCameraOptions ideal() {
  return {.size = {120, 60}, .threshold = 0.2, .threshold_sigma = 0, .residual = 0, .noise_hz = 0, .hot_pixels = 0};
}

/// The markers' lower edges from the definition, in a few lines of their own: intensity at a height above which it is black, and
/// the crossings of the threshold, one a read-out at most.
double smooth(double d, double blur) {
  const double s = d <= -blur ? 0 : d >= blur ? 1 : (d + blur) / (2 * blur);
  return 3 * s * s - 2 * s * s * s;
}

double log_intensity(const EventCameraOptions& o, double y, double middle) {
  const double black = smooth(y - (middle - 8), o.blur_px) - smooth(y - middle, o.blur_px);
  const double white = smooth(y - middle, o.blur_px) - smooth(y - (middle + 8), o.blur_px);
  return std::log(o.veil + o.skin * (1 - black - white) + o.black * black + o.white * white);
}

TEST(EventCamera, SeesAMovingEdgeAsTheDefinitionSays) {
  const EventCameraOptions options = ideal();
  const CameraPixels pixels = draw_camera_pixels(options, 1);
  const MarkerPose rest{.x = 60, .y = 20.3};
  EventCamera camera(pixels, options, camera_time(1'000'000), 1, std::span(&rest, 1));
  constexpr int readouts = 300;
  const double step_px = 0.06;  // 18 mm/s
  std::map<std::pair<int, int>, std::vector<std::pair<std::int64_t, int>>> seen;
  for (int k = 0; k < readouts; ++k) {
    const MarkerPose pose{.x = 60, .y = 20.3 + step_px * k};
    for (const Event& event : camera.read_out(std::span(&pose, 1)).events) {
      seen[{event.x, event.y}].emplace_back(us_of(event.t), event.on);
    }
  }
  for (int y = 0; y < 60; ++y) {
    std::vector<std::pair<std::int64_t, int>> expected;
    double remembered = log_intensity(options, y + 0.5, 20.3);
    for (int k = 0; k < readouts; ++k) {
      const double now = log_intensity(options, y + 0.5, 20.3 + step_px * k);
      if (std::abs(now - remembered) <= options.threshold) continue;
      expected.emplace_back(1'000'000 + 200 * k, now > remembered);
      remembered = now;
    }
    for (const int x : {35, 60, 85})
      EXPECT_EQ((seen[{x, y}]), expected) << "pixel " << x << ", " << y;  // away from the marker's ends
  }
  // Row 35 turns from skin to white to black: ln(0.94 / 0.64) = 0.38 holds one threshold, ln(0.94 / 0.10) = 2.24 holds 11, of
  // which each event's overshoot takes a part.
  const std::size_t count = seen[{60, 35}].size();
  EXPECT_GE(count, 1U + 6U);
  EXPECT_LE(count, 1U + 11U);
}

TEST(EventCamera, GivesAPixelsFirstEventWhenItsResidualIsUsedUp) {
  EventCameraOptions options = ideal();
  options.residual = 1.0;
  const CameraPixels pixels = draw_camera_pixels(options, 1);
  const MarkerPose rest{.x = 60, .y = 30}, moved{.x = 60, .y = 30.25};
  EventCamera camera(pixels, options, camera_time(0), 7, std::span(&rest, 1));
  EXPECT_TRUE(camera.read_out(std::span(&rest, 1)).events.empty()) << "nothing moved";
  // The row below the black marker's upper edge brightens by less than a threshold; a residual spread evenly over +-threshold
  // makes each pixel fire with the probability change / (2 threshold).
  const double before = log_intensity(options, 22.5, 30), after = log_intensity(options, 22.5, 30.25);
  ASSERT_GT(after - before, 0.1);
  ASSERT_LT(after - before, 2 * options.threshold);
  int fired = 0, pixels_in_row = 0;
  const EventCamera::ReadOut seen = camera.read_out(std::span(&moved, 1));
  for (int x = 31; x < 89; ++x, ++pixels_in_row) {
    for (const Event& event : seen.events) fired += static_cast<int>(event.x == x && event.y == 22 && event.on == 1);
  }
  const double share = (after - before) / (2 * options.threshold);
  EXPECT_NEAR(fired, share * pixels_in_row, 4 * std::sqrt(share * (1 - share) * pixels_in_row));
}

TEST(EventCamera, StampsAReadOutOnceAndOrdersItByX) {
  EventCameraOptions options = ideal();
  options.noise_hz = 50;
  options.hot_pixels = 5;
  const CameraPixels pixels = draw_camera_pixels(options, 3);
  const MarkerPose rest{.x = 60, .y = 25};
  EventCamera camera(pixels, options, camera_time(12'345), 1, std::span(&rest, 1));
  for (int k = 0; k < 100; ++k) {
    const MarkerPose pose{.x = 60 + 0.1 * k, .y = 25 + 0.1 * k};
    const auto seen = camera.read_out(std::span(&pose, 1));
    EXPECT_LE(seen.caused, seen.events.size());
    for (std::size_t i = 0; i < seen.events.size(); ++i) {
      EXPECT_EQ(us_of(seen.events[i].t), 12'345 + 200 * k);
      if (i == 0) continue;
      const Event &a = seen.events[i - 1], &b = seen.events[i];
      EXPECT_TRUE(a.x < b.x || (a.x == b.x && a.y < b.y)) << "one event of a pixel at most";
    }
  }
}

TEST(EventCamera, IsSilentBeforeAStillSkinButForItsNoise) {
  EventCameraOptions options;
  const SkinPose rest = skin_at_rest();
  const CameraPixels pixels = draw_camera_pixels(options, 5);
  EventCamera camera(pixels, options, camera_time(0), 1, rest);
  double hot_hz = 0;
  for (const CameraPixels::HotPixel& hot : pixels.hot) hot_hz += hot.hz;
  std::uint64_t events = 0, caused = 0;
  for (int k = 0; k < 5000; ++k) {
    const auto seen = camera.read_out(rest);
    events += seen.events.size();
    caused += seen.caused;
  }
  EXPECT_EQ(caused, 0U);
  const double shot = 0.05 * 640 * 480;
  // A fifth of the hot pixels is the run's own; at least the camera's are there, and at most five more at the highest rate.
  EXPECT_GT(static_cast<double>(events), 0.95 * (shot + hot_hz));
  EXPECT_LT(static_cast<double>(events), 1.05 * (shot + hot_hz + 5 * options.hot_max_hz));
}

TEST(EventCamera, RefusesWhatItCannotShow) {
  EventCameraOptions options = ideal();
  const CameraPixels pixels = draw_camera_pixels(options, 1);
  const MarkerPose outside{.x = 20, .y = 30}, inside{.x = 60, .y = 30};
  EXPECT_THROW(EventCamera(pixels, options, camera_time(0), 1, std::span(&outside, 1)), Error);
  EventCamera camera(pixels, options, camera_time(0), 1, std::span(&inside, 1));
  EXPECT_THROW(camera.read_out(std::span(&outside, 1)), Error);
  options.threshold = 0;
  EXPECT_THROW(draw_camera_pixels(options, 1), Error);
  EXPECT_THROW(EventCamera(pixels, {}, camera_time(0), 1, {}), Error) << "pixels of another size";
}

TEST(CameraPixels, SpreadAsTheyAreCalled) {
  const EventCameraOptions options;
  const CameraPixels pixels = draw_camera_pixels(options, 2);
  double sum = 0, squares = 0;
  for (const float threshold : pixels.thresholds) {
    sum += threshold;
    squares += threshold * threshold;
    ASSERT_GE(threshold, 0.01F);
  }
  const double count = static_cast<double>(pixels.thresholds.size()), mean = sum / count;
  EXPECT_NEAR(mean, 0.25, 0.001);
  EXPECT_NEAR(std::sqrt(squares / count - mean * mean), 0.03, 0.001);
  EXPECT_NEAR(pixels.noise_hz_up_to.back() / count, 0.05, 0.001);
  EXPECT_EQ(pixels.hot.size(), 19U) << "four fifths of 24";
}

}  // namespace
}  // namespace tactile
