#include "tactile/experiments/trade/full_runs.hpp"

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::trade {
namespace {

/// Ticks of 2 ms from 6 ms on.
results::FullRun predicted_as(std::vector<Touch> verdicts, std::vector<std::uint64_t> events) {
  results::FullRun run{.run = "fan/03",
                       .ticks = {.first = camera_time(6000), .count = 0, .tick = 2ms},
                       .verdicts = std::move(verdicts),
                       .events = std::move(events)};
  run.ticks.count = static_cast<std::int64_t>(run.verdicts.size());
  return run;
}

TEST(AtTick, TakesTheTicksThatLieAtWholeMultiples) {
  const results::FullRun predicted =
      predicted_as({Touch::press, Touch::slip, Touch::none, Touch::press}, {1, 2, 3, 4});  // 6, 8, 10, 12 ms
  const results::FullRun fewer = at_tick(predicted, 4ms);
  EXPECT_EQ(fewer.ticks.first, camera_time(8000));
  EXPECT_EQ(fewer.ticks.count, 2);
  EXPECT_EQ(fewer.ticks.tick, microseconds(4000));
  EXPECT_EQ(fewer.verdicts, (std::vector<Touch>{Touch::slip, Touch::press}));
  EXPECT_EQ(fewer.events, (std::vector<std::uint64_t>{2, 4}));
  EXPECT_EQ(at_tick(predicted, 100ms).ticks.count, 0);
  EXPECT_THROW(at_tick(predicted, 3ms), Error);
}

TEST(AtTick, KeepsTheProbabilitiesOfItsTicks) {
  results::FullRun predicted = predicted_as({Touch::press, Touch::slip, Touch::none}, {1, 2, 3});  // 6, 8, 10 ms
  predicted.probabilities = {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}};
  EXPECT_EQ(at_tick(predicted, 4ms).probabilities, (decltype(predicted.probabilities){{0, 0, 1}}));
}

TEST(WriteFullRuns, ReadsBackTheSame) {
  const test::TemporaryFolder folder;
  std::vector<results::FullRun> runs{predicted_as({Touch::none, Touch::slip}, {0, 70'000'000'000}), predicted_as({}, {})};
  runs[0].probabilities = {{1, 0, 0}, {0, 0.1F, 0.9F}};
  write_full_runs(folder / "predicted.json", runs);
  const auto read = read_full_runs(folder / "predicted.json");
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[0].run, "fan/03");
  EXPECT_EQ(read[0].verdicts, runs[0].verdicts);
  EXPECT_EQ(read[0].events, runs[0].events);
  EXPECT_EQ(read[0].probabilities, runs[0].probabilities);
  EXPECT_EQ(read[0].ticks.first, runs[0].ticks.first);
  EXPECT_EQ(read[0].ticks.count, 2);
  EXPECT_EQ(read[1].ticks.count, 0);
  for (const char* bad : {"nonsense", "{}", R"({"runs": [{"run": "a"}]})"}) {
    write_whole(folder / "bad.json", bad);
    EXPECT_THROW(read_full_runs(folder / "bad.json"), Error) << bad;
  }
}

}  // namespace
}  // namespace tactile::trade
