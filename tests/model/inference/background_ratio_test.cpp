#include "tactile/model/inference/background_ratio.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/temporary_folder.hpp"
#include "tactile/core/infinite.hpp"
#include "tactile/core/random.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::model {
namespace {

using namespace std::chrono_literals;

constexpr events::SensorSize sensor{160, 160};  // four cells
constexpr std::int64_t step = BackgroundRatio::step_us, second = 1'000'000;
constexpr microseconds history = 40ms;

/// What happens in a cell from `from` to `to` [µs]: so many events per step on average.
struct Rate {
  std::int64_t from, to;
  std::size_t cell;
  double events;
};

/// 2 events per step and cell on average up to `end`, and more where `rates` add some.
std::vector<events::Event> stream(std::int64_t end, const std::vector<Rate>& rates = {}, double quiet = 2) {
  Random random(7);
  std::vector<events::Event> events;
  for (std::int64_t t = 0; t < end; t += step) {
    const auto first = static_cast<std::ptrdiff_t>(events.size());
    for (std::size_t cell = 0; cell < 4; ++cell) {
      double mean = quiet;
      for (const Rate& rate : rates) mean += rate.cell == cell && rate.from <= t && t < rate.to ? rate.events : 0;
      for (std::uint64_t i = random.poisson(mean); i > 0; --i) {
        events.push_back({camera_time(t + static_cast<std::int64_t>(random.below(step))),
                          static_cast<std::int16_t>(80 * (cell % 2) + random.below(80)),
                          static_cast<std::int16_t>(80 * (cell / 2) + random.below(80)), 1});
      }
    }
    std::sort(events.begin() + first, events.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
  }
  return events;
}

/// The values at k * tick, each from the events before it.
std::vector<double> values(const std::vector<events::Event>& events, std::int64_t end, std::int64_t tick = step,
                           const events::MaskPixels& mask = {}) {
  BackgroundRatio ratio(sensor, history, mask);
  std::vector<double> values;
  auto next = events.begin();
  for (std::int64_t t = tick; t <= end; t += tick) {
    const auto last = std::find_if(next, events.end(), [&](const events::Event& event) { return event.t >= camera_time(t); });
    ratio.add({next, last});
    next = last;
    values.push_back(ratio.at(camera_time(t)));
  }
  return values;
}

double at(const std::vector<double>& values, std::int64_t t) { return values.at(static_cast<std::size_t>(t / step - 1)); }

double largest(const std::vector<double>& values, std::int64_t from, std::int64_t to) {
  return *std::max_element(values.begin() + from / step - 1, values.begin() + to / step);
}

TEST(BackgroundRatio, IsThatOfItsFormula) {
  // 4 events per step in cell 0 and nothing else: backgrounds of 4 and 0.05. Then 9 events in cell 0, 1 in cell 3.
  std::vector<events::Event> events;
  const std::int64_t end = 300 * step;
  for (std::int64_t t = 0; t < end; t += step / 4) events.push_back({camera_time(t), 79, 79, 1});
  for (std::int64_t i = 0; i < 9; ++i) events.push_back({camera_time(end + i), 0, 0, 1});
  events.push_back({camera_time(end + 10), 80, 80, 0});
  BackgroundRatio ratio(sensor, history);
  ratio.add(events);
  ratio.at(camera_time(end));
  EXPECT_DOUBLE_EQ(ratio.background(0), 4);
  EXPECT_DOUBLE_EQ(ratio.background(1), 0.05);
  const auto of_cell = [](double n, double m) { return std::log(0.9 + 0.1 * std::exp2(n) * std::exp(-m)); };
  EXPECT_NEAR(ratio.latest(), of_cell(4, 4) + 3 * of_cell(0, 0.05), 1e-12);
  EXPECT_NEAR(ratio.at(camera_time(end + step)), of_cell(9, 4) + 2 * of_cell(0, 0.05) + of_cell(1, 0.05), 1e-12);
}

TEST(BackgroundRatio, IsInfiniteUntilTheBackgroundIsKnown) {
  const std::vector<double> ratios = values(stream(second), second);
  // The first step is not whole; 20 steps are a history.
  EXPECT_EQ(at(ratios, 270 * step), infinite);
  EXPECT_LT(at(ratios, 271 * step), infinite);
}

TEST(BackgroundRatio, IsSmallInQuietAndLargeInAPress) {
  const std::int64_t press = 3 * second, released = press + 30 * step;
  const std::vector<double> ratios = values(stream(5 * second, {{press, released, 1, 20}}), 5 * second);
  EXPECT_LT(largest(ratios, second, press), 6);
  EXPECT_GT(at(ratios, press + 2 * step), 10) << "after at most two steps";
  EXPECT_GT(at(ratios, released + history.count() - step), 10) << "as long as its events are in the history";
  EXPECT_LT(largest(ratios, released + history.count(), 5 * second), 6);
}

TEST(BackgroundRatio, OfNoiseIsLargeAsSeldomAsItsLimitPromises) {
  // 400 s of noise: Markov's bound is one of 1000 steps above ln 1000. The background is known from 250 steps, not exactly.
  const std::vector<double> ratios = values(stream(400 * second, {}, 7), 400 * second);
  const double limit = quiet_limit(history);
  const auto open = std::count_if(ratios.begin() + second / step, ratios.end(), [&](double ratio) { return ratio >= limit; });
  EXPECT_LT(static_cast<double>(open), 0.02 * static_cast<double>(ratios.size()));
  EXPECT_GT(open, 0) << "the limit is not idle";
}

TEST(BackgroundRatio, CountsEventsAtTheEndsOfTheClock) {
  BackgroundRatio ratio(sensor, history);
  const std::vector<events::Event> events{{CameraTime::max(), 1, 1, 1}, {CameraTime::max(), 2, 1, 1}};
  ratio.add(events);
  EXPECT_EQ(ratio.at(CameraTime::max()), infinite);
  BackgroundRatio early(sensor, history);
  const std::vector<events::Event> first{{CameraTime::min(), 1, 1, 1}, {after(CameraTime::min(), 1ms), 2, 1, 1}};
  early.add(first);
  EXPECT_EQ(early.at(after(CameraTime::min(), 10ms)), infinite);
}

TEST(BackgroundRatio, SeesAWeakPressInALoudCellsNeighbour) {
  const std::vector<double> ratios =
      values(stream(3 * second, {{0, 3 * second, 0, 100}, {2 * second, 2 * second + 20'000, 3, 18}}), 3 * second);
  EXPECT_LT(largest(ratios, second, 2 * second), 11.6) << "the most that one cell can give is ln 2^20 / 10";
  EXPECT_GT(largest(ratios, 2 * second, 2 * second + 10'000), 10);
}

TEST(BackgroundRatio, DoesNotLearnATouchThatPauses) {
  // For 20 s: moves for 0.7 s, then rests for 0.3 s.
  std::vector<Rate> rates;
  for (std::int64_t t = 2 * second; t < 22 * second; t += second) rates.push_back({t, t + 700'000, 2, 25});
  const std::vector<double> ratios = values(stream(23 * second, rates), 23 * second);
  for (const Rate& rate : rates) {
    EXPECT_GT(at(ratios, rate.from + 3 * step), 10) << rate.from;
    EXPECT_LT(at(ratios, rate.to + 250'000), 6) << rate.to;
  }
}

TEST(BackgroundRatio, FollowsNoiseThatRisesAtOnceWithinFiveSeconds) {
  const std::int64_t rise = 3 * second, press = 12 * second;
  std::vector<Rate> rates{{press, press + 20'000, 1, 60}};
  for (std::size_t cell = 0; cell < 4; ++cell) rates.push_back({rise, 14 * second, cell, 18});
  const std::vector<double> ratios = values(stream(14 * second, rates), 14 * second);
  EXPECT_GT(*std::min_element(ratios.begin() + (rise + 2 * step) / step, ratios.begin() + (rise + 4 * second) / step), 10)
      << "could be a touch yet";
  EXPECT_LT(at(ratios, rise + 5 * second + history.count()), 8);
  EXPECT_LT(largest(ratios, rise + 6 * second, press), 10);
  EXPECT_GT(at(ratios, press + 2 * step), 10) << "and still sees a press";
}

TEST(BackgroundRatio, FollowsNoiseThatFallsAtOnce) {
  std::vector<Rate> rates{{8 * second, 8 * second + 20'000, 1, 20}};
  for (std::size_t cell = 0; cell < 4; ++cell) rates.push_back({0, 2 * second, cell, 38});
  const std::vector<double> ratios = values(stream(9 * second, rates), 9 * second);
  EXPECT_LT(largest(ratios, second, 2 * second), 13);
  EXPECT_LT(largest(ratios, 3 * second, 8 * second), 6);
  EXPECT_GT(at(ratios, 8 * second + 2 * step), 10);
}

TEST(BackgroundRatio, FollowsAPixelThatBecomesHot) {
  const std::vector<double> ratios = values(stream(12 * second, {{3 * second, 12 * second, 0, 30}}), 12 * second);
  EXPECT_GT(at(ratios, 6 * second), 10);
  EXPECT_LT(largest(ratios, 8 * second + history.count(), 12 * second), 9);
}

TEST(BackgroundRatio, FollowsNoiseThatRisesSlowly) {
  std::vector<Rate> rates;
  for (std::int64_t t = second; t < 21 * second; t += 100'000)
    for (std::size_t cell = 0; cell < 4; ++cell) rates.push_back({t, 21 * second, cell, 0.05});
  const std::vector<double> ratios = values(stream(21 * second, rates), 21 * second);
  EXPECT_LT(largest(ratios, second, 21 * second), 9) << "from 2 to 12 events per step in 20 s";
}

TEST(BackgroundRatio, IsTheSameWhicheverTicksAreAskedFor) {
  const std::vector<events::Event> events = stream(4 * second, {{2 * second, 2 * second + 50'000, 3, 20}});
  const std::vector<double> each = values(events, 4 * second), tenth = values(events, 4 * second, 10 * step);
  for (std::size_t i = 0; i < tenth.size(); ++i) ASSERT_EQ(tenth[i], each[10 * i + 9]) << i;
  // Events that were added before their tick change nothing.
  BackgroundRatio ratio(sensor, history);
  ratio.add(events);
  for (std::size_t i = 0; i < each.size(); i += 1 + i % 7)
    ASSERT_EQ(ratio.at(camera_time(static_cast<std::int64_t>(i + 1) * step)), each[i]) << i;
}

TEST(BackgroundRatio, DoesNotCountMaskedPixels) {
  std::vector<events::Event> events = stream(3 * second);
  const std::vector<double> quiet = values(events, 3 * second);
  for (std::int64_t i = 0; i < 1000; ++i) events.push_back({camera_time(2 * second + 10 * i), 5, 6, 1});
  std::stable_sort(events.begin(), events.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
  std::erase_if(events,
                [](const events::Event& event) { return event.x == 5 && event.y == 6 && event.t < camera_time(2 * second); });
  EXPECT_GT(largest(values(events, 3 * second), 2 * second, 2 * second + 20'000), 10);
  EXPECT_LT(largest(values(events, 3 * second, step, {{5, 6}}), second, 3 * second), 6);
  EXPECT_LT(largest(quiet, second, 3 * second), 6);
}

TEST(BackgroundRatio, IsKnownOfASensorWithoutEvents) {
  BackgroundRatio ratio(sensor, history);
  EXPECT_EQ(ratio.at(camera_time(second)), infinite);
  EXPECT_EQ(ratio.at(camera_time(second + 269 * step)), infinite);
  EXPECT_LT(ratio.at(camera_time(second + 270 * step)), 0);
  EXPECT_LT(ratio.at(camera_time(1000 * 86'400 * second)), 0) << "soon, after a pause of years";
  EXPECT_DOUBLE_EQ(ratio.background(0), 0.05);
}

TEST(BackgroundRatio, StaysFiniteAtTheLargestRates) {
  std::vector<events::Event> events(2'000'000, events::Event{camera_time(0), 1, 1, 1});
  for (std::size_t i = 0; i < events.size(); ++i) events[i].t = camera_time(static_cast<std::int64_t>(i));
  const std::vector<double> loud = values(events, 2 * second);
  EXPECT_LT(largest(loud, second, 2 * second), 1) << "2000 events per step, each step";
  events.push_back({camera_time(2 * second), 100, 100, 1});
  for (int i = 0; i < 1'000'000; ++i) events.push_back({camera_time(2 * second + 1), 100, 100, 1});
  const double burst = at(values(events, 2 * second + step), 2 * second + step);
  EXPECT_NEAR(burst, std::log(0x1p20 / 10), 0.5) << "in one cell";
}

TEST(BackgroundRatio, RefusesASensorWithoutArea) {
  EXPECT_THROW(BackgroundRatio({0, 10}, history), std::exception);
  EXPECT_THROW(BackgroundRatio({40'000, 10}, history), std::exception);
  EXPECT_NO_THROW(BackgroundRatio({32'768, 1}, history));
}

TEST(OpeningRatios, AreTheLargestOfTheFirstTenMilliseconds) {
  const test::TemporaryFolder folder;
  // Intervals from 3 s that move at once, from 4 s that moves after 20 ms, and from 0.2 s, before the background is known.
  const std::vector<events::Event> events = stream(5 * second, {{3 * second, 3'100'000, 1, 20}, {4'020'000, 4'100'000, 2, 20}});
  events::RecordingWriter writer(folder / "events.aedat4", {events::event_stream_declaration(sensor, "test")});
  writer.write_events(0, events);
  writer.close();
  const auto interval = [](std::int64_t start, std::int64_t end) {
    return TouchInterval{Touch::press, camera_time(start), camera_time(end)};
  };
  const auto ratios_of = [&](const std::vector<TouchInterval>& intervals) {
    events::RecordingReader reader(folder / "events.aedat4");
    return opening_ratios(reader, intervals, {.history = history});
  };
  const std::vector<double> both =
      ratios_of({interval(4 * second, 4'500'000), interval(200'000, 400'000), interval(3 * second, 3'500'000)});
  ASSERT_EQ(both.size(), 2U);
  EXPECT_LT(both[0], 6);
  EXPECT_DOUBLE_EQ(both[1], largest(values(events, 5 * second), 3 * second + step, 3'010'000));
  EXPECT_TRUE(ratios_of({interval(3'000'100, 3'001'900)}).empty()) << "no step ends in it";
  EXPECT_TRUE(ratios_of({interval(6 * second, 7 * second)}).empty()) << "after the last event";
}

}  // namespace
}  // namespace tactile::model
