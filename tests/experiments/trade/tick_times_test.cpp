#include "tactile/experiments/trade/tick_times.hpp"

#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/experiments/trade/tick_quantiles.hpp"
#include "windows/made_runs.hpp"

namespace tactile::trade {
namespace {

TEST(WriteTimes, ReadsBackTheSame) {
  const test::TemporaryFolder folder;
  const std::vector<TimesOfRuns> ways{{{{1.5F, 2.25F, 3, 7, 2}, {4, 5, 6, 0}}, {}}, {{}, {{0.125F, 0, 1, 12}}}};
  write_times(folder / "times.ticks", ways);
  const auto read = read_times(folder / "times.ticks");
  ASSERT_EQ(read.size(), 2U);
  ASSERT_EQ(read[0].size(), 2U);
  ASSERT_EQ(read[0][0].size(), 2U);
  EXPECT_EQ(read[0][0][0].rendering, 2.25F);
  EXPECT_EQ(read[0][0][0].interruptions, 2U);
  EXPECT_EQ(read[0][0][1].events, 0U);
  EXPECT_TRUE(read[0][1].empty());
  EXPECT_EQ(read[1][1][0].counting, 0.125F);
  EXPECT_EQ(read[1][1][0].events, 12U);
  const std::string whole = read_text(folder / "times.ticks");
  for (const std::string& bad :
       {std::string(), std::string("{}"), std::string("{\"ticks\": [[-1]]}\n"),
        std::string("{\"ticks\": [[18446744073709551615]]}\n"), whole.substr(0, whole.size() - 1), whole + "x"}) {
    write_whole(folder / "bad.ticks", bad);
    EXPECT_THROW(read_times(folder / "bad.ticks"), Error) << bad;
  }
}

/// A network that every setting shares.
OpenTimedModel timed_as(const model::ClassifyHeatmap& network) {
  return [network](const TimedSetting&) -> TimedModel {
    return [network](events::SensorSize sensor, const heatmaps::HeatmapOptions& rendering) {
      return std::make_unique<model::HeatmapClassifier>(sensor, rendering, network);
    };
  };
}

TEST(TimeTicks, KeepsEveryStallOfEveryTurn) {
  const test::TemporaryFolder folder;
  test::make_run(folder.path(), {.length_us = 600'000});
  std::uint64_t calls = 0, stalls = 0;
  const auto open = timed_as([&](std::span<const std::uint8_t>) {
    if (++calls % 20 == 0) {
      ++stalls;
      std::this_thread::sleep_for(5ms);
    }
    return model::Logits{};
  });
  const std::vector<TimedSetting> settings(1);
  const std::vector<std::filesystem::path> recordings{folder / "fan/01/events.aedat4"};
  const auto times = time_ticks(settings, recordings, {.ticks = 600, .pieces = 4, .turns = 3}, {}, open);
  TimedRun run;
  for (const TickTime& tick : times.at(0).at(0)) run.tick_us.push_back(static_cast<float>(tick.total()));
  // 12 turns of 50 ticks, each after one that warms up; of the 30 stalls, the 23rd (call 460) is in a tick that warms up.
  EXPECT_EQ(run.tick_us.size(), 600U);
  EXPECT_EQ(calls, 612U);
  EXPECT_EQ(stalls, 30U);
  EXPECT_GE(std::count_if(run.tick_us.begin(), run.tick_us.end(), [](float us) { return us >= 5000; }), 29);
  const TickQuantiles quantiles({&run, 1});
  const std::vector<std::uint32_t> once{1};
  EXPECT_LT(quantiles.of(once, 0.5).value_or(0), 5000);
  EXPECT_GE(quantiles.of(once, 0.99).value_or(0), 5000) << "4.8 % of the ticks";
}

TEST(TimeTicks, CountTheTicksThatOtherProgramsInterrupt) {
  const test::TemporaryFolder folder;
  test::make_run(folder.path(), {.length_us = 600'000});
  // On one core with another thread that is never idle, ticks of 2 ms are interrupted, as the system divides the core.
  cpu_set_t all, one;
  ASSERT_EQ(::sched_getaffinity(0, sizeof all, &all), 0);
  CPU_ZERO(&one);
  CPU_SET(static_cast<std::size_t>(::sched_getcpu()), &one);
  ASSERT_EQ(::sched_setaffinity(0, sizeof one, &one), 0);
  std::atomic<bool> ends = false;
  std::thread other([&] {
    while (!ends) {
    }
  });
  const auto open = timed_as([](std::span<const std::uint8_t>) {
    const auto begin = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - begin < 2ms) {
    }
    return model::Logits{};
  });
  const std::vector<std::filesystem::path> recordings{folder / "fan/01/events.aedat4"};
  const auto times = time_ticks(std::vector<TimedSetting>(1), recordings, {.ticks = 200, .pieces = 2, .turns = 1}, {}, open);
  ends = true;
  other.join();
  ::sched_setaffinity(0, sizeof all, &all);
  const auto interrupted = std::count_if(times.at(0).at(0).begin(), times.at(0).at(0).end(),
                                         [](const TickTime& tick) { return tick.interruptions > 0; });
  EXPECT_GE(interrupted, 20) << "of 200";
}

TEST(TimeTicks, TakesMoreTurnsWhereARecordingHasFewTicks) {
  const test::TemporaryFolder folder;
  test::make_run(folder.path(), {.length_us = 450'000, .mean_gap_us = 1000});
  TimedSetting setting;
  setting.rendering.history = setting.rendering.tick = 100ms;
  const auto open = timed_as([](std::span<const std::uint8_t>) { return model::Logits{}; });
  const std::vector<std::filesystem::path> recordings{folder / "fan/01/events.aedat4"};
  const auto times = time_ticks({&setting, 1}, recordings, {.ticks = 60, .pieces = 2, .turns = 3}, {}, open);
  EXPECT_GE(times.at(0).at(0).size(), 60U) << "three or four ticks, again and again";
  // No history fits: no tick.
  setting.rendering.history = setting.rendering.tick = 1000ms;
  EXPECT_TRUE(time_ticks({&setting, 1}, recordings, {.ticks = 60, .pieces = 2}, {}, open).at(0).at(0).empty());
}

TEST(TickQuantiles, CountEachRunAsOftenAsItIsDrawn) {
  std::vector<TimedRun> runs(2);
  runs[0].tick_us = {3, 1, 2};
  runs[1].tick_us = {10};
  const TickQuantiles quantiles(runs);
  using Weights = std::vector<std::uint32_t>;
  EXPECT_EQ(quantiles.of(Weights{1, 1}, 0.5), 2);
  EXPECT_EQ(quantiles.of(Weights{1, 1}, 0.99), 10);
  EXPECT_EQ(quantiles.of(Weights{1, 0}, 0.99), 3);
  EXPECT_EQ(quantiles.of(Weights{1, 4}, 0.5), 10);
  EXPECT_EQ(quantiles.of(evaluation::RunsByObject{{0, 0}, {1}}, 0.5), 2);
  EXPECT_EQ(quantiles.of(Weights{0, 0}, 0.5), std::nullopt);
  // As sorting all of them gives it.
  Random random(7);
  std::vector<double> all;
  for (std::size_t i = 0; i < 999; ++i) {
    runs[i % 2].tick_us.push_back(static_cast<float>(random.below(500)));
  }
  for (const TimedRun& run : runs) all.insert(all.end(), run.tick_us.begin(), run.tick_us.end());
  const TickQuantiles many(runs);
  for (const double q : {0.0, 0.01, 0.3, 0.5, 0.51, 0.9, 0.99, 0.999, 1.0})
    EXPECT_EQ(many.of(Weights{1, 1}, q), q == 0 ? *std::min_element(all.begin(), all.end()) : nearest_rank_quantile(all, q)) << q;
}

}  // namespace
}  // namespace tactile::trade
