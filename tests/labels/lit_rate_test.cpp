#include "tactile/labels/lit_rate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "events/made_recording.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/random.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::labels {
namespace {

/// 64 x 48 pixels of noise; a press lights a square of 16 x 16, its left half brighter, its right half darker; a release takes
/// that back; another touch lights a square elsewhere.
void write_touches(const std::filesystem::path& file) {
  Random random(1);
  events::RecordingWriter writer(file, {events::event_stream_declaration({64, 48}, "DVXplorer_TEST")});
  std::vector<events::Event> events;
  const auto add = [&](std::int64_t t, std::uint64_t x, std::uint64_t y, bool on) {
    events::Event event;
    event.t = camera_time(t);
    event.x = static_cast<std::int16_t>(x);
    event.y = static_cast<std::int16_t>(y);
    event.on = on ? 1 : 0;
    events.push_back(event);
  };
  for (std::int64_t t = 0; t < 3'000'000; t += 200) {
    for (std::uint64_t n = random.poisson(3.0); n > 0; --n) add(t, random.below(64), random.below(48), random.below(2) == 1);
    const auto touch = [&](std::int64_t from, std::uint64_t left, std::uint64_t top, bool undo) {
      if (t < from || t >= from + 200'000) return;
      for (std::uint64_t n = random.poisson(20.0); n > 0; --n) {
        const std::uint64_t x = random.below(16);
        add(t, left + x, top + random.below(16), (x < 8) != undo);
      }
    };
    touch(800'000, 8, 8, false);
    touch(1'500'000, 8, 8, true);
    touch(2'200'000, 40, 24, false);
  }
  writer.write_events(0, events);
  writer.close();
}

TEST(LitRate, KeepsWhatABurstLightsAndATenthOfTheNoise) {
  const test::TemporaryFolder folder;
  write_touches(folder / "events.aedat4");
  events::RecordingReader recording(folder / "events.aedat4");
  const alignment::EventRate rate = alignment::event_rate(recording, 0);
  const auto bursts = alignment::bursts_in(rate, alignment::quiet_rate(rate));
  ASSERT_EQ(bursts.size(), 3U);
  const auto lit = lit_rates(recording, 0, rate, bursts);
  ASSERT_EQ(lit.size(), 3U);
  for (const LitRate& burst : lit) {
    EXPECT_NEAR(burst.lit_share, 256.0 / (64 * 48), 1e-9);
    EXPECT_NEAR(burst.quiet_per_bin, 3.0 * 256.0 / (64 * 48), 0.03);
    EXPECT_EQ(burst.repeats.size(), burst.rate.counts.size());
    const auto first = burst.rate.counts.begin();
    const double touched =
        std::accumulate(first + static_cast<long>(burst.burst_begin), first + static_cast<long>(burst.burst_end), 0.0);
    EXPECT_NEAR(touched, 20'250, 700);
    const double ahead = std::accumulate(first + 200, first + 2'400, 0.0) / 2'200;
    EXPECT_NEAR(ahead, 0.25, 0.06);
    EXPECT_LT(burst.dispersion, 1.7);
    ASSERT_EQ(burst.places.size(), 1U);
    EXPECT_EQ(burst.places[0].counts, burst.rate.counts);
    EXPECT_EQ(burst.places[0].repeats, burst.repeats);
    EXPECT_DOUBLE_EQ(burst.places[0].quiet_per_bin, burst.quiet_per_bin);
  }
  EXPECT_EQ(us_of(lit[0].rate.begin_of(lit[0].burst_begin)), us_of(rate.begin_of(bursts[0].begin)));
  // 3 events of 3072 pixels in each of the 4000 read-outs before it.
  EXPECT_NEAR(lit[0].reset_share, 1.0 - std::exp(-4000 * 3.0 / 3072), 0.01);
}

TEST(LitRate, FindsAReleaseByTheBrightnessThatItReverses) {
  const test::TemporaryFolder folder;
  write_touches(folder / "events.aedat4");
  events::RecordingReader recording(folder / "events.aedat4");
  const alignment::EventRate rate = alignment::event_rate(recording, 0);
  const auto lit = lit_rates(recording, 0, rate, alignment::bursts_in(rate, alignment::quiet_rate(rate)));
  ASSERT_EQ(lit.size(), 3U);
  EXPECT_NEAR(lit[0].undoes, 0.0, 1e-9);
  EXPECT_GT(lit[1].undoes, 0.95);
  EXPECT_LT(lit[2].undoes, 0.5);
}

TEST(LitRate, OfTwoMarkersInOneBurstIsOfTwoPlaces) {
  const test::TemporaryFolder folder;
  write_touches(folder / "events.aedat4");
  events::RecordingReader recording(folder / "events.aedat4");
  const alignment::EventRate rate = alignment::event_rate(recording, 0);
  const auto bursts = alignment::bursts_in(rate, alignment::quiet_rate(rate));
  ASSERT_EQ(bursts.size(), 3U);
  // As one burst, the touches light both squares.
  const std::vector<alignment::Burst> one{{bursts.front().begin, bursts.back().end, 0}};
  const auto lit = lit_rates(recording, 0, rate, one);
  ASSERT_EQ(lit.size(), 1U);
  ASSERT_EQ(lit[0].places.size(), 2U);
  for (std::size_t i = 0; i < lit[0].rate.counts.size(); ++i)
    ASSERT_EQ(lit[0].places[0].counts[i] + lit[0].places[1].counts[i], lit[0].rate.counts[i]);
}

/// A thousand bins of 200 us from time 0 on.
alignment::EventRate rate_of_thousand_bins() {
  alignment::EventRate rate;
  rate.begin = camera_time(0);
  rate.bin = 200us;
  rate.counts.resize(1'000);
  rate.last = rate.begin_of(1'000);
  return rate;
}

TEST(LitRate, CountsTheEventsThatRepeatTheLastOneOfTheirPixel) {
  const test::TemporaryFolder folder;
  std::vector<events::Event> events;
  const auto add = [&](std::int64_t bin, int x, int on) { events.push_back(test::event_at(200 * bin, x, 0, on)); };
  for (const int x : {0, 1, 2, 3}) add(430, x, x < 2 ? 1 : 0);
  add(440, 0, 1);  // repeats
  add(440, 1, 0);  // has the other polarity
  add(450, 1, 1);  // has that of the last but one
  add(630, 2, 0);  // repeats, after exactly 40 ms
  add(631, 3, 0);  // comes later than that
  test::write_plain_recording(folder / "events.aedat4", events, {16, 16});
  const alignment::EventRate rate = rate_of_thousand_bins();
  events::RecordingReader recording(folder / "events.aedat4");
  const auto lit = lit_rates(recording, 0, rate, std::vector<alignment::Burst>{{400, 700, 9}});
  ASSERT_EQ(lit.size(), 1U);
  std::vector<std::uint32_t> repeats(1'000);
  repeats[440] = repeats[630] = 1;
  EXPECT_EQ(lit[0].repeats, repeats);
}

TEST(LitRate, HasTheDispersionOfTheNoiseBeforeItsBurst) {
  const test::TemporaryFolder folder;
  std::vector<events::Event> events;
  const auto add = [&](std::int64_t t_us, std::size_t count) {
    events::Event event;
    event.t = camera_time(t_us);
    event.x = 3;
    event.y = 3;
    event.on = 1;
    events.insert(events.end(), count, event);
  };
  // Events of each 5 ms until 20 ms before the burst: 6 of the 12 steps between them are of 4, the others are of 0.
  const std::vector<std::size_t> noise = {0, 0, 4, 4, 0, 0, 4, 4, 0, 0, 4, 4, 0};
  for (std::size_t i = 0; i < noise.size(); ++i) add(5'000 * static_cast<std::int64_t>(i), noise[i]);
  add(85'000, 100);
  {
    events::RecordingWriter writer(folder / "events.aedat4", {events::event_stream_declaration({16, 16}, "DVXplorer_TEST")});
    writer.write_events(0, events);
    writer.close();
  }
  const alignment::EventRate rate = rate_of_thousand_bins();
  events::RecordingReader recording(folder / "events.aedat4");
  const auto lit = lit_rates(recording, 0, rate, std::vector<alignment::Burst>{{425, 525, 100}});
  ASSERT_EQ(lit.size(), 1U);
  const double variance = 6 * 4.0 * 4.0 / (2 * 12), mean = 24.0 / 13;
  EXPECT_NEAR(lit[0].dispersion, variance / mean, 1e-9);
  ASSERT_EQ(lit[0].places.size(), 1U);
  EXPECT_NEAR(lit[0].places[0].dispersion, variance / mean, 1e-9);
}

TEST(LitRate, OfNoBurstsIsNone) {
  const test::TemporaryFolder folder;
  write_touches(folder / "events.aedat4");
  events::RecordingReader recording(folder / "events.aedat4");
  EXPECT_TRUE(lit_rates(recording, 0, alignment::event_rate(recording, 0), {}).empty());
}

}  // namespace
}  // namespace tactile::labels
