#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>

#include "simulation/silent_camera.hpp"
#include "tactile/core/error.hpp"
#include "tactile/simulation/event_camera.hpp"

namespace tactile::simulation {
namespace {

struct Seen {
  std::vector<std::uint64_t> of_pixel;
  std::uint64_t on = 0, off = 0, caused = 0;
  double seconds = 0;

  double events() const { return static_cast<double>(on + off); }
};

Seen watch(const EventCameraOptions& o, const CameraPixels& pixels, int readouts, std::uint64_t seed = 1) {
  EventCamera camera(pixels, o, camera_time(0), seed, {});
  Seen seen{.of_pixel = std::vector<std::uint64_t>(pixels.thresholds.size()), .seconds = 1e-6 * o.readout_us * readouts};
  for (int k = 0; k < readouts; ++k) {
    const auto readout = camera.read_out({});
    seen.caused += readout.caused;
    for (const events::Event& event : readout.events) {
      ++seen.of_pixel[static_cast<std::size_t>(event.y * o.size.width + event.x)];
      ++(event.on != 0 ? seen.on : seen.off);
    }
  }
  return seen;
}

Seen watch(const EventCameraOptions& o, int readouts) { return watch(o, draw_camera_pixels(o, 3), readouts); }

void expect_near_poisson(double count, double mean) { EXPECT_NEAR(count, mean, 5 * std::sqrt(mean)); }

TEST(EventCameraNoise, IsNothingIfThereIsNone) {
  const Seen seen = watch(test::silent_camera(), 5000);
  EXPECT_EQ(seen.on + seen.off, 0U);
}

TEST(EventCameraNoise, LeaksOnEventsOfADifferentRateInEachPixel) {
  EventCameraOptions o = test::silent_camera();
  o.leak_hz = 4;
  o.leak_spread_decades = 0.3;
  o.noise_factor = 5;  // 20 Hz
  const Seen seen = watch(o, 10'000);
  const double pixels = 64 * 48, mean = 20 * seen.seconds;
  EXPECT_EQ(seen.off, 0U);
  EXPECT_EQ(seen.caused, 0U);
  // Rates are log-normal: their variance is mean^2 (exp(s^2) - 1), to which the counts' own adds the mean.
  const double s = 0.3 * std::numbers::ln10, of_rates = mean * mean * (std::exp(s * s) - 1);
  EXPECT_NEAR(seen.events() / pixels, mean, 5 * std::sqrt(of_rates / pixels));
  double squares = 0;
  for (const std::uint64_t count : seen.of_pixel) squares += std::pow(static_cast<double>(count) - mean, 2);
  EXPECT_NEAR(squares / pixels, of_rates + mean, 0.25 * of_rates);
  o.leak_spread_decades = 0;
  expect_near_poisson(watch(o, 2'000).events(), pixels * 20 * 0.4);
}

TEST(EventCameraNoise, ShootsBothPolaritiesAndLessInBrightLight) {
  EventCameraOptions o = test::silent_camera();
  o.threshold_sigma = 0;
  o.shot_hz = 20;
  o.veil = 0;
  for (const auto& [skin, share] : {std::pair{0.0, 1.0}, std::pair{0.5, 0.625}, std::pair{1.0, 0.25}, std::pair{5.0, 0.25}}) {
    o.skin = skin;
    const Seen seen = watch(o, 5'000);
    const double mean = 64 * 48 * 20 * share * seen.seconds;
    expect_near_poisson(seen.events(), mean);
    expect_near_poisson(static_cast<double>(seen.on), 0.5 * mean);
  }
  o.skin = 0.3;
  o.veil = 0.2;
  expect_near_poisson(watch(o, 5'000).events(), 64 * 48 * 20 * 0.625 * 1.0);  // stray light is light
}

TEST(EventCameraNoise, ShootsMoreAtLowThresholds) {
  EventCameraOptions o = test::silent_camera();
  o.threshold_sigma = 0.08;
  o.threshold_floor = 0.05;
  o.shot_hz = 20;
  o.skin = o.veil = 0;
  const CameraPixels pixels = draw_camera_pixels(o, 3);
  const Seen seen = watch(o, pixels, 10'000);
  for (const auto& [low, high] : {std::pair{0.0, 0.2}, std::pair{0.2, 0.3}, std::pair{0.3, 1.0}}) {
    double expected = 0, count = 0;
    for (std::size_t i = 0; i < pixels.thresholds.size(); ++i) {
      if (pixels.thresholds[i] < low || pixels.thresholds[i] >= high) continue;
      expected += 20 * seen.seconds * 0.25 / pixels.thresholds[i];
      count += static_cast<double>(seen.of_pixel[i]);
    }
    ASSERT_GT(expected, 1000);
    // One event of a pixel in a read-out at most: at 400 Hz, those few with the lowest thresholds lose some.
    EXPECT_NEAR(count, expected, 5 * std::sqrt(expected) + 0.005 * expected);
  }
}

TEST(EventCameraNoise, ReachesTwentyMillionEventsASecond) {
  EventCameraOptions o;
  o.leak_hz = 32;
  o.leak_spread_decades = 0;
  o.shot_hz = 64;
  o.hot_pixels = o.dead_pixels = 0;
  o.threshold_sigma = 0;
  const Seen seen = watch(o, 250);
  const double hz = 307'200 * (32 + 64 * (1 - 0.75 * 0.64));
  EXPECT_GT(hz, 20e6);
  // Two events of a pixel in a read-out are one.
  const double mean = hz / 307'200 * 200e-6;
  EXPECT_NEAR(seen.events(), 250 * 307'200 * (1 - std::exp(-mean)), 5 * std::sqrt(hz * seen.seconds));
  EXPECT_EQ(seen.caused, 0U);
}

TEST(EventCameraNoise, FillsEveryPixelAtMost) {
  EventCameraOptions o = test::silent_camera();
  o.leak_hz = o.shot_hz = 10'000;
  o.noise_factor = 1000;
  o.readout_limit = 100'000;
  const Seen seen = watch(o, 20);
  EXPECT_EQ(seen.on + seen.off, 20U * 64U * 48U);
}

TEST(HotPixels, FireAtTheirRates) {
  EventCameraOptions o = test::silent_camera();
  o.hot_pixels = 20;
  o.hot_on_shares = {0.8};
  for (const auto& [least, most] : {std::pair{100.0, 2500.0}, std::pair{1e5, 1e6}}) {
    o.hot_hz = {least, most};
    const CameraPixels pixels = draw_camera_pixels(o, 3);
    std::map<std::size_t, double> hz;
    for (const SimulatedHotPixel& hot : hot_pixels_of_run(pixels, 0)) {
      EXPECT_GE(hot.hz, least);
      EXPECT_LE(hot.hz, most);
      hz[hot.index] += hot.hz;
    }
    ASSERT_EQ(hz.size(), 20U) << "another seed, if two are one";
    const Seen seen = watch(o, pixels, 20'000);
    for (std::size_t i = 0; i < seen.of_pixel.size(); ++i) {
      const double expected = hz.contains(i) ? std::min(5000.0, hz[i]) * seen.seconds : 0;
      EXPECT_NEAR(static_cast<double>(seen.of_pixel[i]), expected, 0.08 * expected + 1e-9) << "pixel " << i;
    }
    EXPECT_NEAR(static_cast<double>(seen.on) / seen.events(), 0.8, 0.02);
  }
}

TEST(HotPixels, ComeAndGoBetweenRuns) {
  EventCameraOptions o;
  o.hot_pixels = 40;
  const CameraPixels pixels = draw_camera_pixels(o, 3);
  constexpr std::size_t runs = 200;
  std::vector<SimulatedHotPixel> before = hot_pixels_of_run(pixels, 0);
  std::set<std::uint32_t> gone;
  int healed = 0;
  for (std::size_t run = 1; run < runs; ++run) {
    const std::vector<SimulatedHotPixel> now = hot_pixels_of_run(pixels, run);
    ASSERT_EQ(now.size(), 40U);
    for (const SimulatedHotPixel& pixel : before) {
      if (std::find(now.begin(), now.end(), pixel) != now.end()) continue;
      ++healed;
      gone.insert(pixel.index);
    }
    for (const SimulatedHotPixel& pixel : now) EXPECT_FALSE(gone.contains(pixel.index)) << "a span of runs is one";
    before = now;
  }
  const double mean = 0.05 * 40 * (runs - 1);
  EXPECT_NEAR(healed, mean, 4 * std::sqrt(mean * 0.95));
  EXPECT_EQ(hot_pixels_of_run(pixels, runs - 1), before) << "in any order of the runs";
  o.hot_turnover = 0;
  const CameraPixels steady = draw_camera_pixels(o, 3);
  EXPECT_EQ(hot_pixels_of_run(steady, 1000), hot_pixels_of_run(steady, 0));
  EXPECT_NE(hot_pixels_of_run(draw_camera_pixels(o, 4), 0), hot_pixels_of_run(steady, 0));
}

TEST(HotPixels, AreThoseOfTheRun) {
  EventCameraOptions o = test::silent_camera();
  o.hot_pixels = 10;
  o.hot_turnover = 0.5;
  const CameraPixels pixels = draw_camera_pixels(o, 3);
  for (const std::size_t run : {0U, 3U, 4U}) {
    o.run_index = run;
    std::set<std::size_t> expected, fired;
    for (const SimulatedHotPixel& hot : hot_pixels_of_run(pixels, run)) expected.insert(hot.index);
    const Seen seen = watch(o, pixels, 2'000, run);
    for (std::size_t i = 0; i < seen.of_pixel.size(); ++i) {
      if (seen.of_pixel[i] > 0) fired.insert(i);
    }
    EXPECT_EQ(fired, expected) << "run " << run;
  }
}

TEST(DeadPixels, NeverFire) {
  EventCameraOptions o = test::silent_camera();
  o.dead_pixels = 700;
  o.hot_pixels = 200;
  o.hot_hz = {100, 5000};
  o.leak_hz = o.shot_hz = 100;
  o.flicker_depth = 0.9;
  const CameraPixels pixels = draw_camera_pixels(o, 3);
  const Seen seen = watch(o, pixels, 1'000);
  int dead = 0;
  for (std::size_t i = 0; i < seen.of_pixel.size(); ++i) {
    EXPECT_EQ(seen.of_pixel[i] == 0, std::isinf(pixels.thresholds[i])) << "pixel " << i;
    dead += static_cast<int>(seen.of_pixel[i] == 0);
  }
  EXPECT_EQ(dead, 700);
  for (const SimulatedHotPixel& hot : hot_pixels_of_run(pixels, 7)) EXPECT_FALSE(std::isinf(pixels.thresholds[hot.index]));
}

TEST(Refractory, KeepsAPixelsEventsApart) {
  EventCameraOptions o = test::silent_camera();
  o.shot_hz = 2000;
  o.hot_pixels = 5;
  o.hot_hz = {5000};
  const CameraPixels pixels = draw_camera_pixels(o, 3);
  // The first read-out at which the time has passed.
  for (const auto& [refractory, expected] :
       {std::pair{0us, 200us}, std::pair{200us, 200us}, std::pair{500us, 600us}, std::pair{1000us, 1000us}}) {
    o.refractory = refractory;
    EventCamera camera(pixels, o, camera_time(0), 1, {});
    std::map<std::pair<int, int>, CameraTime> last;
    microseconds least{1'000'000};
    for (int k = 0; k < 1000; ++k) {
      for (const events::Event& event : camera.read_out({}).events) {
        const auto [before, is_first] = last.try_emplace({event.x, event.y}, event.t);
        if (!is_first) least = std::min(least, event.t - before->second);
        before->second = event.t;
      }
    }
    EXPECT_EQ(least, expected);
  }
}

/// ln I moves by ln(1 + depth sin) where the dark current is little, for all pixels at once; each has a threshold of its own.
TEST(Flicker, IsSeenByEveryPixelAccordingToTheRule) {
  EventCameraOptions o = test::silent_camera();
  o.size = {13, 7};
  o.flicker_depth = 0.4;
  o.flicker_hz = 120;
  o.residual = 0;
  const CameraPixels pixels = draw_camera_pixels(o, 3);
  EventCamera camera(pixels, o, camera_time(0), 1, {});
  std::vector<double> remembered(pixels.thresholds.size(), std::log(0.001 + 0.64));
  std::size_t events = 0;
  for (int k = 0; k < 500; ++k) {
    const auto seen = camera.read_out({});
    const double now = std::log(0.001 + 0.64 * (1 + 0.4 * std::sin(2 * std::numbers::pi * 120 * 200e-6 * k)));
    std::vector<std::pair<int, int>> expected, fired;  // pixel, polarity
    for (int x = 0; x < 13; ++x) {
      for (int y = 0; y < 7; ++y) {
        const auto i = static_cast<std::size_t>(13 * y + x);
        const double change = now - remembered[i];
        if (std::abs(change) <= pixels.thresholds[i]) continue;
        expected.emplace_back(13 * y + x, change > 0);
        remembered[i] = now;
      }
    }
    for (const events::Event& event : seen.events) fired.emplace_back(13 * event.y + event.x, event.on);
    ASSERT_EQ(fired, expected) << "read-out " << k;
    ASSERT_EQ(seen.caused, 0U);
    events += fired.size();
  }
  EXPECT_GT(events, 13U * 7U * 12U) << "12 periods, each with some of both polarities";
}

TEST(ReadOutLimit, LosesWhatComesLastButResetsItsPixels) {
  EventCameraOptions o = test::silent_camera();
  o.leak_hz = 20;
  o.flicker_depth = 0.5;
  const std::vector<MarkerPose> rest{{.x = 20, .y = 24}};
  o.px_per_mm = 6;
  const CameraPixels pixels = draw_camera_pixels(o, 3);
  EventCamera whole(pixels, o, camera_time(0), 1, rest);
  o.readout_limit = 100;
  EventCamera limited(pixels, o, camera_time(0), 1, rest);
  o.readout_limit = 0;
  EventCamera none(pixels, o, camera_time(0), 1, rest);
  std::size_t cut = 0;
  for (int k = 0; k < 200; ++k) {
    const std::vector<MarkerPose> poses{{.x = 20 + 0.1 * k, .y = 24}};
    const auto all = whole.read_out(poses), some = limited.read_out(poses);
    ASSERT_EQ(some.events.size(), std::min<std::size_t>(100, all.events.size()));
    ASSERT_TRUE(std::equal(some.events.begin(), some.events.end(), all.events.begin()));
    ASSERT_LE(some.caused, all.caused);
    if (all.events.size() > 100) ++cut;
    EXPECT_TRUE(none.read_out(poses).events.empty());
  }
  EXPECT_GT(cut, 20U);
}

TEST(EventCamera, IsSilentBeforeAStillSkinExceptForItsNoise) {
  const EventCameraOptions options;
  const SkinPose rest = skin_at_rest(view_of(options));
  const CameraPixels pixels = draw_camera_pixels(options, 5);
  EventCamera camera(pixels, options, camera_time(0), 1, rest);
  double hot_hz = 0;
  for (const SimulatedHotPixel& hot : hot_pixels_of_run(pixels, 0)) hot_hz += hot.hz;
  double events = 0;
  std::size_t caused = 0;
  for (int k = 0; k < 5000; ++k) {
    const auto seen = camera.read_out(rest);
    events += static_cast<double>(seen.events.size());
    caused += seen.caused;
  }
  EXPECT_EQ(caused, 0U);
  // Most of the image is skin, with little stray light.
  const double noise = 640 * 480 * (options.leak_hz + options.shot_hz * (1 - 0.75 * (options.skin + options.veil)));
  EXPECT_NEAR(events, noise + hot_hz, 0.04 * (noise + hot_hz));
  EXPECT_GT(noise, 0.02 * 640 * 480) << "Hz: what a lit sensor's pixels show at least";
}

TEST(CameraPixels, SpreadAsTheyAreCalled) {
  const EventCameraOptions options;
  const CameraPixels pixels = draw_camera_pixels(options, 2);
  double sum = 0, squares = 0, count = 0;
  for (const float threshold : pixels.thresholds) {
    if (std::isinf(threshold)) continue;
    sum += threshold;
    squares += threshold * threshold;
    ++count;
    ASSERT_GE(threshold, 0.01F);
  }
  const double mean = sum / count;
  EXPECT_EQ(static_cast<int>(count), 640 * 480 - options.dead_pixels);
  EXPECT_NEAR(mean, 0.25, 0.001);
  EXPECT_NEAR(std::sqrt(squares / count - mean * mean), 0.03, 0.001);
  EXPECT_NEAR(pixels.leak.weight_sum() / count, 1, 0.002);
  EXPECT_NEAR(pixels.shot.weight_sum() / count, 1 + std::pow(0.03 / 0.25, 2), 0.003) << "the mean of 1 / threshold";
}

TEST(CameraPixels, DoNotDependOnTheRun) {
  EventCameraOptions options;
  options.size = {40, 30};
  const CameraPixels a = draw_camera_pixels(options, 2);
  options.veil = 0.5;
  options.noise_factor = 3;
  options.run_index = 17;
  const CameraPixels b = draw_camera_pixels(options, 2);
  EXPECT_EQ(a.thresholds, b.thresholds);
  EXPECT_EQ(a.leak.weight_sum(), b.leak.weight_sum());
  EXPECT_EQ(a.shot.weight_sum(), b.shot.weight_sum());
  EXPECT_EQ(hot_pixels_of_run(a, 17), hot_pixels_of_run(b, 17));
  EXPECT_NE(a.thresholds, draw_camera_pixels(options, 3).thresholds);
}

TEST(PixelLottery, DrawsInProportionToTheWeights) {
  const std::vector<double> weights{0, 1, 0.5, 7, 1.5, 0};
  const PixelLottery lottery(weights);
  EXPECT_DOUBLE_EQ(lottery.weight_sum(), 10);
  std::vector<double> drawn(weights.size());
  Random random(1);
  constexpr int draws = 100'000;
  for (int i = 0; i < draws; ++i) ++drawn[lottery.draw(random)];
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double p = weights[i] / 10;
    EXPECT_NEAR(drawn[i], draws * p, 5 * std::sqrt(draws * p * (1 - p))) << i;
  }
  EXPECT_EQ(PixelLottery(std::vector<double>(3)).weight_sum(), 0);
}

TEST(EventCameraOptions, ReportWhatIsOutOfRange) {
  const auto message_of = [](auto change) -> std::string {
    EventCameraOptions options;
    change(options);
    try {
      check(options);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message_of([](auto&) {}), "");
  EXPECT_EQ(message_of([](auto& o) { o.threshold = 0; }), "simulated camera: threshold is 0; expected 1e-06 to 1000");
  EXPECT_EQ(message_of([](auto& o) { o.size.width = 0; }), "simulated camera: size is 0; expected 1 to 4096");
  EXPECT_EQ(message_of([](auto& o) { o.readout_us = 0; }), "simulated camera: readout_us is 0; expected 1 to 1000000");
  EXPECT_EQ(message_of([](auto& o) { o.flicker_depth = 1; }), "simulated camera: flicker_depth is 1; expected 0 to 0.99");
  EXPECT_EQ(message_of([](auto& o) {
              o.hot_hz = {100, 50};
            }),
            "simulated camera: hot_hz or hot_on_shares falls; expected ascending numbers");
  EXPECT_EQ(message_of([](auto& o) { o.veil = -1; }), "simulated camera: veil is -1; expected 0 to 10");
  EXPECT_EQ(message_of([](auto& o) { o.leak_hz = std::nan(""); }), "simulated camera: leak_hz is nan; expected 0 to 10000");
  EXPECT_EQ(message_of([](auto& o) {
              o.size = {3, 3};
              o.dead_pixels = 5;
            }),
            "simulated camera: dead_pixels is 5; expected 0 to 4");
  EventCameraOptions options;
  options.dark = 0;
  EXPECT_THROW(draw_camera_pixels(options, 1), Error);
  const CameraPixels pixels = draw_camera_pixels({}, 1);
  EXPECT_THROW(EventCamera(pixels, options, camera_time(0), 1, {}), Error);
}

TEST(EventCameraOptions, ShowTheSkinInTheMiddleAsLargeAsItFits) {
  EventCameraOptions options;
  EXPECT_EQ(view_of(options).px_per_mm, 16);
  EXPECT_EQ(view_of(options).centre_x_px, 320);
  options.size = {320, 240};
  EXPECT_EQ(view_of(options).px_per_mm, 8);
  options.px_per_mm = 5;
  EXPECT_EQ(view_of(options).px_per_mm, 5);
  EXPECT_EQ(view_of(options).centre_y_px, 120);
}

}  // namespace
}  // namespace tactile::simulation
