// Stamps, background, hot pixels and light of a camera as it was measured.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <vector>

#include "simulation/silent_camera.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/simulation/event_camera.hpp"
#include "tactile/simulation/physics.hpp"

namespace tactile::simulation {
namespace {

/// As fast as the read-out, too.
EventCameraOptions silent() {
  EventCameraOptions options = test::silent_camera();
  options.refractory = 0us;
  return options;
}

struct Stamped {
  std::int64_t us = 0;
  int x = 0, y = 0;
  bool on = false;
  int readout = 0;
};

std::vector<Stamped> film(const EventCameraOptions& o, const CameraPixels& pixels, int readouts, std::uint64_t seed = 1) {
  EventCamera camera(pixels, o, camera_time(0), seed, {});
  std::vector<Stamped> all;
  for (int k = 0; k < readouts; ++k) {
    for (const events::Event& event : camera.read_out({}).events)
      all.push_back({us_of(event.t), event.x, event.y, event.on != 0, k});
  }
  return all;
}

std::vector<Stamped> film(const EventCameraOptions& o, int readouts) { return film(o, draw_camera_pixels(o, 3), readouts); }

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double deviation_of(const std::vector<double>& values) {
  const double mean = mean_of(values);
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / static_cast<double>(values.size()));
}

TEST(ReadoutClock, StampsTheColumnsOneAfterAnotherFromTheHighest) {
  EventCameraOptions o = silent();
  o.stuck_pixels = 20;
  o.readout_us = 195.163;
  o.scan_us_per_column = 0.3;
  const std::vector<Stamped> events = film(o, 1000);
  ASSERT_EQ(events.size(), 20'000U);
  for (const Stamped& event : events)
    EXPECT_EQ(event.us, static_cast<std::int64_t>(195.163 * event.readout + 0.3 * (63 - event.x)));
  EXPECT_TRUE(std::is_sorted(events.begin(), events.end(), [](const Stamped& a, const Stamped& b) { return a.us < b.us; }));
}

TEST(ReadoutClock, ScansRowsAndTheOtherWayRoundToo) {
  EventCameraOptions o = silent();
  o.stuck_pixels = 20;
  o.readout_us = 250.5;
  o.scan_us_per_row = -2;
  for (const Stamped& event : film(o, 100)) EXPECT_EQ(event.us, static_cast<std::int64_t>(250.5 * event.readout + 2.0 * event.y));
  o.scan_us_per_column = 1;
  EXPECT_THROW(film(o, 1), Error);
}

TEST(ReadoutClock, ScansForAReadoutAtMost) {
  EventCameraOptions o = silent();
  o.stuck_pixels = 50;
  o.scan_us_per_column = 1000;
  for (const Stamped& event : film(o, 100)) {
    EXPECT_GE(event.us, 200 * event.readout);
    EXPECT_LT(event.us, 200 * (event.readout + 1));
  }
}

TEST(ReadoutClock, WandersAndJittersAsStated) {
  EventCameraOptions o = silent();
  const auto errors = [&] {
    ReadoutClock clock(o, 5);
    std::vector<double> all;
    for (int k = 0; k < 400'000; ++k) {
      all.push_back(clock.next_us() - k * o.readout_us);
      clock.advance(0);
    }
    return all;
  };
  o.jitter_us = 3;
  const std::vector<double> jitter = errors();
  EXPECT_NEAR(deviation_of(jitter), 3.0, 0.03);
  EXPECT_NEAR(mean_of(jitter), 0.0, 0.03);
  o.jitter_us = 0;
  o.wander_us = 5;
  o.wander_s = 0.02;  // 100 read-outs
  const std::vector<double> wander = errors();
  EXPECT_NEAR(deviation_of(wander), 5.0, 0.3);
  double product = 0, change = 0;
  for (std::size_t k = 100; k < wander.size(); ++k) {
    product += wander[k] * wander[k - 100];
    change += (wander[k] - wander[k - 10]) * (wander[k] - wander[k - 10]);
  }
  EXPECT_NEAR(product / static_cast<double>(wander.size() - 100) / 25.0, std::exp(-1.0), 0.1);
  // It is smooth: after a tenth of the time the correlation is 0.980. It would be 0.905 if it moved at random.
  EXPECT_NEAR(1 - change / static_cast<double>(wander.size() - 100) / 50.0, 0.980, 0.005);
}

TEST(ReadoutClock, TakesLongerForManyEventsAndMovesAllLaterReadouts) {
  EventCameraOptions o = silent();
  o.readout_events_per_s = 1e6;  // 200 events in 200 us
  ReadoutClock clock(o, 1);
  clock.advance(200);
  EXPECT_DOUBLE_EQ(clock.next_us(), 200);
  clock.advance(500);
  EXPECT_DOUBLE_EQ(clock.next_us(), 700);
  clock.advance(0);
  EXPECT_DOUBLE_EQ(clock.next_us(), 900);
}

TEST(BackgroundNoise, HasTheStatedRateSpreadShareAndRegularity) {
  EventCameraOptions o = silent();
  o.background_hz = 20;
  o.background_spread_decades = 0.2;
  o.background_regularity = 4;
  o.background_on_share = 0.6;
  o.background_on_spread = 0.1;
  constexpr int readouts = 50'000;
  const double seconds = readouts * 200e-6;
  std::map<std::pair<int, int>, std::vector<Stamped>> by_pixel;
  for (const Stamped& event : film(o, readouts)) by_pixel[{event.x, event.y}].push_back(event);
  std::vector<double> log_hz, on_shares, variations;
  double sum = 0;
  for (const auto& [place, events] : by_pixel) {
    const auto count = static_cast<double>(events.size());
    sum += count;
    if (events.size() < 50) continue;
    log_hz.push_back(std::log10(count / seconds));
    on_shares.push_back(static_cast<double>(std::count_if(events.begin(), events.end(), [](auto& e) { return e.on; })) / count);
    std::vector<double> intervals;
    for (std::size_t i = 1; i < events.size(); ++i) intervals.push_back(static_cast<double>(events[i].us - events[i - 1].us));
    variations.push_back(deviation_of(intervals) / mean_of(intervals));
  }
  const double pixels = 64 * 48;
  // The pixels' rates differ by exp(s^2) - 1 of their squares, s = 0.2 ln 10.
  const double of_mean = 20 * std::sqrt((std::exp(std::pow(0.2 * std::log(10.0), 2)) - 1) / pixels);
  EXPECT_NEAR(sum / pixels / seconds, 20, 4 * of_mean);
  EXPECT_NEAR(deviation_of(log_hz), 0.2, 0.01);
  EXPECT_NEAR(mean_of(on_shares), 0.6, 0.01);
  // Of n events the share itself spreads by sqrt(0.24 / n).
  EXPECT_NEAR(deviation_of(on_shares), std::sqrt(0.01 + 0.24 / 180), 0.01);
  EXPECT_NEAR(mean_of(variations), 0.5, 0.02) << "1 / sqrt(4)";
}

TEST(BackgroundNoise, IsPoissonWithTheRegularityOfOneAndStationaryFromTheFirstReadoutOn) {
  EventCameraOptions o = silent();
  o.size = {320, 240};
  o.background_hz = 1;
  for (const double regularity : {1.0, 3.0}) {
    o.background_regularity = regularity;
    std::vector<double> counts(10);
    for (const Stamped& event : film(o, 5000)) ++counts[static_cast<std::size_t>(event.us / 100'000)];
    for (const double count : counts) EXPECT_NEAR(count, 7680, 5 * std::sqrt(7680)) << "in each tenth of a second";
  }
  o.background_regularity = 1;
  o.background_hz = 1000;
  o.size = {16, 16};
  std::map<std::pair<int, int>, double> by_pixel;
  for (const Stamped& event : film(o, 5000)) ++by_pixel[{event.x, event.y}];
  std::vector<double> counts;
  for (const auto& [place, count] : by_pixel) counts.push_back(count);
  EXPECT_EQ(counts.size(), 256U);
  // An interval is at least one read-out: the mean one of 5 read-outs hides few.
  EXPECT_NEAR(mean_of(counts), 1000, 30);
  EXPECT_NEAR(deviation_of(counts), std::sqrt(1000), 7);
}

TEST(BackgroundNoise, IsTheSameForTheSameSeedAndGrowsWithTheNoiseFactor) {
  EventCameraOptions o = silent();
  o.background_hz = 20;
  const CameraPixels pixels = draw_camera_pixels(o, 3);
  const auto times = [&](std::uint64_t seed) {
    std::vector<std::int64_t> all;
    for (const Stamped& event : film(o, pixels, 500, seed)) all.push_back(event.us * 10'000 + event.y * 64 + event.x);
    return all;
  };
  EXPECT_EQ(times(1), times(1));
  EXPECT_NE(times(1), times(2));
  const auto once = static_cast<double>(times(1).size());
  o.noise_factor = 2;
  EXPECT_NEAR(static_cast<double>(times(1).size()), 2 * once, 8 * std::sqrt(once));
}

TEST(GammaQuantiles, AreThoseOfTheDistribution) {
  const std::vector<float> exponential = gamma_quantiles(1.0, 1.0, 4096);
  // The mean of the table is exact, so its rare long intervals are a little too short: compare in the middle.
  for (const std::size_t i : {400U, 2000U, 3600U})
    EXPECT_NEAR(exponential[i], -std::log(1 - (static_cast<double>(i) + 0.5) / 4096), 0.002);
  for (const double shape : {0.1, 0.5, 2.4, 100.0}) {
    const std::vector<float> quantiles = gamma_quantiles(shape, 3.0, 4096);
    const std::vector<double> values(quantiles.begin(), quantiles.end());
    EXPECT_NEAR(mean_of(values), 3.0, 1e-4);
    EXPECT_NEAR(deviation_of(values), 3.0 / std::sqrt(shape), 0.02 * 3.0 / std::sqrt(shape)) << shape;
    EXPECT_TRUE(std::is_sorted(values.begin(), values.end()));
  }
}

TEST(HotPixels, HaveTheRatesAndSharesOfTheirQuantiles) {
  EventCameraOptions o;
  o.hot_pixels = 4000;
  o.hot_hz = {1, 10, 1000};
  o.hot_on_shares = {0, 0.5, 0.5, 1};
  std::vector<double> hz, on;
  for (const SimulatedHotPixel& pixel : hot_pixels_of_run(draw_camera_pixels(o, 3), 0)) {
    hz.push_back(pixel.hz);
    on.push_back(pixel.on_share);
  }
  const auto share_below = [](const std::vector<double>& values, double limit) {
    return static_cast<double>(std::count_if(values.begin(), values.end(), [&](double v) { return v < limit; })) / 4000;
  };
  EXPECT_NEAR(share_below(hz, 10), 0.5, 0.03);
  EXPECT_NEAR(share_below(hz, 100), 0.75, 0.03);
  EXPECT_NEAR(share_below(on, 0.5), 1.0 / 3, 0.03);
  EXPECT_NEAR(share_below(on, 0.501), 2.0 / 3, 0.03);
}

TEST(HotPixels, ThatAreStuckFireAtEveryReadoutInEveryRun) {
  EventCameraOptions o = silent();
  o.stuck_pixels = 3;
  o.stuck_on_share = 1;
  const CameraPixels pixels = draw_camera_pixels(o, 3);
  EXPECT_EQ(hot_pixels_of_run(pixels, 0), hot_pixels_of_run(pixels, 50));
  const std::vector<Stamped> events = film(o, pixels, 500);
  EXPECT_EQ(events.size(), 1500U);
  for (const Stamped& event : events) EXPECT_TRUE(event.on);
}

/// A pixel of skin that a black marker covers at once: it sees ln I follow by exp(-2 pi f t), f of the black, and fires whenever
/// it is a threshold below its memory.
TEST(Bandwidth, DelaysTheEventsOfAStepAsALowPassOfFirstOrder) {
  for (const double hz : {100.0, 400.0}) {
    for (const double veil : {0.01, 0.3}) {
      EventCameraOptions o = silent();
      o.px_per_mm = 16;
      o.threshold = 0.1;
      o.threshold_sigma = o.residual = 0;
      o.bandwidth_hz = hz;
      o.veil = veil;
      const CameraPixels pixels = draw_camera_pixels(o, 1);
      const std::vector<MarkerPose> away{{.x = 500, .y = 28}}, here{{.x = 32, .y = 28}};
      EventCamera camera(pixels, o, camera_time(0), 1, away);
      std::vector<int> seen, expected;
      const double black = o.black + veil + o.dark, skin = o.skin + veil + o.dark;
      const double kept = std::exp(-2 * std::numbers::pi * hz * (0.1 + 0.9 * black) * 200e-6);
      double level = std::log(skin), remembered = level;
      for (int k = 0; k < 200; ++k) {
        for (const events::Event& event : camera.read_out(k < 10 ? away : here).events) {
          if (event.x == 32 && event.y == 24) seen.push_back(k);
        }
        if (k < 10) continue;
        level = std::log(black) + kept * (level - std::log(black));
        if (std::abs(level - remembered) <= 0.1) continue;
        remembered = level;
        expected.push_back(k);
      }
      ASSERT_GT(expected.size(), 3U);
      ASSERT_NEAR(static_cast<double>(seen.size()), static_cast<double>(expected.size()), 1) << hz << " Hz, veil " << veil;
      // The delay of a level is known to a 128th of ln I, and the last events come slowly.
      for (std::size_t i = 0; i < std::min(seen.size(), expected.size()); ++i)
        EXPECT_NEAR(seen[i] - 10, expected[i] - 10, 1 + 0.07 * (expected[i] - 10))
            << hz << " Hz, veil " << veil << ", event " << i;
    }
  }
}

TEST(Bandwidth, OfManyKilohertzGivesTheEventsOfNone) {
  EventCameraOptions o = silent();
  o.px_per_mm = 4;
  const CameraPixels pixels = draw_camera_pixels(o, 1);
  const auto events_of = [&](double hz) {
    o.bandwidth_hz = hz;
    const auto pose = [](int k) {
      return std::vector<MarkerPose>{{.x = 20 + 0.06 * k, .y = 20 + 0.04 * k, .scale = 1 + 2e-4 * k}};
    };
    EventCamera camera(pixels, o, camera_time(0), 1, pose(0));
    std::vector<std::int64_t> all;
    for (int k = 0; k < 300; ++k) {
      for (const events::Event& event : camera.read_out(pose(k)).events)
        all.push_back(us_of(event.t) * 10'000 + event.x * 100 + event.y * 2 + event.on);
    }
    return all;
  };
  const std::vector<std::int64_t> free = events_of(0), fast = events_of(1e6);
  ASSERT_GT(free.size(), 1000U);
  EXPECT_EQ(fast, free);
  EXPECT_LT(events_of(50).size(), 0.8 * static_cast<double>(free.size()));
}

/// What a pixel sees of two markers, of which one leaves: brighter or darker.
int polarity_when_gone(bool hiding, double scale_of_lower) {
  EventCameraOptions o = silent();
  o.px_per_mm = 16;
  o.residual = 0;
  o.threshold = 0.05;
  o.threshold_sigma = 0;
  o.hiding = hiding;
  const CameraPixels pixels = draw_camera_pixels(o, 1);
  // The white of the first lies on the black of the second.
  const std::vector<MarkerPose> both{{.x = 32, .y = 20, .scale = 1.02}, {.x = 32, .y = 28, .scale = scale_of_lower}};
  const std::vector<MarkerPose> one{both[0], {.x = 500, .y = 28, .scale = scale_of_lower}};
  EventCamera camera(pixels, o, camera_time(0), 1, both);
  for (const events::Event& event : camera.read_out(one).events) {
    if (event.x == 32 && event.y == 24) return event.on != 0 ? 1 : -1;
  }
  return 0;
}

TEST(Markers, HideFartherOnesOrAddUp) {
  EXPECT_EQ(polarity_when_gone(false, 1.0), 1) << "the black darkened the white";
  EXPECT_EQ(polarity_when_gone(true, 1.0), 0) << "the black was hidden";
  EXPECT_EQ(polarity_when_gone(true, 1.04), 1) << "the black hid the white";
}

TEST(Markers, ShadeTheSkinBelowThemWhenTheyArePushed) {
  EventCameraOptions o = silent();
  o.px_per_mm = 16;
  o.residual = 0;
  o.threshold = 0.08;
  o.threshold_sigma = 0;
  o.shadow = 0.2;
  o.shadow_mm_per_mm = 0.5;
  o.blur_px = 0.5;
  const CameraPixels pixels = draw_camera_pixels(o, 1);
  EventCamera camera(pixels, o, camera_time(0), 1, std::vector<MarkerPose>{{.x = 32, .y = 20}});
  const double scale = 1 + 1.0 / eye_distance_mm;  // 1 mm inward: a shadow of 8 px below y = 20 + 8 scale
  std::vector<int> darker;
  for (const events::Event& event : camera.read_out(std::vector<MarkerPose>{{.x = 32, .y = 20, .scale = scale}}).events) {
    if (event.x == 32 && event.on == 0 && event.y > 28) darker.push_back(event.y);
  }
  EXPECT_EQ(darker, (std::vector<int>{29, 30, 31, 32, 33, 34, 35}));
}

TEST(Markers, AreShearedByTheRotationOfTheCamera) {
  EventCameraOptions o = silent();
  o.px_per_mm = 16;
  o.residual = 0;
  o.threshold_sigma = 0;
  o.rotation_rad = 0.1;
  o.blur_px = 0.5;
  const CameraPixels pixels = draw_camera_pixels(o, 1);
  EventCamera camera(pixels, o, camera_time(0), 1, std::vector<MarkerPose>{{.x = 500, .y = 20}});
  std::map<int, int> top;
  for (const events::Event& event : camera.read_out(std::vector<MarkerPose>{{.x = 32, .y = 24}}).events) {
    if (event.on == 0 && (!top.contains(event.x) || event.y < top[event.x])) top[event.x] = event.y;
  }
  ASSERT_TRUE(top.contains(4) && top.contains(60));
  EXPECT_NEAR(top[60] - top[4], std::tan(0.1) * 56, 1.5) << "clockwise: the right end is lower";
  const SkinView view = view_of(o);
  const MarkerPose left = marker_pose(view, 3, 0, 0, 0), right = marker_pose(view, 5, 0, 0, 0);
  EXPECT_NEAR(std::atan2(right.y - left.y, right.x - left.x), 0.1, 1e-9);
  EXPECT_NEAR(std::hypot(right.y - left.y, right.x - left.x), 16 * 24, 1e-9);
}

TEST(LightDrift, IsSeenByEveryPixelOnceItExceedsTheThreshold) {
  EventCameraOptions o = silent();
  o.residual = 0;
  o.veil = 0;
  o.light_drift = {.amplitude = 0.5, .period_s = 20, .phase_rad = 0};
  for (const double bandwidth : {0.0, 300.0}) {
    o.bandwidth_hz = bandwidth;
    const CameraPixels pixels = draw_camera_pixels(o, 3);
    EventCamera camera(pixels, o, camera_time(0), 1, std::vector<MarkerPose>{{.x = 32, .y = 20}});
    std::vector<int> counts(64 * 48);
    for (int k = 0; k <= 25'000; ++k) {  // up to the brightest
      for (const events::Event& event : camera.read_out(std::vector<MarkerPose>{{.x = 32, .y = 20}}).events) {
        EXPECT_TRUE(event.on);
        ++counts[static_cast<std::size_t>(event.y * 64 + event.x)];
      }
    }
    const double change = std::log(1.5);  // the dark current makes it less in the black
    for (std::size_t i = 0; i < counts.size(); ++i)
      EXPECT_NEAR(counts[i], change / static_cast<double>(pixels.thresholds[i]), 1.1);
  }
}

/// The numbers of docs/simulation.md, which were measured on a recording of a still scene.
TEST(MeasuredCamera, HasTheNoiseThatWasMeasured) {
  const EventCameraOptions o = default_physics().camera;
  ASSERT_EQ(o.preset, "measured");
  const CameraPixels pixels = draw_camera_pixels(o, 7);
  constexpr int readouts = 10'249;  // 2.0 s
  std::vector<int> counts(pixels.thresholds.size());
  double on = 0, all = 0;
  for (const Stamped& event : film(o, pixels, readouts)) {
    ++counts[static_cast<std::size_t>(event.y * 640 + event.x)];
    on += event.on ? 1 : 0;
    ++all;
  }
  const double seconds = readouts * o.readout_us * 1e-6;
  double hot = 0, hot_events = 0;
  for (const int count : counts) {
    if (count <= 100) continue;
    ++hot;
    hot_events += count;
  }
  EXPECT_NEAR(all / seconds, 167.1e3, 8e3);
  EXPECT_NEAR((all - hot_events) / seconds, 136.3e3, 4e3);
  EXPECT_NEAR(hot, 129, 30);
  EXPECT_NEAR(hot_events / all, 0.185, 0.04);
  EXPECT_NEAR(on / all, 0.544, 0.02);
  EXPECT_EQ(*std::max_element(counts.begin(), counts.end()), readouts) << "one pixel is stuck";
}

/// The camera of earlier versions: its events are a reference.
TEST(QuietCamera, GivesTheEventsThatItAlwaysGave) {
  EventCameraOptions o;
  o.size = {64, 48};
  const CameraPixels pixels = draw_camera_pixels(o, 3);
  EventCamera camera(pixels, o, camera_time(0), 1, std::vector<MarkerPose>{{.x = 32, .y = 20}});
  std::string all;
  for (int k = 0; k < 500; ++k) {
    for (const events::Event& event : camera.read_out(std::vector<MarkerPose>{{.x = 32 + 0.01 * k, .y = 20}}).events)
      all += std::to_string(us_of(event.t)) + ' ' + std::to_string(event.x) + ' ' + std::to_string(event.y) + ' ' +
             std::to_string(event.on) + '\n';
  }
  EXPECT_EQ(sha256_of(all).substr(0, 16), "6cc36ecec9a80196");
}

}  // namespace
}  // namespace tactile::simulation
