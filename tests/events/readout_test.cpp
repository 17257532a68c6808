#include "tactile/events/readout.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "events/aedat4_bytes.hpp"
#include "support/real_recordings.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/events/recording_health.hpp"

namespace tactile::events {
namespace {

using Kind = Readout::Kind;

/// A sensor whose read-outs are known.
struct MadeSensor {
  SensorSize size{64, 48};
  double period_us = 195.163, step_us = -2.9, jitter_us = 0;
  Scan scan = Scan::columns;
  double seconds = 2, events_per_readout = 8;
};

std::vector<Event> events_of(const MadeSensor& sensor, std::uint64_t seed) {
  Random random(seed);
  std::vector<Event> events;
  const auto periods = static_cast<int>(std::ceil((1e6 * sensor.seconds - 1000.3) / sensor.period_us));
  for (int period = 0; period < periods; ++period) {
    const double t = 1000.3 + period * sensor.period_us;
    const std::uint64_t n = random.poisson(sensor.events_per_readout);
    for (std::uint64_t i = 0; i < n; ++i) {
      const auto x = static_cast<int>(random.below(static_cast<std::uint64_t>(sensor.size.width)));
      const auto y = static_cast<int>(random.below(static_cast<std::uint64_t>(sensor.size.height)));
      const double line = sensor.scan == Scan::none ? 0 : sensor.scan == Scan::columns ? x : y;
      const double stamp = t + sensor.step_us * line + sensor.jitter_us * random.normal();
      events.push_back(test::event(std::llround(stamp), x, y, static_cast<int>(random.below(2))));
    }
  }
  std::sort(events.begin(), events.end(), [](const Event& a, const Event& b) { return a.t < b.t; });
  return events;
}

Readout readout_of(const std::vector<Event>& events, SensorSize size, ReadoutMeter::Extent extent = ReadoutMeter::Extent::all) {
  ReadoutMeter meter(size, extent);
  meter.add(events);
  return meter.readout();
}

TEST(Readout, FindsColumnsThatAreStampedOneAfterAnother) {
  const MadeSensor sensor;
  const Readout readout = readout_of(events_of(sensor, 1), sensor.size);
  ASSERT_EQ(readout.kind, Kind::steady);
  EXPECT_EQ(readout.scan, Scan::columns);
  EXPECT_NEAR(readout.period_us.value, 195.163, 1e-4);
  EXPECT_NEAR(readout.step_us.value, -2.9, 1e-3);
  EXPECT_GT(readout.coherence, 0.9999);
  EXPECT_NEAR(readout.precision_us(), 195.163, 1e-3) << "the digits below a period depend only on the column";
  EXPECT_EQ(readout.stamp_step_us, 1);
}

TEST(Readout, FindsRowsThatAreStampedFromTopToBottom) {
  const MadeSensor sensor{.period_us = 1234.5, .step_us = 25.1, .scan = Scan::rows, .seconds = 6};
  const Readout readout = readout_of(events_of(sensor, 2), sensor.size);
  ASSERT_EQ(readout.kind, Kind::steady);
  EXPECT_EQ(readout.scan, Scan::rows);
  EXPECT_NEAR(readout.period_us.value, 1234.5, 2e-3);
  EXPECT_NEAR(readout.step_us.value, 25.1, 5e-3);
}

TEST(Readout, FindsRowsAlsoWhereEveryStampIsAMultipleOfTheStep) {
  const MadeSensor sensor{.period_us = 1600, .step_us = 25, .scan = Scan::rows};
  for (const int first_row : {0, 7}) {
    std::vector<Event> events = events_of(sensor, 10);
    events.insert(events.begin(), test::event(1000 + 25 * first_row, 0, first_row, 1));
    const Readout readout = readout_of(events, sensor.size);
    ASSERT_EQ(readout.kind, Kind::steady);
    EXPECT_EQ(readout.scan, Scan::rows) << "all pixels, read out each 25 us, would have such stamps too, but not by row";
    EXPECT_NEAR(readout.period_us.value, 1600, 1e-3);
    EXPECT_NEAR(readout.step_us.value, 25, 1e-3);
    EXPECT_EQ(readout.stamp_step_us, 25);
  }
}

TEST(Readout, FindsReadoutsWhosePixelsShareAStamp) {
  const MadeSensor sensor{.period_us = 200, .step_us = 0, .scan = Scan::none};
  const Readout readout = readout_of(events_of(sensor, 3), sensor.size);
  ASSERT_EQ(readout.kind, Kind::steady);
  EXPECT_EQ(readout.scan, Scan::none);
  EXPECT_NEAR(readout.period_us.value, 200, 1e-6);
  EXPECT_EQ(readout.jitter_us.value, 0);
  EXPECT_EQ(readout.stamp_step_us, 200);
}

TEST(Readout, HasValuesWithinTheirUncertainty) {
  constexpr int seeds = 60;
  int period = 0, step = 0, jitter = 0;
  std::vector<double> period_errors, step_errors;
  for (int seed = 0; seed < seeds; ++seed) {
    const MadeSensor sensor{.jitter_us = 1.5};
    const Readout readout = readout_of(events_of(sensor, 100 + static_cast<std::uint64_t>(seed)), sensor.size);
    ASSERT_EQ(readout.kind, Kind::steady) << seed;
    const auto errors = [](const Measured& m, double truth) { return (m.value - truth) / m.uncertainty; };
    period_errors.push_back(std::abs(errors(readout.period_us, sensor.period_us)));
    step_errors.push_back(std::abs(errors(readout.step_us, sensor.step_us)));
    period += period_errors.back() < 2;
    step += step_errors.back() < 2;
    jitter += std::abs(errors(readout.jitter_us, sensor.jitter_us)) < 2;
  }
  // Of normal errors 95.4 % are within two standard deviations: fewer than 51 of 60 have a chance below 1 in 1000.
  EXPECT_GE(period, 51);
  EXPECT_GE(step, 51);
  EXPECT_GE(jitter, 51);
  EXPECT_GT(median(period_errors), 0.3) << "the uncertainty is not far too large: the median of |normal| is 0.67";
  EXPECT_GT(median(step_errors), 0.3);
}

TEST(Readout, FollowsReadoutsThroughAnyNumberOfEvents) {
  MadeSensor sensor{.seconds = 20, .events_per_readout = 10};  // a million events, twice as many as are kept
  const std::vector<Event> events = events_of(sensor, 5);
  ASSERT_GT(events.size(), std::size_t{1} << 19);
  const Readout all = readout_of(events, sensor.size),
                beginning = readout_of(events, sensor.size, ReadoutMeter::Extent::beginning);
  EXPECT_EQ(all.events, events.size());
  EXPECT_EQ(beginning.events, std::size_t{1} << 19);
  EXPECT_NEAR(all.period_us.value, sensor.period_us, 4 * all.period_us.uncertainty);
  EXPECT_NEAR(beginning.period_us.value, sensor.period_us, 4 * beginning.period_us.uncertainty);
  EXPECT_LT(all.period_us.uncertainty, beginning.period_us.uncertainty);
}

TEST(Readout, FollowsAClockThatWanders) {
  MadeSensor sensor{.seconds = 8};
  std::vector<Event> events = events_of(sensor, 6);
  for (Event& event : events) {
    const double t = static_cast<double>(us_of(event.t));
    event.t = camera_time(us_of(event.t) + std::llround(40 * std::sin(2 * std::acos(-1.0) * t / 3e6)));
  }
  const Readout readout = readout_of(events, sensor.size);
  ASSERT_EQ(readout.kind, Kind::steady);
  EXPECT_NEAR(readout.period_us.value, sensor.period_us, 3 * readout.period_us.uncertainty);
  EXPECT_NEAR(readout.wander_us.value, 40 / std::sqrt(2.0), 6);
  EXPECT_LT(readout.jitter_us.value, 3);
}

TEST(Readout, HasNoneIfEventsHaveTimesOfTheirOwn) {
  Random random(7);
  std::vector<Event> events;
  double t = 0;
  for (int i = 0; i < 100'000; ++i) {
    t += 9 * random.exponential();
    events.push_back(test::event(std::llround(t), static_cast<int>(random.below(64)), static_cast<int>(random.below(48)), 1));
  }
  const Readout readout = readout_of(events, {64, 48});
  EXPECT_EQ(readout.kind, Kind::none);
  EXPECT_EQ(readout.precision_us(), 1) << "then the stamps' own step counts";
}

TEST(Readout, HasNoneForAHandfulOfEvents) {
  EXPECT_EQ(readout_of({}, {64, 48}).kind, Kind::none);
  EXPECT_EQ(readout_of({test::event(0, 1, 1, 1), test::event(200, 1, 1, 1)}, {64, 48}).kind, Kind::none);
}

TEST(Readout, PassesOverEventsOutsideTheSensor) {
  std::vector<Event> events = events_of({}, 8);
  events.push_back(test::event(us_of(events.back().t), 64, 0, 1));
  events.push_back(test::event(us_of(events.back().t), -1, 0, 1));
  EXPECT_EQ(readout_of(events, {64, 48}).events, events.size() - 2);
}

TEST(Readout, TakesTimesAtTheEndsOfTheClock) {
  std::vector<Event> events = events_of({.seconds = 0.1}, 9);
  events.push_back(test::event(std::numeric_limits<std::int64_t>::max(), 3, 3, 1));
  events.insert(events.begin(), test::event(std::numeric_limits<std::int64_t>::min(), 3, 3, 1));
  EXPECT_EQ(readout_of(events, {64, 48}).events, events.size());
}

/// Real sensors; the values are those of an independent program, which folds the stamps in numpy.
TEST(RealReadout, IsFoundInColumns) {
  struct Known {
    const char* file;
    double period_us, us_per_column;
  };
  for (const Known& known : {Known{"derived/dvxplorer640_libcaer_rollover.aedat4", 195.1632, -0.3000},
                             Known{"aermanager/dvxplorer_class2_data_sample.aedat4", 197.2832, -0.6000},
                             Known{"tonic-sample.aedat4", 197.2833, -0.6000}}) {
    const auto file = test::real_recording(known.file);
    if (file.empty()) GTEST_SKIP() << test::not_tested_without(known.file);
    const RecordingHealth health = examine_recording(file);
    const Readout& readout = health.streams.front().events->readout;
    ASSERT_EQ(readout.kind, Kind::steady) << known.file;
    EXPECT_EQ(readout.scan, Scan::columns) << known.file;
    EXPECT_NEAR(readout.period_us.value, known.period_us, 2e-4) << known.file;
    EXPECT_NEAR(readout.step_us.value, known.us_per_column, 2e-4) << known.file;
  }
}

TEST(RealReadout, IsNotFoundInSensorsWhoseEventsHaveTimesOfTheirOwn) {
  for (const char* name :
       {"faery/davis346.aedat4", "expelliarmus/evt2_sample.raw", "expelliarmus/evt3_sample.raw", "aestream-sample.aedat4"}) {
    const auto file = test::real_recording(name);
    if (file.empty()) GTEST_SKIP() << test::not_tested_without(name);
    const RecordingHealth health = examine_recording(file);
    for (const StreamHealth& stream : health.streams) {
      if (!stream.events) continue;
      EXPECT_EQ(stream.events->readout.kind, Kind::none) << name;
    }
  }
}

}  // namespace
}  // namespace tactile::events
