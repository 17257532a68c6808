#include "tactile/alignment/event_rate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "alignment/made_run.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"

namespace tactile::alignment {
namespace {

TEST(EventRate, CountsEveryEventExceptThoseOfHotPixels) {
  const test::TemporaryFolder folder;
  test::write_made_events(folder / "events.aedat4", {.bursts = {{1'000'000, 1'200'000}}, .hot_pixels = 7});
  events::RecordingReader recording(folder / "events.aedat4");
  const EventRate rate = event_rate(recording, 0);
  EXPECT_EQ(rate.hot_pixels, 7U);
  ASSERT_EQ(rate.counts.size(), 15'000U);
  const auto sum = [&](std::size_t begin, std::size_t end) {
    return std::accumulate(rate.counts.begin() + static_cast<long>(begin), rate.counts.begin() + static_cast<long>(end), 0.0);
  };
  EXPECT_NEAR(sum(0, 5'000), 15'000, 700);
  EXPECT_NEAR(sum(5'000, 6'000), 43'000, 1'200);
}

TEST(EventRate, LeavesOutMaskedPixels) {
  const test::TemporaryFolder folder;
  test::write_made_events(folder / "events.aedat4", {.bursts = {{1'000'000, 1'200'000}}});
  events::RecordingReader recording(folder / "events.aedat4");
  const auto total = [](const EventRate& rate) { return std::accumulate(rate.counts.begin(), rate.counts.end(), 0U); };
  std::size_t masked_events = 0, counted = 0;
  const events::MaskPixels mask{{5, 20}, {6, 20}, {7, 20}};
  events::for_all_events(recording, 0, [&](std::span<const events::Event> events) {
    for (const events::Event& event : events) masked_events += event.y == 20 && event.x >= 5 && event.x <= 7;
  });
  ASSERT_GT(masked_events, 0U);
  const EventRate all = event_rate(recording, 0), without = event_rate(recording, 0, {.mask = mask});
  EXPECT_EQ(total(all) - total(without), masked_events);
  EXPECT_EQ(without.hot_pixels, all.hot_pixels + 3);
  for_counted_events(recording, 0, without, [&](const events::Event& event, std::size_t) {
    EXPECT_FALSE(event.y == 20 && event.x >= 5 && event.x <= 7);
    ++counted;
  });
  EXPECT_EQ(counted, total(without));
  EXPECT_THROW(event_rate(recording, 0, {.mask = {{64, 5}}}), Error) << "outside the sensor";
}

TEST(EventRate, RefusesARecordingWithoutEvents) {
  const test::TemporaryFolder folder;
  events::RecordingWriter(folder / "empty.aedat4", {events::event_stream_declaration({64, 48}, "DVXplorer_TEST")}).close();
  events::RecordingReader recording(folder / "empty.aedat4");
  EXPECT_THROW(event_rate(recording, 0), Error);
}

TEST(EventRate, RefusesARecordingThatSpansHours) {
  const test::TemporaryFolder folder;
  events::RecordingWriter writer(folder / "long.aedat4", {events::event_stream_declaration({64, 48}, "DVXplorer_TEST")});
  std::vector<events::Event> events(2);
  events[0].t = camera_time(0);
  events[1].t = camera_time(86'400'000'000);
  writer.write_events(0, events);
  writer.close();
  events::RecordingReader recording(folder / "long.aedat4");
  EXPECT_THROW(event_rate(recording, 0), Error);
}

/// Made of what `use(read-out, add)` adds: `add(x, y)` is one event.
template <class Use>
void write_read_outs(const std::filesystem::path& file, std::int64_t begin_us, int read_outs, const Use& use) {
  events::RecordingWriter writer(file, {events::event_stream_declaration({64, 48}, "DVXplorer_TEST")});
  std::vector<events::Event> events;
  for (int read_out = 0; read_out < read_outs; ++read_out) {
    use(read_out, [&](std::uint64_t x, std::uint64_t y) {
      events::Event event;
      event.t = camera_time(begin_us + std::int64_t{200} * read_out);
      event.x = static_cast<std::int16_t>(x);
      event.y = static_cast<std::int16_t>(y);
      events.push_back(event);
    });
  }
  writer.write_events(0, events);
  writer.close();
}

EventRate rate_in(const std::filesystem::path& file, const EventRateOptions& options = {}) {
  events::RecordingReader recording(file);
  return event_rate(recording, 0, options);
}

TEST(EventRate, LeavesOutAPixelThatBecomesHotDuringTheRunAndOneThatHeals) {
  const test::TemporaryFolder folder;
  Random random(1);
  write_read_outs(folder / "events.aedat4", 1'000'000, 20'000, [&](int read_out, const auto& add) {
    for (std::uint64_t n = random.poisson(2.0); n > 0; --n) add(random.below(64), random.below(48));
    if (read_out > 12'000 && random.uniform() < 0.1) add(20, 30);
    if (read_out < 9'000 && random.uniform() < 0.1) add(50, 10);
  });
  const EventRate rate = rate_in(folder / "events.aedat4");
  EXPECT_EQ(rate.hot, (std::vector<std::uint32_t>{10 * 64 + 50, 30 * 64 + 20}));
  EXPECT_EQ(rate.hot_pixels, 2U);
}

TEST(EventRate, KeepsAnEdgeThatTremblesUntilTheEnd) {
  const test::TemporaryFolder folder;
  Random random(2);
  write_read_outs(folder / "events.aedat4", 1'000'000, 20'000, [&](int read_out, const auto& add) {
    for (std::uint64_t n = random.poisson(2.0); n > 0; --n) add(random.below(64), random.below(48));
    if (read_out > 12'000 && random.uniform() < 0.5) add(20 + random.below(16), 30);
  });
  EXPECT_EQ(rate_in(folder / "events.aedat4").hot_pixels, 0U);
}

TEST(EventRate, HasBinsOfWholeReadOuts) {
  const test::TemporaryFolder folder;
  Random random(3);
  write_read_outs(folder / "events.aedat4", 1'000'000, 5'000,
                  [&](int, const auto& add) { add(random.below(64), random.below(48)); });
  EXPECT_EQ(rate_in(folder / "events.aedat4", {.bin = 500us}).bin, 600us);
  EXPECT_EQ(rate_in(folder / "events.aedat4", {.bin = 100us}).bin, 200us);
  EXPECT_EQ(rate_in(folder / "events.aedat4", {.bin = 1'000us}).bin, 1'000us);
}

TEST(EventRate, CountsBinsThatHoldAsManyEventsAsTheHostTakes) {
  const test::TemporaryFolder folder;
  Random random(4);
  const auto burst = [&](std::uint64_t limit) {
    return [&random, limit](int read_out, const auto& add) {
      const std::uint64_t n = random.poisson(read_out > 4'000 && read_out < 6'000 ? 50.0 : 3.0);
      for (std::uint64_t i = 0; i < std::min(n, limit); ++i) add(random.below(64), random.below(48));
    };
  };
  write_read_outs(folder / "cut.aedat4", 1'000'000, 10'000, burst(45));
  write_read_outs(folder / "whole.aedat4", 1'000'000, 10'000, burst(1'000));
  EXPECT_GT(rate_in(folder / "cut.aedat4").saturated_bins, 1'000U);
  EXPECT_EQ(rate_in(folder / "whole.aedat4").saturated_bins, 0U);
}

TEST(EventRate, FindsAFlickerOfTheLightAndNotARingingTouch) {
  const test::TemporaryFolder folder;
  Random random(5);
  const auto swings = [&](double from_s, double to_s) {
    return [&random, from_s, to_s](int read_out, const auto& add) {
      const double t = 200e-6 * read_out;
      const double swing = t >= from_s && t < to_s ? 10.0 * (1.0 + std::sin(2.0 * 3.14159265 * 200.0 * t)) : 0.0;
      for (std::uint64_t n = random.poisson(3.0 + swing); n > 0; --n) add(random.below(64), random.below(48));
    };
  };
  write_read_outs(folder / "lamp.aedat4", 1'000'000, 10'000, swings(0.0, 2.0));
  write_read_outs(folder / "slip.aedat4", 1'000'000, 10'000, swings(0.8, 1.4));
  const EventRate lamp = rate_in(folder / "lamp.aedat4");
  ASSERT_TRUE(lamp.flicker_hz);
  EXPECT_NEAR(*lamp.flicker_hz, 200.0, 4.0);
  EXPECT_FALSE(rate_in(folder / "slip.aedat4").flicker_hz);
}

TEST(EventRate, GivesTheFrequencyOfALampOfWhichEachSwingHasBrighterAndDarkerEvents) {
  // ln I = 0.5 sin(2 pi 100 t): events are brighter in one half of its period, darker in the other, and twice as frequent as it.
  const test::TemporaryFolder folder;
  Random random(7);
  events::RecordingWriter writer(folder / "lamp.aedat4", {events::event_stream_declaration({64, 48}, "DVXplorer_TEST")});
  std::vector<events::Event> events;
  for (std::int64_t t = 0; t < 2'000'000; t += 200) {
    const double change = std::cos(2.0 * 3.14159265 * 100.0 * 1e-6 * static_cast<double>(t));
    for (std::uint64_t n = random.poisson(1.0 + 20.0 * std::abs(change)); n > 0; --n) {
      events::Event event;
      event.t = camera_time(t);
      event.x = static_cast<std::int16_t>(random.below(64));
      event.y = static_cast<std::int16_t>(random.below(48));
      event.on = change > 0 ? 1 : 0;
      events.push_back(event);
    }
  }
  writer.write_events(0, events);
  writer.close();
  const EventRate lamp = rate_in(folder / "lamp.aedat4");
  ASSERT_TRUE(lamp.flicker_hz);
  EXPECT_NEAR(*lamp.flicker_hz, 100.0, 2.0);
}

TEST(EventRate, IsRightAtTheEndsOfTime) {
  const test::TemporaryFolder folder;
  constexpr std::int64_t latest = std::numeric_limits<std::int64_t>::max() - std::int64_t{200} * 999;
  for (const std::int64_t begin : {std::numeric_limits<std::int64_t>::min(), latest}) {
    const std::filesystem::path file = folder / (begin < 0 ? "first.aedat4" : "last.aedat4");
    Random random(6);
    write_read_outs(file, begin, 1'000, [&](int, const auto& add) { add(random.below(64), random.below(48)); });
    const EventRate rate = rate_in(file);
    EXPECT_EQ(us_of(rate.begin), begin);
    ASSERT_EQ(rate.counts.size(), 1'000U);
    EXPECT_EQ(std::accumulate(rate.counts.begin(), rate.counts.end(), 0U), 1'000U);
  }
}

TEST(EventRate, OfOneEventIsOneBin) {
  const test::TemporaryFolder folder;
  write_read_outs(folder / "events.aedat4", 1'000'000, 1, [](int, const auto& add) { add(3, 4); });
  const EventRate rate = rate_in(folder / "events.aedat4");
  EXPECT_EQ(rate.counts, std::vector<std::uint32_t>{1});
  EXPECT_EQ(rate.hot_pixels, 0U);
  EXPECT_EQ(rate.saturated_bins, 0U);
  EXPECT_FALSE(rate.flicker_hz);
}

}  // namespace
}  // namespace tactile::alignment
