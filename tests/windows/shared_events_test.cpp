#include "tactile/windows/shared_events.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "support/temporary_folder.hpp"
#include "windows/made_runs.hpp"

namespace tactile::windows {
namespace {

using Key = std::tuple<std::int64_t, int, int, int>;

Key key_of(const events::Event& event) { return {us_of(event.t), event.x, event.y, event.on}; }

/// A run as it is compared, its windows those of samples at `ticks_us` from its start.
PlannedRun planned(const RunFolder& folder, const std::vector<events::Event>& events, const std::vector<std::int64_t>& ticks_us) {
  PlannedRun run{};
  run.folder = folder;
  run.first_event = events.front().t;
  run.last_event = events.back().t;
  run.recorded_events = events.size();
  for (const std::int64_t tick : ticks_us) run.samples.push_back({0, after(events.front().t, microseconds{tick}), Touch::press});
  return run;
}

/// The definition, event by event.
SharedEvents counted(const std::vector<events::Event>& mine, const PlannedRun& run, const std::vector<events::Event>& others,
                     const PlannedRun& other, microseconds history) {
  std::set<Key> there;
  for (const events::Event& event : others) there.insert(key_of(event));
  SharedEvents result;
  for (const events::Event& event : mine) {
    const bool in_window = std::any_of(run.samples.begin(), run.samples.end(), [&](const Sample& sample) {
      return event.t >= before(sample.t, history) && event.t < sample.t;
    });
    if (!in_window || event.t < other.first_event || event.t > other.last_event) continue;
    ++result.events;
    result.shared += there.contains(key_of(event)) ? 1 : 0;
  }
  return result;
}

TEST(SharedEvents, AreCountedByTheDefinitionWhereverRecordingsOverlap) {
  // A sensor so small and events so dense that many are equal by chance; more of them than a slice holds.
  const test::TemporaryFolder folder;
  const std::vector<std::int64_t> begins{-500'000, -450'000, -449'999, 700'000, -340'000};
  std::vector<std::vector<events::Event>> events;
  std::vector<PlannedRun> runs;
  for (std::size_t i = 0; i < begins.size(); ++i) {
    const test::LabelledRun run{.object = "fan",
                                .run = "0" + std::to_string(i + 1),
                                .sensor = {8, 6},
                                .seed = 40 + i,
                                .begin_us = begins[i],
                                .length_us = 150'000 + 20'000 * static_cast<std::int64_t>(i),
                                .mean_gap_us = 1,
                                .labelled = false};
    const RunFolder made = test::make_run(folder.path(), run);
    events.push_back(test::random_events(run));
    runs.push_back(planned(made, events.back(), {5'000, 6'000, 60'000, 120'000, 149'000}));
  }
  for (const unsigned threads : {1U, 2U}) {
    const std::vector<SharedEvents> pairs = shared_events(runs, 10ms, threads);
    std::set<std::pair<std::uint32_t, std::uint32_t>> seen;
    for (const SharedEvents& pair : pairs) {
      seen.insert({pair.run_index, pair.other_index});
      const SharedEvents expected =
          counted(events[pair.run_index], runs[pair.run_index], events[pair.other_index], runs[pair.other_index], 10ms);
      EXPECT_EQ(pair.events, expected.events) << pair.run_index << " and " << pair.other_index;
      EXPECT_EQ(pair.shared, expected.shared) << pair.run_index << " and " << pair.other_index;
    }
    // The fourth is alone; the last one begins after the first has ended.
    EXPECT_EQ(seen, (std::set<std::pair<std::uint32_t, std::uint32_t>>{
                        {0, 1}, {1, 0}, {0, 2}, {2, 0}, {1, 2}, {2, 1}, {1, 4}, {4, 1}, {2, 4}, {4, 2}}));
    EXPECT_TRUE(std::any_of(pairs.begin(), pairs.end(), [](const SharedEvents& pair) { return pair.shared > 100; }));
  }
}

TEST(SharedEvents, AreNoneWithoutOverlap) {
  const test::TemporaryFolder folder;
  std::vector<PlannedRun> runs;
  for (const std::int64_t begin : {0, 2'000'000}) {
    const test::LabelledRun run{.run = begin == 0 ? "01" : "02", .begin_us = begin, .labelled = false};
    runs.push_back(planned(test::make_run(folder.path(), run), test::random_events(run), {100'000}));
  }
  EXPECT_TRUE(shared_events(runs, 50ms, 1).empty());
  EXPECT_TRUE(shared_events({}, 50ms, 1).empty());
}

}  // namespace
}  // namespace tactile::windows
