#include "tactile/model/training/validation_cut.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tactile/core/random.hpp"

namespace tactile::model {
namespace {

windows::Sample at(std::uint32_t run, std::int64_t t_us, Touch touch) { return {run, camera_time(t_us), touch}; }

TEST(CutInTime, TakesTheLastOfEachClassAndLeavesOutWhatSharesEventsWithThem) {
  const std::vector<windows::Sample> samples{
      at(0, 0, Touch::none),        at(0, 100'000, Touch::press), at(0, 138'000, Touch::press),
      at(0, 140'000, Touch::press), at(0, 178'000, Touch::press), at(0, 180'000, Touch::press),
      at(0, 219'000, Touch::none),  at(0, 220'000, Touch::none),  at(0, 260'000, Touch::none)};
  const ValidationCut cut = cut_in_time(samples, 0.25, 40ms);
  // Of five presses one, of four nones one. 140 ms is 40 before the press that judges and shares no event with it; 178 and 219
  // do.
  EXPECT_EQ(cut.validation, (std::vector<std::uint32_t>{5, 8}));
  EXPECT_EQ(cut.training, (std::vector<std::uint32_t>{0, 1, 2, 3, 7}));
}

TEST(CutInTime, NoShareLeavesAllToLearnFrom) {
  const std::vector<windows::Sample> samples{at(0, 0, Touch::none), at(1, 0, Touch::press), at(1, 2'000, Touch::slip)};
  const ValidationCut cut = cut_in_time(samples, 0, 40ms);
  EXPECT_EQ(cut.training, (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_TRUE(cut.validation.empty());
  EXPECT_TRUE(cut_in_time({}, 0.2, 40ms).training.empty());
}

TEST(CutInTime, RunsAreCutEachByItselfAndNoHistoryIsShared) {
  Random random(5);
  std::vector<windows::Sample> samples;
  for (std::uint32_t run = 0; run < 4; ++run) {
    std::vector<std::int64_t> times;
    for (int i = 0; i < 300; ++i) times.push_back(static_cast<std::int64_t>(2'000 * random.below(2'000)));
    std::sort(times.begin(), times.end());
    for (const std::int64_t t : times) samples.push_back(at(run, t, all_touches[random.below(touch_count)]));
  }
  const ValidationCut cut = cut_in_time(samples, 0.2, 40ms);
  for (std::uint32_t run = 0; run < 4; ++run) {
    for (const Touch touch : all_touches) {
      const auto is_of_it = [&](const windows::Sample& s) { return s.run_index == run && s.touch == touch; };
      const auto all = std::count_if(samples.begin(), samples.end(), is_of_it);
      const auto judged =
          std::count_if(cut.validation.begin(), cut.validation.end(), [&](std::uint32_t i) { return is_of_it(samples[i]); });
      EXPECT_EQ(judged, all / 5);
    }
  }
  for (const std::uint32_t a : cut.training) {
    for (const std::uint32_t b : cut.validation) {
      if (samples[a].run_index != samples[b].run_index) continue;
      const auto apart = us_of(samples[a].t) - us_of(samples[b].t);
      ASSERT_GE(apart < 0 ? -apart : apart, 40'000);
    }
  }
}

}  // namespace
}  // namespace tactile::model
