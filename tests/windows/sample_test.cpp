#include "tactile/windows/sample.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <set>

#include "tactile/core/error.hpp"
#include "tactile/core/ticks.hpp"
#include "tactile/windows/shortest_run.hpp"

namespace tactile::windows {
namespace {

constexpr std::int64_t earliest = std::numeric_limits<std::int64_t>::min(), latest = std::numeric_limits<std::int64_t>::max();

SampledInterval interval(Touch touch, std::int64_t start_us, std::int64_t end_us, bool used = true) {
  return {{touch, camera_time(start_us), camera_time(end_us)}, used};
}

std::map<Touch, std::set<std::int64_t>> times_of(const std::vector<Sample>& samples) {
  std::map<Touch, std::set<std::int64_t>> times;
  for (const Sample& sample : samples)
    EXPECT_TRUE(times[sample.touch].insert(us_of(sample.t)).second) << "twice at " << us_of(sample.t);
  return times;
}

TEST(BalancedSamples, RefuseMoreTicksThanARunMayHave) {
  constexpr std::int64_t year = 365 * std::int64_t{86'400'000'000};
  EXPECT_THROW(balanced_samples(0, {}, camera_time(0), camera_time(year), 1, {}), Error);
  EXPECT_THROW(ticks_on_offer({}, camera_time(earliest), camera_time(latest), {}), Error);
}

TEST(BalancedSamples, AreAsManyOfEveryClassAsTheScarcestOffers) {
  // Press ticks: 302..320 ms, 10 of them. Slip: 500 ms of 700 at most, 250. None: everything else but 100 ms around.
  const std::vector<SampledInterval> intervals{interval(Touch::press, 300'000, 320'000),
                                               interval(Touch::slip, 1'000'000, 1'700'000)};
  const auto samples = balanced_samples(3, intervals, camera_time(0), camera_time(3'000'000), 1, {});
  const auto times = times_of(samples);
  ASSERT_EQ(samples.size(), 30U);
  std::set<std::int64_t> press;
  for (std::int64_t t = 302'000; t <= 320'000; t += 2'000) press.insert(t);
  EXPECT_EQ(times.at(Touch::press), press);
  EXPECT_EQ(times.at(Touch::slip).size(), 10U);
  for (const std::int64_t t : times.at(Touch::slip)) EXPECT_TRUE(t > 1'000'000 && t <= 1'500'000 && t % 2'000 == 0) << t;
  EXPECT_EQ(times.at(Touch::none).size(), 10U);
  for (const std::int64_t t : times.at(Touch::none)) {
    EXPECT_TRUE(t >= 50'000 && t <= 3'000'000 && t % 2'000 == 0) << t;
    EXPECT_TRUE(t <= 200'000 || (t > 420'000 && t <= 900'000) || t > 1'800'000) << t;
  }
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(samples[i].run_index, 3U);
    if (i > 0) {
      EXPECT_LT(samples[i - 1].t, samples[i].t);
    }
  }
}

TEST(TicksOnOffer, CountTheEdgesByTheDefinition) {
  // start < t <= min(end, start + window): 10'000 is not in, 20'000 is. None: t <= start - guard or t > end + guard.
  const SamplingOptions options{.tick = 2ms, .window = 10ms, .guard = 4ms, .history = 2ms};
  const auto offered = ticks_on_offer(std::vector{interval(Touch::press, 10'000, 30'000), interval(Touch::slip, 40'000, 44'000)},
                                      camera_time(0), camera_time(60'000), options);
  EXPECT_EQ(offered[1], 5U);            // 12, 14, 16, 18, 20 ms
  EXPECT_EQ(offered[2], 2U);            // 42, 44 ms
  EXPECT_EQ(offered[0], 3U + 1U + 6U);  // 2, 4, 6; 36; 50, 52, ..., 60 ms
}

TEST(ShortestRun, HasOneTickOfEachClassAndNoShorterOneHas) {
  const SamplingOptions options;
  const std::vector touches{interval(Touch::press, 150'000, 152'000), interval(Touch::slip, 152'000, 154'000)};
  const CameraTime end = after(camera_time(0), shortest_run(options));
  EXPECT_EQ(end, camera_time(154'000));
  for (const std::uint64_t count : ticks_on_offer(touches, camera_time(0), end, options)) EXPECT_EQ(count, 1U);
  EXPECT_EQ(ticks_on_offer(touches, camera_time(0), before(end, 1us), options)[2], 0U);
}

TEST(TicksOnOffer, AreAtMost250OfAnIntervalByDefault) {
  const auto offered = ticks_on_offer(std::vector{interval(Touch::press, 1'000'000, 9'000'000)}, camera_time(0),
                                      camera_time(10'000'000), SamplingOptions{});
  EXPECT_EQ(offered[1], 250U);
}

TEST(BalancedSamples, KeepNoneAwayFromAReleaseThatMayReachIntoAnInterval) {
  const SamplingOptions options{.guard = 10ms};
  const std::vector<SampledInterval> intervals{interval(Touch::press, 200'000, 300'000), interval(Touch::slip, 800'000, 900'000)};
  const std::vector<TouchInterval> releases{{Touch::none, camera_time(500'000), camera_time(600'000)},
                                            {Touch::none, camera_time(700'000), camera_time(820'000)}};
  const auto offered = ticks_on_offer(intervals, camera_time(0), camera_time(1'200'000), options, releases);
  EXPECT_EQ(offered[1], 50U);
  EXPECT_EQ(offered[2], 50U) << "a release takes nothing from a slip";
  // Of 576 ticks from 50 ms on, 60 lie near the press, 60 near the first release, 110 near the second or the slip.
  EXPECT_EQ(offered[0], 576U - 60U - 60U - 110U);
  for (const Sample& sample : balanced_samples(0, intervals, camera_time(0), camera_time(1'200'000), 1, options, releases))
    EXPECT_FALSE(sample.t > camera_time(490'000) && sample.t <= camera_time(610'000)) << us_of(sample.t);
}

TEST(BalancedSamples, LeaveAFlaggedIntervalOutButStillKeepNoneAwayFromIt) {
  const SamplingOptions options{.guard = 10ms};
  const std::vector<SampledInterval> intervals{interval(Touch::press, 200'000, 300'000),
                                               interval(Touch::press, 500'000, 600'000, false),
                                               interval(Touch::slip, 800'000, 900'000)};
  for (const Sample& sample : balanced_samples(0, intervals, camera_time(0), camera_time(1'200'000), 1, options)) {
    EXPECT_FALSE(sample.t > camera_time(490'000) && sample.t <= camera_time(610'000)) << us_of(sample.t);
  }
  EXPECT_EQ(ticks_on_offer(intervals, camera_time(0), camera_time(1'200'000), options)[1], 50U);
}

TEST(BalancedSamples, AreNoneIfAClassIsMissing) {
  EXPECT_TRUE(
      balanced_samples(0, std::vector{interval(Touch::press, 300'000, 320'000)}, camera_time(0), camera_time(3'000'000), 1, {})
          .empty());
  EXPECT_TRUE(balanced_samples(0, {}, camera_time(0), camera_time(3'000'000), 1, {}).empty());
}

TEST(BalancedSamples, AreTheSameAtBothEndsOfTheClock) {
  const auto drawn = [](std::int64_t begin) {
    const std::vector<SampledInterval> intervals{interval(Touch::press, begin + 300'000, begin + 320'000),
                                                 interval(Touch::slip, begin + 1'000'000, begin + 1'700'000)};
    std::vector<Sample> samples = balanced_samples(0, intervals, camera_time(begin), camera_time(begin + 3'000'000), 1, {});
    for (Sample& sample : samples) sample.t = camera_time(us_of(sample.t) - begin);
    return samples;
  };
  const std::int64_t first_tick = us_of(first_tick_from(camera_time(earliest), 2ms)),
                     last_tick = us_of(last_tick_until(camera_time(latest), 2ms));
  const auto anywhere = drawn(0);
  EXPECT_EQ(anywhere.size(), 30U);
  EXPECT_EQ(drawn(first_tick), anywhere);
  EXPECT_EQ(drawn(last_tick - 3'000'000), anywhere);
}

TEST(BalancedSamples, LieOnlyAtFullTicks) {
  // The press begins with the recording: its first 50 ms have no whole history. The slip continues after the last event.
  const std::vector<SampledInterval> intervals{interval(Touch::press, 0, 100'000), interval(Touch::slip, 1'000'000, 1'200'000)};
  for (const Sample& sample : balanced_samples(0, intervals, camera_time(0), camera_time(1'100'000), 1, {})) {
    EXPECT_GE(sample.t, camera_time(50'000));
    EXPECT_LE(sample.t, camera_time(1'100'000));
  }
}

TEST(BalancedSamples, DependOnlyOnTheSeed) {
  const std::vector<SampledInterval> intervals{interval(Touch::press, 300'000, 320'000),
                                               interval(Touch::slip, 1'000'000, 1'700'000)};
  const auto draw = [&](std::uint64_t seed) {
    return balanced_samples(0, intervals, camera_time(0), camera_time(3'000'000), seed, {});
  };
  EXPECT_EQ(draw(5), draw(5));
  EXPECT_NE(draw(5), draw(6));
}

TEST(BalancedSamples, AreDrawnFromTheWholeOfWhatIsOffered) {
  const std::vector<SampledInterval> intervals{interval(Touch::press, 300'000, 320'000),
                                               interval(Touch::slip, 1'000'000, 1'700'000)};
  std::set<std::int64_t> slips;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const auto times = times_of(balanced_samples(0, intervals, camera_time(0), camera_time(3'000'000), seed, {}));
    slips.insert(times.at(Touch::slip).begin(), times.at(Touch::slip).end());
  }
  EXPECT_EQ(slips.size(), 250U);
}

TEST(BalancedSamples, RefuseWhatIsOutOfRange) {
  const auto draw = [](const SamplingOptions& options) {
    return balanced_samples(0, {}, camera_time(0), camera_time(1'000'000), 1, options);
  };
  EXPECT_THROW(draw({.tick = 0us}), Error);
  EXPECT_THROW(draw({.window = 1ms}), Error);
  EXPECT_THROW(draw({.guard = -1us}), Error);
  EXPECT_THROW(draw({.history = 51ms}), Error);
  EXPECT_THROW(draw({.history = 0ms}), Error);
  const std::vector overlapping{interval(Touch::press, 0, 100), interval(Touch::slip, 99, 200)};
  EXPECT_THROW(balanced_samples(0, overlapping, camera_time(0), camera_time(1'000'000), 1, {}), Error);
}

TEST(SamplingOptions, ComeBackFromJson) {
  const SamplingOptions options{.tick = 1ms, .window = 400ms, .guard = 0ms, .history = 20ms, .seed = 18'446'744'073'709'551'615U};
  SamplingOptions back;
  read_all_fields(nlohmann::json::parse(json_of_fields(options).dump()), back, "sampling");
  EXPECT_EQ(json_of_fields(back), json_of_fields(options));
  EXPECT_EQ(back.seed, options.seed);
}

}  // namespace
}  // namespace tactile::windows
