#include "tactile/trade/run_said.hpp"

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile {
namespace {

/// Ticks of 2 ms from 6 ms on.
RunSaid said_of(std::vector<Touch> said, std::vector<std::uint64_t> events) {
  RunSaid run{"fan/03", {.first = camera_time(6000), .count = 0, .tick = 2ms}, std::move(said), std::move(events)};
  run.ticks.count = static_cast<std::int64_t>(run.said.size());
  return run;
}

TEST(AtTick, TakesTheTicksThatLieAtWholeMultiples) {
  const RunSaid said = said_of({Touch::press, Touch::slip, Touch::none, Touch::press}, {1, 2, 3, 4});  // 6, 8, 10, 12 ms
  const RunSaid fewer = at_tick(said, 4ms);
  EXPECT_EQ(fewer.ticks.first, camera_time(8000));
  EXPECT_EQ(fewer.ticks.count, 2);
  EXPECT_EQ(fewer.ticks.tick, microseconds(4000));
  EXPECT_EQ(fewer.said, (std::vector<Touch>{Touch::slip, Touch::press}));
  EXPECT_EQ(fewer.events, (std::vector<std::uint64_t>{2, 4}));
  EXPECT_EQ(at_tick(said, 100ms).ticks.count, 0);
  EXPECT_THROW(at_tick(said, 3ms), Error);
}

TEST(VerdictsOf, GateFirstAndThenConfirm) {
  const RunSaid said = said_of({Touch::press, Touch::press, Touch::press, Touch::press}, {9, 1, 9, 9});
  const std::vector<Touch> all(4, Touch::press);
  EXPECT_EQ(verdicts_of(said, std::nullopt, {}), all);
  EXPECT_EQ(verdicts_of(said, 5, {}), (std::vector<Touch>{Touch::press, Touch::none, Touch::press, Touch::press}));
  EXPECT_EQ(verdicts_of(said, 5, {2, 2}), (std::vector<Touch>{Touch::none, Touch::none, Touch::none, Touch::press}));
}

TEST(WriteSaid, ReadsBackTheSame) {
  const test::TemporaryFolder folder;
  const std::vector<RunSaid> runs{said_of({Touch::none, Touch::slip}, {0, 70'000'000'000}), said_of({}, {})};
  write_said(folder / "said.json", runs);
  const auto read = read_said(folder / "said.json");
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[0].run, "fan/03");
  EXPECT_EQ(read[0].said, runs[0].said);
  EXPECT_EQ(read[0].events, runs[0].events);
  EXPECT_EQ(read[0].ticks.first, runs[0].ticks.first);
  EXPECT_EQ(read[0].ticks.count, 2);
  EXPECT_EQ(read[1].ticks.count, 0);
  for (const char* bad : {"nonsense", R"({"runs": [{"run": "a", "first_us": 0, "tick_us": 2, "said": "03", "events": [1, 2]}]})",
                          R"({"runs": [{"run": "a", "first_us": 0, "tick_us": 2, "said": "01", "events": [1]}]})"}) {
    write_whole(folder / "bad.json", bad);
    EXPECT_THROW(read_said(folder / "bad.json"), Error) << bad;
  }
}

}  // namespace
}  // namespace tactile
