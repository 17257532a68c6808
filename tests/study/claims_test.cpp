#include "tactile/study/claims.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tactile/core/error.hpp"

namespace tactile {
namespace {

/// A run whose samples, 100 of none, are said right so many times.
RunConfusion run_of(const std::string& object, unsigned right) {
  RunConfusion run{object, {}};
  run.confusion.counts[0][0] = right;
  run.confusion.counts[0][1] = 100 - right;
  return run;
}

/// Three runs of each of three objects, all alike.
std::vector<RunConfusion> runs_of(unsigned fan, unsigned hub, unsigned box) {
  std::vector<RunConfusion> runs;
  for (const auto& [object, right] : {std::pair("fan", fan), std::pair("usb-hub", hub), std::pair("white-box", box)}) {
    for (int i = 0; i < 3; ++i) runs.push_back(run_of(object, right));
  }
  return runs;
}

Figure figure(double value, double low, double high) { return {value, low, high, 3}; }
Figure without_bounds(double value) { return {value, {}, {}, 1}; }

Claim claim_named(const ClaimInputs& inputs, const std::string& id) {
  const auto claims = claims_of(inputs);
  const auto found = std::find_if(claims.begin(), claims.end(), [&](const Claim& claim) { return claim.id == id; });
  if (found == claims.end()) throw Error(id + ": no such claim");
  return *found;
}

ClaimInputs with_histories(std::map<microseconds, std::vector<RunConfusion>> histories) {
  ClaimInputs inputs;
  inputs.histories = std::move(histories);
  return inputs;
}

TEST(Verdict, IsSaidOnlyWhereTheWholeIntervalLiesOnOneSide) {
  EXPECT_EQ(below(figure(3, 2, 4), 5), Verdict::holds);
  EXPECT_EQ(below(figure(6, 5, 7), 5), Verdict::does_not) << "the limit itself is not below it";
  EXPECT_EQ(below(figure(4, 3, 5), 5), Verdict::cannot_tell);
  EXPECT_EQ(above(figure(6, 5.1, 7), 5), Verdict::holds);
  EXPECT_EQ(above(figure(4, 3, 5), 5), Verdict::does_not);
  EXPECT_EQ(above(figure(6, 5, 7), 5), Verdict::cannot_tell);
  EXPECT_EQ(below(without_bounds(1), 5), Verdict::cannot_tell);
  EXPECT_EQ(above(Figure{}, 5), Verdict::cannot_tell);
  EXPECT_EQ(name_of(Verdict::does_not), "does not");
}

TEST(LargestOf, TakesTheLargestOfEachAndLeavesOpenWhatOneLeavesOpen) {
  const Figure all = largest_of({{"a", figure(3, 1, 9)}, {"b", figure(5, 4, 6)}});
  EXPECT_EQ(all.value, 5);
  EXPECT_EQ(all.low, 4);
  EXPECT_EQ(all.high, 9);
  EXPECT_EQ(all.n, 2U);
  const Figure one_unknown = largest_of({{"a", without_bounds(3)}, {"b", figure(5, 4, 6)}});
  EXPECT_EQ(one_unknown.low, 4) << "whatever the other is, the largest is no lower";
  EXPECT_EQ(one_unknown.high, std::nullopt);
  const Figure smallest = smallest_of({{"a", figure(3, 1, 9)}, {"b", without_bounds(5)}});
  EXPECT_EQ(smallest.value, 3);
  EXPECT_EQ(smallest.high, 9);
  EXPECT_EQ(smallest.low, std::nullopt);
  const Figure unmeasured = largest_of({{"a", Figure{}}, {"b", figure(5, 4, 6)}});
  EXPECT_EQ(unmeasured.high, std::nullopt) << "an object without a figure may be larger";
  EXPECT_TRUE(std::isnan(largest_of({}).value));
}

TEST(Claims, History2IsWorstOnlyIfItIsSoForEveryObject) {
  const auto holds = claim_named(
      with_histories({{2ms, runs_of(80, 81, 82)}, {20ms, runs_of(85, 90, 90)}, {40ms, runs_of(90, 84, 95)}}), "history-2-worst");
  EXPECT_NEAR(holds.measured.value, -3, 1e-9) << "usb-hub: 81 less 84";
  EXPECT_EQ(holds.measured.n, 3U);
  EXPECT_EQ(holds.verdict, Verdict::holds);
  EXPECT_NEAR(holds.objects.at("fan").value, -5, 1e-9);
  const auto not_for_one = claim_named(
      with_histories({{2ms, runs_of(80, 91, 82)}, {20ms, runs_of(85, 90, 90)}, {40ms, runs_of(90, 95, 95)}}), "history-2-worst");
  EXPECT_NEAR(not_for_one.measured.value, 1, 1e-9);
  EXPECT_EQ(not_for_one.verdict, Verdict::does_not);
}

TEST(Claims, RunsThatDisagreeLeaveItOpen) {
  auto longer = runs_of(85, 90, 90);
  longer[0] = run_of("fan", 70);  // the mean is 80
  const auto claim = claim_named(with_histories({{2ms, runs_of(79, 80, 80)}, {40ms, longer}}), "history-2-worst");
  EXPECT_NEAR(claim.measured.value, -1, 1e-9);
  EXPECT_EQ(claim.verdict, Verdict::cannot_tell);
}

TEST(Claims, OneRunOfAnObjectTellsNothingOfEveryObject) {
  const std::vector<RunConfusion> low{run_of("fan", 50), run_of("usb-hub", 50), run_of("white-box", 50)};
  const std::vector<RunConfusion> high{run_of("fan", 99), run_of("usb-hub", 99), run_of("white-box", 99)};
  const ClaimInputs inputs = with_histories({{2ms, low}, {20ms, high}, {40ms, high}});
  EXPECT_EQ(claim_named(inputs, "history-2-worst").verdict, Verdict::cannot_tell);
  EXPECT_EQ(claim_named(inputs, "accuracy-at-40").verdict, Verdict::cannot_tell);
  EXPECT_EQ(claim_named(inputs, "marginal-past-20").verdict, Verdict::holds) << "a mean over three objects";
}

TEST(Claims, BestHistoryCountsObjectsAndTheShorterOfEquals) {
  const auto claim = claim_named(
      with_histories(
          {{2ms, runs_of(50, 50, 50)}, {20ms, runs_of(90, 90, 95)}, {40ms, runs_of(90, 92, 90)}, {50ms, runs_of(80, 92, 80)}}),
      "best-history-40");
  EXPECT_NEAR(claim.measured.value, -1, 1e-9) << "40 ms: usb-hub; 20 ms: fan, which 40 ms equals, and white-box";
  EXPECT_EQ(claim.note, "20 ms is the best for 2, 40 ms is the best for 1 of 3 objects (the shorter of equals).");
  const auto all = claim_named(with_histories({{2ms, runs_of(50, 50, 50)}, {40ms, runs_of(90, 92, 90)}}), "best-history-40");
  EXPECT_NEAR(all.measured.value, 3, 1e-9);
  EXPECT_EQ(all.verdict, Verdict::holds);
}

TEST(Claims, GainsPast20AreThoseOfTheBestMean) {
  const auto claim =
      claim_named(with_histories({{20ms, runs_of(90, 90, 90)}, {40ms, runs_of(93, 93, 93)}, {50ms, runs_of(99, 80, 80)}}),
                  "marginal-past-20");
  EXPECT_NEAR(claim.measured.value, 3, 1e-9);
  EXPECT_EQ(claim.verdict, Verdict::does_not);
  EXPECT_EQ(claim_named(with_histories({{40ms, runs_of(93, 93, 93)}}), "marginal-past-20").verdict, Verdict::cannot_tell);
}

TEST(Claims, AccuracyAt40IsThatOfTheLowestObject) {
  const auto claim = claim_named(with_histories({{40ms, runs_of(99, 96, 97)}}), "accuracy-at-40");
  EXPECT_NEAR(claim.measured.value, 96, 1e-9);
  EXPECT_EQ(claim.verdict, Verdict::holds);
  EXPECT_EQ(claim_named(with_histories({{40ms, runs_of(99, 95, 97)}}), "accuracy-at-40").verdict, Verdict::does_not)
      << "95 does not exceed 95";
}

TEST(Claims, DelayIsThatOfTheSlowestObjectAndMissesKeepItFromHolding) {
  ClaimInputs inputs;
  inputs.press = {{"fan", {figure(2, 2, 2.5), 9, 0, 0}}, {"usb-hub", {figure(4, 3, 4.9), 9, 0, 0}}};
  inputs.slip = inputs.press;
  inputs.slip["fan"].misses = 1;
  EXPECT_EQ(claim_named(inputs, "press-delay").verdict, Verdict::holds);
  EXPECT_NEAR(claim_named(inputs, "press-delay").measured.value, 4, 1e-9);
  const auto slip = claim_named(inputs, "slip-delay");
  EXPECT_EQ(slip.verdict, Verdict::cannot_tell);
  EXPECT_NE(slip.note.find("Of 18 intervals 1 were missed"), std::string::npos) << slip.note;
  inputs.press["white-box"] = {figure(30, 6, 50), 9, 0, 0};
  EXPECT_EQ(claim_named(inputs, "press-delay").verdict, Verdict::does_not);
}

TEST(Claims, SlipAtOnceCountsObjectsWithoutALateMissedOrEarlySlip) {
  ClaimInputs inputs;
  inputs.tick_ms = 2;
  inputs.slip = {{"a", {without_bounds(2), 3, 0, 0}},
                 {"b", {without_bounds(2.5), 3, 0, 0}},
                 {"c", {without_bounds(2), 3, 1, 0}},
                 {"d", {without_bounds(2), 3, 0, 1}},
                 {"none", {Figure{}, 0, 0, 0}}};
  const auto claim = claim_named(inputs, "slip-at-once");
  EXPECT_NEAR(claim.measured.value, 25, 1e-9);
  EXPECT_EQ(claim.measured.n, 4U) << "an object without a slip is none of them";
  for (const char* object : {"b", "c", "d"}) inputs.slip[object] = inputs.slip["a"];
  EXPECT_EQ(claim_named(inputs, "slip-at-once").verdict, Verdict::holds);
}

TEST(Claims, BeginningAndEndOfIntervals) {
  ClaimInputs inputs;
  inputs.first = figure(0.97, 0.96, 0.98);
  inputs.last_minus_first = figure(-0.1, -0.2, -0.01);
  EXPECT_EQ(claim_named(inputs, "right-at-first").verdict, Verdict::holds);
  EXPECT_NEAR(claim_named(inputs, "right-at-first").measured.value, 97, 1e-9);
  EXPECT_EQ(claim_named(inputs, "worse-near-the-end").verdict, Verdict::holds);
  inputs.last_minus_first = figure(0.1, 0.05, 0.2);
  EXPECT_EQ(claim_named(inputs, "worse-near-the-end").verdict, Verdict::does_not);
}

TEST(Claims, PlasticContainerIsTheExceptionAndNotAmongTheOthers) {
  ClaimInputs inputs;
  for (const char* object : {"fan", "plastic-container", "small-box", "sprayer"}) {
    for (int i = 0; i < 3; ++i) {
      inputs.seen.push_back(run_of(object, 98));
      inputs.held_out.push_back(run_of(object, std::string_view(object) == "plastic-container" ? 70 : 96));
    }
  }
  const auto near = claim_named(inputs, "unseen-near-seen");
  EXPECT_NEAR(near.measured.value, -2, 1e-9);
  EXPECT_EQ(near.measured.n, 3U);
  EXPECT_FALSE(near.objects.contains("plastic-container"));
  EXPECT_EQ(near.verdict, Verdict::holds);
  const auto exception = claim_named(inputs, "unseen-plastic-container");
  EXPECT_NEAR(exception.measured.value, -28, 1e-9);
  EXPECT_EQ(exception.verdict, Verdict::holds);
  inputs.held_out = inputs.seen;
  EXPECT_EQ(claim_named(inputs, "unseen-plastic-container").verdict, Verdict::does_not);
}

TEST(Claims, OfNothingAreAllThereAndCannotBeTold) {
  const auto claims = claims_of({});
  EXPECT_EQ(claims.size(), 11U);
  for (const Claim& claim : claims) {
    EXPECT_EQ(claim.verdict, Verdict::cannot_tell) << claim.id;
    EXPECT_EQ(claim.note, "Not measured in this study.") << claim.id;
  }
  EXPECT_EQ(summary_of(claims, true), "On simulated runs 0 of the paper's 11 claims hold, 0 do not, and of 11 one cannot tell.");
}

TEST(Claims, HistoriesOfDifferentRunsAreAnError) {
  EXPECT_THROW(claims_of(with_histories({{2ms, runs_of(1, 2, 3)}, {40ms, {run_of("fan", 3)}}})), Error);
}

TEST(Claims, JsonHasWhatTheReportNeeds) {
  const nlohmann::json json = claim_named(with_histories({{40ms, runs_of(99, 96, 97)}}), "accuracy-at-40");
  EXPECT_EQ(json.at("verdict"), "holds");
  EXPECT_EQ(json.at("asked"), "above");
  EXPECT_EQ(json.at("limit"), 95);
  EXPECT_EQ(json.at("measured").at("n"), 3);
  EXPECT_EQ(json.at("objects").size(), 3U);
  EXPECT_FALSE(json.at("paper").get<std::string>().empty());
}

}  // namespace
}  // namespace tactile
