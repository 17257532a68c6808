#include "tactile/simulation/event_camera.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <numbers>
#include <thread>
#include <utility>

#include "tactile/core/error.hpp"

namespace tactile::simulation {
namespace {

using Film = std::vector<std::vector<MarkerPose>>;  // of each read-out

/// No noise, every pixel alike and just reset.
EventCameraOptions ideal() {
  EventCameraOptions options;
  options.size = {120, 60};
  options.px_per_mm = 16;
  options.threshold = 0.2;
  options.threshold_sigma = options.residual = 0;
  options.leak_hz = options.shot_hz = 0;
  options.hot_pixels = options.dead_pixels = 0;
  return options;
}

double smooth(double d, double blur) {
  if (d <= -blur) return 0;
  if (d >= blur) return 1;
  const double s = (d + blur) / (2 * blur);
  return 3 * s * s - 2 * s * s * s;
}

/// ln I in the middle of a pixel, from the definition.
double log_intensity(const EventCameraOptions& o, double light, const std::vector<MarkerPose>& markers, double x, double y) {
  double reflectance = o.skin;
  for (const MarkerPose& m : markers) {
    const double half = 2.0 * o.px_per_mm * m.scale, thick = 0.5 * o.px_per_mm * m.scale;
    const double across = smooth(x - m.x + half, o.blur_px) - smooth(x - m.x - half, o.blur_px);
    const double black = smooth(y - m.y + thick, o.blur_px) - smooth(y - m.y, o.blur_px);
    const double white = smooth(y - m.y, o.blur_px) - smooth(y - m.y - thick, o.blur_px);
    reflectance += across * (black * (o.black - o.skin) + white * (o.white - o.skin));
  }
  return std::log(o.dark + light * (o.veil + std::max(0.0, reflectance)));
}

struct Compared {
  std::size_t events = 0;
  std::size_t most_in_readout = 0;
};

/// Films with the camera and, beside it, with the rule in double: at a read-out a pixel whose ln I is off what it remembers by
/// more than its threshold gives one event and remembers ln I; after an event it is held in reset for the refractory time. Where
/// double is within float's rounding of the threshold the camera decides.
Compared compare_with_rule(const EventCameraOptions& o, const Film& film) {
  constexpr double rounding = 2e-5;
  const CameraPixels pixels = draw_camera_pixels(o, 11);
  EventCamera camera(pixels, o, camera_time(500), 1, film.front());
  const auto count = pixels.thresholds.size();
  std::vector<double> remembered(count);
  std::vector<std::int64_t> fired_us(count, -1'000'000'000);
  const auto at = [&](std::size_t i, double light, const std::vector<MarkerPose>& poses) {
    const auto width = static_cast<std::size_t>(o.size.width);
    return log_intensity(o, light, poses, static_cast<double>(i % width) + 0.5, static_cast<double>(i / width) + 0.5);
  };
  for (std::size_t i = 0; i < count; ++i) remembered[i] = at(i, 1, film.front());
  Compared compared;
  int wrong = 0;
  for (std::size_t k = 0; k < film.size(); ++k) {
    const std::int64_t us = static_cast<std::int64_t>(static_cast<double>(k) * o.readout_us);
    const double light = 1 + o.flicker_depth * std::sin(2 * std::numbers::pi * o.flicker_hz * 1e-6 * static_cast<double>(us));
    std::vector<int> seen(count, -1);  // polarity
    const auto readout = camera.read_out(film[k]);
    for (const events::Event& event : readout.events) {
      EXPECT_EQ(us_of(event.t), 500 + us);
      int& polarity = seen[static_cast<std::size_t>(event.y * o.size.width + event.x)];
      EXPECT_EQ(polarity, -1) << "one event of a pixel at most";
      polarity = event.on;
    }
    compared.events += readout.events.size();
    compared.most_in_readout = std::max(compared.most_in_readout, readout.events.size());
    for (std::size_t i = 0; i < count; ++i) {
      const double now = at(i, light, film[k]), change = now - remembered[i];
      const bool blind = us - fired_us[i] < o.refractory.count();
      const double beyond = std::abs(change) - static_cast<double>(pixels.thresholds[i]);
      const bool either = std::abs(beyond) < rounding && change != 0;
      const int expected = blind ? -1 : either ? seen[i] : beyond > 0 ? static_cast<int>(change > 0) : -1;
      if (seen[i] != expected && ++wrong < 5)
        ADD_FAILURE() << "read-out " << k << ", pixel " << i << ": " << seen[i] << " rather than " << expected << ", " << change;
      if (expected >= 0) fired_us[i] = us;
      if (expected >= 0 || blind) remembered[i] = now;
    }
  }
  EXPECT_EQ(wrong, 0);
  return compared;
}

Film film_of(int readouts, const std::function<std::vector<MarkerPose>(double)>& poses_at) {
  Film film;
  for (int k = 0; k < readouts; ++k) film.push_back(poses_at(k));
  return film;
}

/// A pixel in the white marker turns black as the pair moves down by 8 px, or the other way round. The edge's brightness is
/// I(u) = white + (black - white) S(u), S the smoothstep, whose inverse is s = 1/2 - sin(asin(1 - 2 S) / 3).
TEST(EventCamera, GivesTheEventsOfAnEdgeAtTheTimesOfTheClosedForm) {
  const EventCameraOptions o = ideal();
  const CameraPixels pixels = draw_camera_pixels(o, 1);
  const double white = o.white + o.veil + o.dark, black = o.black + o.veil + o.dark;
  for (const double step_px : {0.001, 0.06, 0.31}) {  // 5, 300 and 1550 px/s
    for (const bool down : {true, false}) {
      const double from = down ? white : black, to = down ? black : white, sign = down ? -1 : 1;
      const auto level_at = [&](double edge_px) {  // the edge has come from -4 px
        const double s = std::clamp((edge_px + o.blur_px) / (2 * o.blur_px), 0.0, 1.0);
        return std::log(from + (to - from) * (3 * s * s - 2 * s * s * s));
      };
      const auto edge_at = [&](double level) {
        const double share = (std::exp(level) - from) / (to - from);
        return o.blur_px * (2 * (0.5 - std::sin(std::asin(1 - 2 * share) / 3)) - 1);
      };
      std::vector<std::int64_t> expected;
      double remembered = std::log(from);
      while (std::abs(std::log(to) - remembered) > o.threshold) {
        const double readout = (edge_at(remembered + sign * o.threshold) + 4) / step_px;
        const auto k = static_cast<std::int64_t>(readout) + 1;
        expected.push_back(200 * k);
        remembered = level_at(-4 + step_px * static_cast<double>(k));
      }
      const double y0 = down ? 16.5 : 24.5;  // of the edge; the pixel is at 20.5
      std::vector<MarkerPose> poses{{.x = 60, .y = y0}};
      EventCamera camera(pixels, o, camera_time(0), 1, poses);
      std::vector<std::int64_t> seen;
      for (int k = 0; k <= static_cast<int>(8 / step_px); ++k) {
        poses[0].y = y0 - sign * step_px * k;
        for (const events::Event& event : camera.read_out(poses).events) {
          if (event.x != 60 || event.y != 20) continue;
          seen.push_back(us_of(event.t));
          EXPECT_EQ(event.on, down ? 0 : 1);
        }
      }
      ASSERT_EQ(seen.size(), expected.size()) << step_px << " px a read-out, " << (down ? "down" : "up");
      // Where the slow edge's flank runs out, float's rounding is the change of a read-out.
      const double rounding_us = step_px == 0.001 ? 200 : 0;
      for (std::size_t i = 0; i < seen.size(); ++i)
        EXPECT_NEAR(static_cast<double>(seen[i]), static_cast<double>(expected[i]), rounding_us);
      const auto most = static_cast<std::size_t>(std::log(white / black) / o.threshold);
      if (step_px == 0.001) {
        EXPECT_EQ(seen.size(), most) << "a slow edge loses none: 2.2 / 0.2 = 11";
      }
      if (step_px == 0.31) {
        EXPECT_LT(seen.size(), most) << "a fast one does";
      }
      EXPECT_GE(seen.size(), 4U);
    }
  }
}

/// Each pixel's light only rises or only falls: where it turns back, what the rules remember may lie nearly a threshold apart,
/// and each turn may cost an event.
TEST(EventCamera, AgreesWithEsimOnSlowChanges) {
  EventCameraOptions o = ideal();
  o.threshold = 0.35;
  o.threshold_sigma = 0.01;
  const CameraPixels pixels = draw_camera_pixels(o, 4);
  for (const bool sideways : {false, true}) {
    const Film film = film_of(490, [&](double k) {
      return std::vector{MarkerPose{.x = 55 + (sideways ? 0.01 * k : 0.0), .y = 25 + (sideways ? 0.0 : 0.01 * k)}};
    });
    EventCamera camera(pixels, o, camera_time(0), 1, film.front());
    std::vector<std::vector<std::int64_t>> seen(pixels.thresholds.size());
    for (const auto& poses : film) {
      for (const events::Event& event : camera.read_out(poses).events)
        seen[static_cast<std::size_t>(event.y * 120 + event.x)].push_back(us_of(event.t) / 200);
    }
    std::size_t most = 0, active = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const double c = pixels.thresholds[i], x = static_cast<double>(i % 120) + 0.5, y = static_cast<double>(i / 120) + 0.5;
      // ESIM: L runs straight between two samples; at each whole threshold from the reference there is an event.
      std::vector<double> esim;
      double before = log_intensity(o, 1, film.front(), x, y), reference = before;
      for (std::size_t k = 1; k < film.size(); ++k) {
        const double now = log_intensity(o, 1, film[k], x, y);
        ASSERT_LE(std::abs(now - before), 0.1 * c);
        while (std::abs(now - reference) >= c) {
          reference += now > reference ? c : -c;
          esim.push_back(static_cast<double>(k - 1) + (reference - before) / (now - before));
        }
        before = now;
      }
      ASSERT_LE(esim.size(), 8U);
      most = std::max(most, esim.size());
      active += static_cast<std::size_t>(!esim.empty());
      ASSERT_LE(std::abs(static_cast<int>(esim.size()) - static_cast<int>(seen[i].size())), 1) << "pixel " << i;
      if (esim.empty() || std::abs(esim[0] - std::round(esim[0])) < 1e-3) continue;
      ASSERT_FALSE(seen[i].empty());
      ASSERT_EQ(seen[i][0], static_cast<std::int64_t>(std::ceil(esim[0]))) << "pixel " << i;
    }
    EXPECT_GE(most, 4U);
    EXPECT_GT(active, sideways ? 100U : 500U);
  }
}

TEST(EventCamera, FollowsItsRuleAtAnySpeed) {
  EventCameraOptions o = ideal();
  o.threshold_sigma = 0.03;
  for (const double step : {0.02, 0.4, 3.7}) {
    const Film film = film_of(120, [&](double k) {
      return std::vector{
          MarkerPose{60 + 8 * std::sin(step * k / 8), 30 + 10 * std::sin(step * k / 10), 1 + 0.1 * std::sin(k / 20)}};
    });
    EXPECT_GT(compare_with_rule(o, film).events, 1000U) << step;
  }
}

TEST(EventCamera, FollowsItsRuleWhereMarkersJumpOverlapAndLeave) {
  EventCameraOptions o = ideal();
  const Film far = film_of(30, [](double k) {
    return std::vector{MarkerPose{std::fmod(37 * k, 200) - 40, std::fmod(23 * k, 100) - 20},
                       MarkerPose{70 + 0.3 * k, 30 + 0.2 * k}};
  });
  const Compared compared = compare_with_rule(o, far);
  EXPECT_GT(compared.most_in_readout, 1000U) << "all of a marker at once";
  const Film out = film_of(60, [](double k) { return std::vector{MarkerPose{60 + 3 * k, 30 - k}}; });
  EXPECT_GT(compare_with_rule(o, out).events, 1000U);
  const Film across = film_of(80, [](double k) {
    return std::vector{MarkerPose{60, 10 + 0.5 * k, 1.1}, MarkerPose{60 + 0.1 * k, 30}, MarkerPose{62, 31}};
  });
  EXPECT_GT(compare_with_rule(o, across).events, 1000U);
  for (const double nowhere : {1e300, -1e300}) {
    const Film gone = film_of(3, [&](double k) { return std::vector{MarkerPose{k == 1 ? nowhere : 60, 30}}; });
    EXPECT_GT(compare_with_rule(o, gone).events, 500U);
  }
}

TEST(EventCamera, FollowsItsRuleInImagesOfAnySize) {
  for (const events::SensorSize size :
       {events::SensorSize{1, 1}, events::SensorSize{7, 3}, events::SensorSize{33, 61}, events::SensorSize{321, 241}}) {
    EventCameraOptions o = ideal();
    o.size = size;
    o.px_per_mm = size.width > 100 ? 8 : 1.5;  // the small ones' markers are thinner than the blur
    const Film film = film_of(40, [&](double k) {
      return std::vector{MarkerPose{0.5 * size.width + 0.03 * k, 0.5 * size.height - 2 + 0.1 * k}};
    });
    EXPECT_GT(compare_with_rule(o, film).events, 0U) << size.width;
  }
}

TEST(EventCamera, FollowsItsRuleThroughTheRefractoryTime) {
  EventCameraOptions o = ideal();
  std::size_t before = 1'000'000;
  for (const auto refractory : {0us, 200us, 201us, 1000us, 5000us}) {
    o.refractory = refractory;
    const Film film = film_of(150, [](double k) { return std::vector{MarkerPose{60 + 0.1 * k, 30 + 6 * std::sin(0.08 * k)}}; });
    const std::size_t events = compare_with_rule(o, film).events;
    if (refractory > 0us && refractory <= 200us) {
      EXPECT_EQ(events, before) << "a read-out is as long";
    } else {
      EXPECT_LT(events, before) << "what changes while a pixel is blind is lost";
    }
    before = events;
  }
}

TEST(EventCamera, FollowsItsRuleInFlickeringLight) {
  EventCameraOptions o = ideal();
  o.size = {121, 61};
  o.threshold_sigma = 0.02;
  for (const double depth : {0.05, 0.5, 0.99}) {
    o.flicker_depth = depth;
    const Film film = film_of(100, [](double k) {
      return std::vector{MarkerPose{60 + (k < 50 ? 0.0 : 0.3 * k), 30.2}, MarkerPose{40, 31}};
    });
    const Compared compared = compare_with_rule(o, film);
    if (depth == 0.05) {
      EXPECT_LT(compared.events, 20'000U);
    }
    if (depth == 0.99) {
      EXPECT_GT(compared.most_in_readout, 3000U);
    }
  }
  o.flicker_depth = 0.5;
  o.refractory = 700us;
  const Film still(60, {MarkerPose{60, 30}});
  EXPECT_GT(compare_with_rule(o, still).events, 10'000U);
}

TEST(EventCamera, AcceptsAnyThreshold) {
  const Film film = film_of(40, [](double k) { return std::vector{MarkerPose{60 + 0.2 * k, 30 + 0.1 * k}}; });
  EventCameraOptions o = ideal();
  o.threshold = o.threshold_floor = 1e-6;
  EXPECT_GT(compare_with_rule(o, film).events, 40U * 300U) << "all that changes fires";
  o.threshold = 1e3;
  EXPECT_EQ(compare_with_rule(o, film).events, 0U);
  o.threshold = 1e-6;
  o.threshold_sigma = 1e3;
  EXPECT_LT(compare_with_rule(o, film).events, 40U * 1000U) << "half of the pixels are at the floor, the others blind";
}

TEST(EventCamera, AcceptsAnyLight) {
  const Film film = film_of(40, [](double k) { return std::vector{MarkerPose{60 + 0.2 * k, 30 + 0.1 * k}}; });
  EventCameraOptions o = ideal();
  o.veil = 0;
  o.black = 0;
  EXPECT_GT(compare_with_rule(o, film).events, 1000U) << "ln(0.001) is the least";
  o.white = o.skin = 0;
  EXPECT_EQ(compare_with_rule(o, film).events, 0U) << "no light at all";
  o.flicker_depth = 0.9;
  EXPECT_EQ(compare_with_rule(o, film).events, 0U) << "nor any to flicker";
  o.flicker_depth = 0;
  o.white = o.skin = o.black = 0.5;
  EXPECT_EQ(compare_with_rule(o, film).events, 0U) << "no contrast";
}

TEST(EventCamera, GivesAPixelsFirstEventWhenItsResidualIsUsedUp) {
  EventCameraOptions options = ideal();
  options.residual = 1.0;
  const CameraPixels pixels = draw_camera_pixels(options, 1);
  const std::vector<MarkerPose> rest{{.x = 60, .y = 30}}, moved{{.x = 60, .y = 30.25}};
  EventCamera camera(pixels, options, camera_time(0), 7, rest);
  EXPECT_TRUE(camera.read_out(rest).events.empty()) << "nothing moved";
  // The row below the black marker's upper edge brightens by less than a threshold; a residual spread evenly over +-threshold
  // makes each pixel fire with the probability change / (2 threshold).
  const double before = log_intensity(options, 1, rest, 60, 22.5), after = log_intensity(options, 1, moved, 60, 22.5);
  ASSERT_GT(after - before, 0.1);
  ASSERT_LT(after - before, 2 * options.threshold);
  int fired = 0, pixels_in_row = 0;
  const EventCamera::ReadOut seen = camera.read_out(moved);
  for (int x = 31; x < 89; ++x, ++pixels_in_row) {
    for (const events::Event& event : seen.events) fired += static_cast<int>(event.x == x && event.y == 22 && event.on == 1);
  }
  const double share = (after - before) / (2 * options.threshold);
  EXPECT_NEAR(fired, share * pixels_in_row, 4 * std::sqrt(share * (1 - share) * pixels_in_row));
}

TEST(EventCamera, StampsAReadOutOnceAndOrdersItByX) {
  EventCameraOptions options = ideal();
  options.leak_hz = options.shot_hz = 50;
  options.hot_pixels = 5;
  const CameraPixels pixels = draw_camera_pixels(options, 3);
  const std::vector<MarkerPose> rest{{.x = 60, .y = 25}};
  EventCamera camera(pixels, options, camera_time(12'345), 1, rest);
  std::size_t fewest = 1'000'000, most = 0;
  for (int k = 0; k < 100; ++k) {
    const std::vector<MarkerPose> poses{{.x = 60 + 0.1 * std::max(0, k - 50), .y = 25 + 0.1 * std::max(0, k - 50)}};
    const auto seen = camera.read_out(poses);
    fewest = std::min(fewest, seen.events.size());
    most = std::max(most, seen.events.size());
    EXPECT_LE(seen.caused, seen.events.size());
    for (std::size_t i = 0; i < seen.events.size(); ++i) {
      EXPECT_EQ(us_of(seen.events[i].t), 12'345 + 200 * k);
      if (i == 0) continue;
      const events::Event &a = seen.events[i - 1], &b = seen.events[i];
      EXPECT_TRUE(a.x < b.x || (a.x == b.x && a.y < b.y)) << "one event of a pixel at most";
    }
  }
  EXPECT_GT(most, 100U);
  EXPECT_GE(fewest, 30U);
}

TEST(EventCamera, ReportsWhichMarkersCausedEvents) {
  EventCameraOptions o = ideal();
  o.size = {640, 480};
  const SkinView view = view_of(o);
  o.leak_hz = 10;
  const SkinPose rest = skin_at_rest(view);
  const CameraPixels pixels = draw_camera_pixels(o, 3);
  EventCamera camera(pixels, o, camera_time(0), 1, rest);
  const auto still = camera.read_out(rest);
  EXPECT_GT(still.events.size(), 0U);
  EXPECT_EQ(still.caused, 0U);
  EXPECT_EQ(still.caused_by, 0U);
  SkinPose pose = rest;
  pose[2] = marker_pose(view, 2, 1.0, 0, 0);
  pose[7].x += 2;
  pose[4].x += 1e-4;  // too little for an event
  const auto seen = camera.read_out(pose);
  EXPECT_EQ(seen.caused_by, 1U << 2 | 1U << 7);
  std::size_t near = 0;
  for (const events::Event& event : seen.events) {
    for (const std::size_t m : {2U, 7U})
      near += static_cast<std::size_t>(std::abs(event.x - rest[m].x) < 60 && std::abs(event.y - rest[m].y) < 30);
  }
  EXPECT_GT(seen.caused, 100U);
  EXPECT_LT(seen.caused, seen.events.size()) << "the others are noise";
  EXPECT_NEAR(static_cast<double>(seen.caused), static_cast<double>(near), 40);
}

TEST(EventCamera, GivesTheSameEventsForTheSameSeedOnAnyThread) {
  EventCameraOptions o;
  o.leak_hz = o.shot_hz = 20;
  const CameraPixels pixels = draw_camera_pixels(o, 9);
  const auto run = [&](std::uint64_t seed) {
    EventCamera camera(pixels, o, camera_time(0), seed, skin_at_rest(view_of(o)));
    std::vector<events::Event> events;
    for (int k = 0; k < 100; ++k) {
      SkinPose pose;
      for (std::size_t m = 0; m < marker_count; ++m) pose[m] = marker_pose(view_of(o), m, 0.01 * k, 0.002 * k, 0);
      const auto seen = camera.read_out(pose);
      events.insert(events.end(), seen.events.begin(), seen.events.end());
    }
    return events;
  };
  const std::vector<events::Event> alone = run(5);
  std::vector<std::vector<events::Event>> together(3);
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < together.size(); ++i) threads.emplace_back([&, i] { together[i] = run(5 + i % 2); });
  }
  EXPECT_GT(alone.size(), 1000U);
  EXPECT_TRUE(together[0] == alone);
  EXPECT_FALSE(together[1] == alone) << "another seed";
  EXPECT_TRUE(together[2] == alone);
}

TEST(EventCamera, RefusesPixelsOfAnotherSizeAndTooManyMarkers) {
  const CameraPixels pixels = draw_camera_pixels(ideal(), 1);
  EXPECT_THROW(EventCamera(pixels, {}, camera_time(0), 1, {}), Error);
  const std::vector<MarkerPose> many(EventCamera::max_markers + 1);
  EXPECT_THROW(EventCamera(pixels, ideal(), camera_time(0), 1, many), Error);
}

}  // namespace
}  // namespace tactile::simulation
