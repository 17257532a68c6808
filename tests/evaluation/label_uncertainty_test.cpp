#include "tactile/evaluation/label_uncertainty.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/verdict_row.hpp"
#include "tactile/core/duration_units.hpp"

namespace tactile::evaluation {
namespace {

using test::ticks_of;

/// A label with the 95 % intervals of its onset and end [ms].
struct Label {
  Touch touch;
  std::int64_t start, start_low, start_high, end, end_low, end_high;
};

RunTruth truth_of(const std::vector<Label>& labels) {
  const auto ms = [](std::int64_t t) { return camera_time(1000 * t); };
  RunTruth truth;
  for (const Label& label : labels) {
    truth.labels.push_back({{label.touch, ms(label.start), ms(label.end)}, true});
    truth.bounds.push_back(
        {{ms(label.start), ms(label.start_low), ms(label.start_high)}, {ms(label.end), ms(label.end_low), ms(label.end_high)}});
  }
  return truth;
}

TEST(DrawnLabels, LieInTheirIntervalInNineteenOfTwentyDraws) {
  const RunTruth truth = truth_of({{Touch::press, 1000, 960, 1010, 1500, 1490, 1580}});
  Random random(7);
  int low = 0, high = 0, in_end = 0;
  constexpr int draws = 20'000;
  for (int i = 0; i < draws; ++i) {
    const TouchInterval drawn = drawn_labels(truth, random).at(0);
    low += drawn.start < camera_time(960'000) ? 1 : 0;
    high += drawn.start > camera_time(1'010'000) ? 1 : 0;
    in_end += drawn.end >= camera_time(1'490'000) && drawn.end <= camera_time(1'580'000) ? 1 : 0;
  }
  // One in forty on each side; the standard error of these counts is 22, and 31 of the last.
  EXPECT_NEAR(low, draws / 40.0, 100);
  EXPECT_NEAR(high, draws / 40.0, 100);
  EXPECT_NEAR(in_end, draws * 0.95, 140);
}

TEST(DrawnLabels, NeverOverlap) {
  const RunTruth truth = truth_of({{Touch::press, 100, 50, 150, 140, 90, 190}, {Touch::slip, 150, 60, 250, 160, 70, 260}});
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const auto drawn = drawn_labels(truth, random);
    EXPECT_LE(drawn[0].start, drawn[0].end);
    EXPECT_LE(drawn[0].end, drawn[1].start);
    EXPECT_LE(drawn[1].start, drawn[1].end);
  }
}

TEST(DrawnLabels, LeaveOutThoseInDoubt) {
  RunTruth truth = truth_of({{Touch::press, 100, 90, 110, 140, 130, 145}, {Touch::slip, 150, 148, 155, 260, 250, 270}});
  truth.labels[0].used = false;
  Random random(3);
  const auto drawn = drawn_labels(truth, random);
  ASSERT_EQ(drawn.size(), 1U);
  EXPECT_EQ(drawn[0].touch, Touch::slip);
}

/// A run of 2 s whose press is predicted from 1020 ms on, in steps of 2 ms.
RunByDrawnLabels run_of(const char* object, const RunTruth& truth, std::uint64_t seed) {
  std::vector<Touch> verdicts(1000, Touch::none);
  std::fill(verdicts.begin() + 510, verdicts.begin() + 700, Touch::press);
  std::vector<std::size_t> samples;
  for (std::size_t k = 400; k < 700; ++k) samples.push_back(k);
  const TickRange ticks = ticks_of(verdicts);
  RunByDrawnLabels run{{object}, {}, scores_by_drawn_labels(ticks, verdicts, samples, truth, {}, seed)};
  for (const std::size_t k : samples)
    run.as_labelled.confusion.add(touch_at(ticks.at(static_cast<std::int64_t>(k)), truth.used()), verdicts[k]);
  run.as_labelled.detections = detections_of(ticks, verdicts, truth.used());
  return run;
}

TEST(LabelUncertainty, SpreadsTheDelayByThatOfTheOnset) {
  // Onset at 1001 ms +- 9.8 ms: a standard deviation of 5 ms. The delay is 20 ms by the label, and as many ms more or less by
  // draws.
  const RunTruth truth = truth_of({{Touch::press, 1001, 991, 1011, 1400, 1400, 1400}});
  std::vector<RunByDrawnLabels> runs;
  for (const char* object : {"fan", "box", "hub"}) runs.push_back(run_of(object, truth, seed_for(1, {object})));
  EXPECT_EQ(runs[0].as_labelled.detections.at(0).delay, 20ms);
  std::vector<double> delays;
  for (const DrawnDetection& detection : runs[0].drawn.detections) delays.push_back(static_cast<double>(detection.us) / 1000);
  ASSERT_EQ(delays.size(), label_draws);
  double sum = 0, squares = 0;
  for (const double delay : delays) sum += delay, squares += delay * delay;
  const double mean = sum / static_cast<double>(label_draws);
  EXPECT_NEAR(mean, 20, 1.5);
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(label_draws) - mean * mean), 5.1, 0.8);

  const results::LabelUncertainty found = label_uncertainty(runs);
  EXPECT_EQ(found.draws, label_draws);
  EXPECT_EQ(found.press_mean_ms.with_runs.value, 20);
  // The mean of three runs of their own draws: 5.1 ms / sqrt(3), and 1.96 times that on each side.
  EXPECT_NEAR(found.press_mean_ms.high - found.press_mean_ms.low, 2 * 1.96 * 5.1 / std::sqrt(3), 2.5);
  // Three equal delays of 20 of at most 399 ms leave room for 3.69 in three that differ by as much: [3.21, 61.64] ms, from SciPy.
  const results::SpreadByLabels& mean_ms = found.press_mean_ms;
  EXPECT_NEAR(*mean_ms.with_runs.low, 20 - std::hypot(20 - 3.210359379896273, mean_ms.mean - mean_ms.low), 1e-6);
  EXPECT_NEAR(*mean_ms.with_runs.high, 20 + std::hypot(61.64012023873814 - 20, mean_ms.high - mean_ms.mean), 1e-6);
  // Delays of 10, 20 and 30 ms: the interval over objects is wider than that of the labels, and both together are wider still.
  runs[0].as_labelled.detections.at(0).delay = 10ms;
  runs[2].as_labelled.detections.at(0).delay = 30ms;
  const results::SpreadByLabels both = label_uncertainty(runs).press_mean_ms;
  ASSERT_TRUE(both.with_runs.has_interval());
  EXPECT_GT(*both.with_runs.high - *both.with_runs.low, both.high - both.low);
  EXPECT_LT(found.accuracy.low, found.accuracy.high);
  EXPECT_TRUE(std::isnan(found.slip_mean_ms.mean));
}

TEST(LabelUncertainty, HasTheDelaysOfExactLabelsInEachDraw) {
  const RunTruth drawn = truth_of({{Touch::press, 1001, 991, 1011, 1400, 1400, 1400}});
  const RunTruth exact = truth_of({{Touch::press, 971, 971, 971, 1400, 1400, 1400}});
  const std::vector<RunByDrawnLabels> runs{run_of("fan", drawn, 1), run_of("box", exact, 2), run_of("hub", exact, 3)};
  const results::SpreadByLabels found = label_uncertainty(runs).press_mean_ms;
  EXPECT_NEAR(found.mean, 40, 0.6) << "20 ms, and twice 50 ms";
  EXPECT_NEAR(found.high - found.low, 2 * 1.96 * 5.1 / 3, 2) << "only one of the three is spread";
}

TEST(LabelUncertainty, IsNothingWhereNoLabelHasAnInterval) {
  const RunTruth exact = truth_of({{Touch::press, 1001, 1001, 1001, 1400, 1400, 1400}});
  const std::vector<RunByDrawnLabels> runs{run_of("fan", exact, 1)};
  EXPECT_TRUE(runs[0].drawn.empty());
  EXPECT_EQ(label_uncertainty(runs).draws, 0U);
}

TEST(LabelUncertainty, ComesBackAsItWasWritten) {
  const results::LabelUncertainty found = label_uncertainty(
      std::vector<RunByDrawnLabels>{run_of("fan", truth_of({{Touch::press, 1001, 991, 1011, 1400, 1390, 1410}}), 1)});
  const nlohmann::json json = found;
  EXPECT_EQ(
      nlohmann::json(results::JsonView(json, "eval.json", results::MissingMember::is_error).get<results::LabelUncertainty>()),
      json);
}

}  // namespace
}  // namespace tactile::evaluation
