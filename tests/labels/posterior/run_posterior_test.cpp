#include "tactile/labels/posterior/run_posterior.hpp"

#include <gtest/gtest.h>

#include "alignment/made_run.hpp"
#include "labels/press_and_slip.hpp"
#include "support/real_recordings.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/labels/label_run.hpp"

namespace tactile::labels {
namespace {

using test::lift_after_press;
using test::MadeRun;
using test::ms_from_begin;
using test::press_and_slip;
using test::write_made_run;

TEST(RunPosterior, FindsPressSlipAndTheRobotsClock) {
  const test::TemporaryFolder data;
  const RunFolder run = write_made_run(data.path(), press_and_slip, lift_after_press);
  const RunPosterior posterior = run_posterior(alignment::read_run_signals(run));
  ASSERT_GE(posterior.touches.size(), 2U);
  const LikelyTouch &press = posterior.touches[0], &slip = posterior.touches[1];
  EXPECT_EQ(press.touch, Touch::press);
  EXPECT_GT(press.probability, 0.8);
  EXPECT_NEAR(ms_from_begin(press.start.at), 800, 2);
  EXPECT_NEAR(ms_from_begin(press.end.at), 1000, 6);
  EXPECT_EQ(slip.touch, Touch::slip);
  EXPECT_GT(slip.probability, 0.8);
  EXPECT_NEAR(ms_from_begin(slip.start.at), 1503, 10);
  ASSERT_EQ(posterior.robot.size(), 1U);
  EXPECT_LE(posterior.robot[0].low_us, -123'456'789);
  EXPECT_GE(posterior.robot[0].high_us, -123'456'789);
}

TEST(RunPosterior, IsTheSameInEveryThread) {
  const test::TemporaryFolder data;
  const alignment::RunSignals signals =
      alignment::read_run_signals(write_made_run(data.path(), press_and_slip, lift_after_press));
  std::vector<RunPosterior> all(3);
  parallel_for(all.size(), 3, [&](std::size_t i) { all[i] = run_posterior(signals); });
  for (const RunPosterior& one : all) {
    ASSERT_EQ(one.touches.size(), all[0].touches.size());
    for (std::size_t i = 0; i < one.touches.size(); ++i) {
      EXPECT_EQ(one.touches[i].probability, all[0].touches[i].probability);
      EXPECT_EQ(one.touches[i].start.at, all[0].touches[i].start.at);
    }
  }
}

TEST(RunPosterior, FindsNoTouchInNoise) {
  const test::TemporaryFolder data;
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    const RunFolder run =
        write_made_run(data.path() / std::to_string(seed), MadeRun{.bursts = {}, .seed = seed}, lift_after_press);
    for (const LikelyTouch& touch : run_posterior(alignment::read_run_signals(run)).touches)
      EXPECT_LT(touch.probability, 0.5) << name_of(touch.touch) << ", seed " << seed;
  }
}

TEST(RunPosterior, FindsNoTouchInTheNoiseOfARealCamera) {
  const char* const still = "derived/dvxplorer640_libcaer_rollover.aedat4";
  const auto file = test::real_recording(still);
  if (file.empty()) GTEST_SKIP() << test::not_tested_without(still);
  const test::TemporaryFolder data;
  const RunFolder run{.folder = data.path() / "noise" / "01", .object = "noise", .run = "01"};
  std::filesystem::create_directories(run.folder);
  std::filesystem::copy_file(file, run.events());
  for (const LikelyTouch& touch : run_posterior(alignment::read_run_signals(run)).touches)
    EXPECT_LT(touch.probability, 0.1) << name_of(touch.touch);
}

TEST(PosteriorLabels, HaveAProbabilityAndNoFlagWhereAllIsClear) {
  const test::TemporaryFolder data;
  const RunFolder run = write_made_run(data.path(), press_and_slip, lift_after_press);
  const Labels labels = label_run(run);
  ASSERT_EQ(labels.intervals.size(), 2U);
  for (const LabelledInterval& interval : labels.intervals) {
    ASSERT_TRUE(interval.probability.has_value());
    EXPECT_GT(*interval.probability, 0.5);
    EXPECT_LE(interval.start.low, interval.start.at);
    EXPECT_LE(interval.start.at, interval.start.high);
  }
  write_labels(run.labels(), labels);
  const Labels again = read_labels(run.labels());
  EXPECT_EQ(again.intervals[0].probability, labels.intervals[0].probability);
  EXPECT_EQ(again.robot_clocks.size(), 1U);
}

TEST(PosteriorLabels, FlagATouchThatBeganBeforeTheRecording) {
  const test::TemporaryFolder data;
  const MadeRun from_the_start{.bursts = {{0, 200'000}, {1'503'000, 2'097'000}}};
  const Labels labels = label_run(write_made_run(data.path(), from_the_start, lift_after_press));
  const bool found = std::any_of(labels.flags.begin(), labels.flags.end(), [](const LabelFlag& flag) {
    return flag.reason.find("the recording begins within it") != std::string::npos;
  });
  EXPECT_TRUE(found || labels.intervals.empty() || ms_from_begin(labels.intervals[0].start.at) > 1000);
}

}  // namespace
}  // namespace tactile::labels
