// The summaries that `eval` and `detect` print: what they advise, and when.
#include <gtest/gtest.h>

#include "detect_report.hpp"
#include "eval_summary.hpp"

namespace tactile::cli {
namespace {

using namespace std::chrono_literals;

bool has(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

TEST(EvalSummary, HasWhatFewerFalseAlarmsCost) {
  results::Evaluation evaluation;
  evaluation.models = {{.name = "m", .settings = nlohmann::json::object(), .weights_sha256 = {}, .test_runs = {}}};
  results::WholeRuns& whole = evaluation.whole_runs;
  whole.runs = {"fan/02", "mug/02"};
  whole.by_truth = {"mug/02"};
  whole.left_out = {{"fan/03", "it has no labels"}};
  whole.decided.alarms_per_min = {.value = 21.75, .low = 15.7, .high = 29.5};
  whole.decided.touches = 170;
  whole.decided.misses = 2;
  whole.decided.early = 1;
  whole.causes = {{"quiet", 2}, {"firm lift", 13}};
  results::OperatingPoint calm = whole.decided;
  calm.threshold = 3;
  whole.calm = {{2, calm}, {0.6, {}}};
  const std::string text = summary_of(evaluation);
  EXPECT_TRUE(has(text, "21.8 a minute [15.7, 29.5]")) << text;
  EXPECT_TRUE(has(text, "3 of 170 missed")) << text;
  EXPECT_TRUE(has(text, "firm lift 13, quiet 2")) << text;
  EXPECT_TRUE(has(text, "\nat most 2 ")) << text;
  EXPECT_TRUE(has(text, "none")) << text;
  EXPECT_TRUE(has(text, "2 whole runs, 1 judged by their truth, the others by their labels. 1 run is left")) << text;
  EXPECT_TRUE(has(text, "fan/03, it has no labels.")) << text;
}

/// 1000 ticks of a live source.
detect::DetectionSummary live_detection() {
  detect::DetectionSummary summary;
  summary.source = "tcp://127.0.0.1:7777";
  summary.ended = "source ended";
  for (int i = 0; i < 1000; ++i) summary.deadlines.add({.waiting = 1ms, .queued = 0ms, .network = 200us}, 0);
  summary.counts.events = 100'000;
  return summary;
}

std::string printed(const detect::DetectionSummary& summary) { return text_of(summary, {"m", "fast", "fp32"}, false); }

TEST(DetectSummary, ProposesASlackOnlyWhereManyEventsOrTicksAreLate) {
  detect::DetectionSummary summary = live_detection();
  summary.proposed_slack = 8ms;
  const std::string advice = "with --slack-us 8000 most of them would be in time; ticks wait up to 8 ms for them";
  summary.counts.late_events = 1000;
  EXPECT_FALSE(has(printed(summary), advice)) << "under 1 % of the events that arrived";
  EXPECT_TRUE(has(printed(summary), "1000 too late (0.990 %)")) << printed(summary);
  summary.counts.late_events = 1100;
  EXPECT_TRUE(has(printed(summary), advice)) << printed(summary);
  summary.proposed_slack.reset();
  EXPECT_FALSE(has(printed(summary), "--slack-us"));

  summary = live_detection();
  summary.proposed_slack = 8ms;
  summary.counts.late_events = 10;
  summary.counts.incomplete = 50;
  EXPECT_FALSE(has(printed(summary), advice)) << "a twentieth of the ticks";
  summary.counts.incomplete = 51;
  EXPECT_TRUE(has(printed(summary), advice)) << printed(summary);
  EXPECT_TRUE(has(printed(summary), "51 ticks, 5.100 %: judged without all events of their history; not counted as missed"));
}

TEST(DetectSummary, TellsAReplayFromALiveSource) {
  detect::DetectionSummary summary = live_detection();
  EXPECT_TRUE(has(printed(summary), "1000 reported, 0 skipped, 0 more than a tick late: 0.000 % missed")) << printed(summary);
  summary.plays = true;
  EXPECT_TRUE(has(printed(summary), "1000 reported, none skipped; no deadline for a replay")) << printed(summary);
  EXPECT_FALSE(has(printed(summary), "incomplete"));
}

}  // namespace
}  // namespace tactile::cli
