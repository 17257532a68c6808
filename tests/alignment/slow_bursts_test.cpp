#include "tactile/alignment/slow_bursts.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "support/temporary_folder.hpp"
#include "tactile/core/random.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::alignment {
namespace {

constexpr std::int64_t read_out_us = 200;
constexpr std::int64_t length_us = 5'000'000;

/// Adds the events of a read-out at t [us].
using BurstScene =
    std::function<void(std::int64_t t, Random& random, const std::function<void(std::uint64_t x, std::uint64_t y)>& add)>;

/// 64 x 48 pixels with a noise of 3 events per read-out on average, and what `scene` adds.
std::vector<Burst> slow_bursts_of(const BurstScene& scene, std::uint64_t seed = 1, const std::vector<Burst>& known = {}) {
  const test::TemporaryFolder folder;
  Random random(seed);
  std::vector<events::Event> events;
  for (std::int64_t t = 0; t < length_us; t += read_out_us) {
    const auto add = [&](std::uint64_t x, std::uint64_t y) {
      events::Event event;
      event.t = camera_time(t);
      event.x = static_cast<std::int16_t>(x);
      event.y = static_cast<std::int16_t>(y);
      event.on = static_cast<std::uint8_t>(random.below(2));
      events.push_back(event);
    };
    for (std::uint64_t n = random.poisson(3.0); n > 0; --n) add(random.below(64), random.below(48));
    scene(t, random, add);
  }
  {
    events::RecordingWriter writer(folder / "events.aedat4", {events::event_stream_declaration({64, 48}, "DVXplorer_TEST")});
    writer.write_events(0, events);
    writer.close();
  }
  events::RecordingReader recording(folder / "events.aedat4");
  return slow_bursts(recording, 0, event_rate(recording, 0), known);
}

/// A marker of 10 x 10 pixels with this many events per read-out, from 2 to 3 s.
BurstScene marker_that_moves(double events_per_read_out) {
  return [=](std::int64_t t, Random& random, const auto& add) {
    if (t < 2'000'000 || t >= 3'000'000) return;
    for (std::uint64_t n = random.poisson(events_per_read_out); n > 0; --n) add(20 + random.below(10), 16 + random.below(10));
  };
}

double seconds(std::size_t bins, const EventRate& rate) {
  return 1e-6 * static_cast<double>(bins) * static_cast<double>(rate.bin.count());
}

TEST(SlowBursts, FindAMarkerThatMovesSlowlyForASecond) {
  // 0.5 events more than the image's 3 per read-out do not show in its rate; in the marker's place they are five times its noise.
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const auto bursts = slow_bursts_of(marker_that_moves(0.5), seed);
    ASSERT_EQ(bursts.size(), 1U) << seed;
    EXPECT_TRUE(bursts[0].slow);
    EXPECT_NEAR(seconds(bursts[0].begin, {}), 2.0, 0.1) << seed;
    EXPECT_NEAR(seconds(bursts[0].end, {}), 3.0, 0.15) << seed;
  }
}

TEST(SlowBursts, FindNothingInNoise) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed)
    EXPECT_TRUE(slow_bursts_of([](std::int64_t, Random&, const auto&) {}, seed).empty()) << seed;
}

TEST(SlowBursts, FindNothingUnderALightThatGrowsEverywhere) {
  const auto light = [](std::int64_t t, Random& random, const auto& add) {
    const double more = 6.0 * std::clamp((static_cast<double>(t) - 2e6) / 1e6, 0.0, 1.0);
    for (std::uint64_t n = random.poisson(more); n > 0; --n) add(random.below(64), random.below(48));
  };
  EXPECT_TRUE(slow_bursts_of(light).empty());
}

TEST(SlowBursts, FindNothingInAPixelThatIsStuckForAWhile) {
  const auto stuck = [](std::int64_t t, Random&, const auto& add) {
    if (t >= 2'000'000 && t < 2'500'000) add(30, 20);
  };
  EXPECT_TRUE(slow_bursts_of(stuck).empty());
}

TEST(SlowBursts, LeaveOutWhatTheKnownBurstsExplain) {
  const EventRate rate;
  const auto bin = [&](double s) { return static_cast<std::size_t>(s * 1e6 / static_cast<double>(rate.bin.count())); };
  EXPECT_TRUE(slow_bursts_of(marker_that_moves(5), 1, {{.begin = bin(1.98), .end = bin(3.02)}}).empty());
}

}  // namespace
}  // namespace tactile::alignment
