#include "tactile/labels/posterior/likely_touches.hpp"

#include <gtest/gtest.h>

#include "tactile/core/duration_units.hpp"

namespace tactile::labels {
namespace {

/// The first state of a happening at a level.
std::uint16_t state_of(const RunStates& states, Happening happening, std::size_t level) {
  for (std::size_t s = 0; s < states.count(); ++s) {
    if (states.happening_of(s) == happening && states.level_of(s, arm_still) == level) return static_cast<std::uint16_t>(s);
  }
  return 0;
}

/// Paths of two seconds with stretches of one happening.
class Paths {
 public:
  explicit Paths(const RunStates& states)
      : states_(states), sample_{.states = &states, .begin = camera_time(0), .bin = 1000us, .bins = 2000, .drawn = {}} {
    sample_.drawn.push_back({.offset_us = 0, .conditions = std::vector<std::uint8_t>(2000, arm_still), .paths = {}});
  }

  Path& add() { return sample_.drawn[0].paths.emplace_back(2000, state_of(states_, Happening::untouched, 0)); }
  void put(Path& path, Happening happening, std::size_t level, std::size_t begin, std::size_t end) const {
    std::fill(path.begin() + static_cast<std::ptrdiff_t>(begin), path.begin() + static_cast<std::ptrdiff_t>(end),
              state_of(states_, happening, level));
  }
  const PathSample& sample() const { return sample_; }

 private:
  const RunStates& states_;
  PathSample sample_;
};

/// Paths that `fill` puts stretches into: it gets all, one of them and its number.
template <class Fill>
std::vector<LikelyTouch> touches_in(std::size_t count, Fill fill) {
  const RunStates states(1000us);
  Paths paths(states);
  for (std::size_t i = 0; i < count; ++i) fill(paths, paths.add(), i);
  return likely_touches(paths.sample());
}

double ms(CameraTime t) { return in_ms(between(camera_time(0), t)); }

TEST(LikelyTouches, HaveTheShareOfThePathsAndTheSpreadOfTheirOnsets) {
  const auto touches = touches_in(100, [](const Paths& paths, Path& path, std::size_t i) {
    if (i < 80) paths.put(path, Happening::press, 6, 500 + i / 4, 700);
  });
  ASSERT_EQ(touches.size(), 1U);
  EXPECT_EQ(touches[0].touch, Touch::press);
  EXPECT_NEAR(touches[0].probability, 0.8, 1e-9);
  EXPECT_NEAR(ms(touches[0].start.at), 510, 2);
  EXPECT_NEAR(in_ms(between(touches[0].start.low, touches[0].start.high)), 19, 3);
  EXPECT_NEAR(ms(touches[0].end.at), 700, 3);
}

TEST(LikelyTouches, AreOneWhereASlipIsSometimesInterrupted) {
  const auto touches = touches_in(100, [](const Paths& paths, Path& path, std::size_t i) {
    paths.put(path, Happening::slip, 5, 400, i < 40 ? 600 : 1400);
    if (i < 40) paths.put(path, Happening::slip, 5, 900, 1400);
  });
  ASSERT_EQ(touches.size(), 1U);
  EXPECT_NEAR(touches[0].probability, 1, 1e-9);
  EXPECT_NEAR(ms(touches[0].start.at), 400, 2);
}

TEST(LikelyTouches, AreTwoWhereMostPathsHaveTwo) {
  const auto touches = touches_in(100, [](const Paths& paths, Path& path, std::size_t) {
    paths.put(path, Happening::slip, 5, 400, 700);
    paths.put(path, Happening::slip, 5, 1200, 1500);
  });
  EXPECT_EQ(touches.size(), 2U);
}

TEST(LikelyTouches, EndAPressWhereItsSpeedIsAHundredthOfItsPeak) {
  const auto touches = touches_in(50, [](const Paths& paths, Path& path, std::size_t) {
    paths.put(path, Happening::press, 6, 400, 600);
    paths.put(path, Happening::press, 2, 600, 900);
  });
  ASSERT_EQ(touches.size(), 1U);
  EXPECT_NEAR(ms(touches[0].end.at), 600, 4);
}

TEST(LikelyTouches, OfOnePathInFiftyAreNone) {
  const RunStates states(1000us);
  Paths paths(states);
  for (std::size_t i = 0; i < 50; ++i) {
    Path& path = paths.add();
    if (i == 7) paths.put(path, Happening::slip, 5, 400, 600);
  }
  EXPECT_TRUE(likely_touches(paths.sample()).empty());
  EXPECT_TRUE(likely_releases(paths.sample()).empty());
}

TEST(LikelyRests, LieBetweenTouchesWithTheShareOfPathsInWhichNothingTouchesTheSkin) {
  const RunStates states(1000us);
  Paths paths(states);
  for (std::size_t i = 0; i < 100; ++i) {
    Path& path = paths.add();
    paths.put(path, Happening::press, 6, 300, 400);
    paths.put(path, Happening::held, 0, 400, i < 30 ? 700 : 1200);  // in 30 paths it is let go
    paths.put(path, Happening::slip, 6, 1200, 1500);
    if (i < 40) paths.put(path, Happening::release, 3, 1700, 1800);  // less likely than not
  }
  const std::vector<LikelyRest> rests = likely_rests(paths.sample());
  ASSERT_EQ(rests.size(), 3U);
  EXPECT_EQ(ms(rests[1].begin), 400);
  EXPECT_EQ(ms(rests[1].end), 1200);
  EXPECT_EQ(ms(rests[1].middle()), 800);
  EXPECT_NEAR(rests[1].let_go, 0.3, 1e-9);
  EXPECT_NEAR(rests[2].let_go, 1, 1e-9);
  EXPECT_TRUE(rests[0].is_first && rests[2].is_last && !rests[1].is_first && !rests[1].is_last);
  EXPECT_EQ(ms(rests[2].end), 2000);
}

TEST(LikelyRests, AreCalmBesideAKnock) {
  const RunStates states(1000us);
  Paths paths(states);
  for (int i = 0; i < 10; ++i) paths.put(paths.add(), Happening::knock, 6, 500, 600);
  const std::vector<LikelyRest> rests = likely_rests(paths.sample());
  ASSERT_EQ(rests.size(), 1U);
  EXPECT_EQ(ms(rests[0].middle()), 1300) << "half-way from the knock to the end";
}

}  // namespace
}  // namespace tactile::labels
