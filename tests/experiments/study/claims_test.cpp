#include "tactile/experiments/study/claims.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tactile/core/error.hpp"
#include "tactile/experiments/study/claim_rules.hpp"

namespace tactile::study {
namespace {

/// A run with 100 samples of none, `right` of them predicted correctly.
results::RunConfusion run_of(const std::string& object, unsigned right) {
  results::RunConfusion run{{object}, {}};
  run.confusion.counts[0][0] = right;
  run.confusion.counts[0][1] = 100 - right;
  return run;
}

/// Nine runs of each of three objects, all alike.
std::vector<results::RunConfusion> runs_of(unsigned fan, unsigned hub, unsigned box) {
  std::vector<results::RunConfusion> runs;
  for (const auto& [object, right] : {std::pair("fan", fan), std::pair("usb-hub", hub), std::pair("white-box", box)}) {
    for (int i = 0; i < 9; ++i) runs.push_back(run_of(object, right));
  }
  return runs;
}

/// The same with seven more objects, like the box.
std::vector<results::RunConfusion> ten_objects(unsigned fan, unsigned hub, unsigned others) {
  std::vector<results::RunConfusion> runs = runs_of(fan, hub, others);
  for (int object = 0; object < 7; ++object) {
    for (int i = 0; i < 9; ++i) runs.push_back(run_of("box-" + std::to_string(object), others));
  }
  return runs;
}

/// A run with one press and one slip, detected after so long; 0: missed, below: early.
results::RunDetections met(const std::string& object, int press_ms, int slip_ms) {
  results::RunDetections run{{object}, {}};
  for (const auto& [touch, delay_ms] : {std::pair(Touch::press, press_ms), std::pair(Touch::slip, slip_ms)}) {
    results::Detection detection;
    detection.interval.touch = touch;
    detection.outcome = delay_ms > 0    ? results::DetectionOutcome::detected
                        : delay_ms == 0 ? results::DetectionOutcome::missed
                                        : results::DetectionOutcome::early;
    detection.delay = microseconds{1000 * std::max(delay_ms, 0)};
    detection.limit = 500ms;
    run.detections.push_back(detection);
  }
  return run;
}

results::Figure figure(double value, double low, double high) { return {value, low, high, 3}; }
results::Figure without_bounds(double value) { return {value, {}, {}, 1}; }

/// The same results of each of five trainings; a claim needs as many.
template <class Run>
std::vector<Run> of_five_trainings(const std::vector<Run>& runs) {
  std::vector<Run> all;
  for (std::size_t training = 0; training < 5; ++training) {
    std::map<std::string, int> count;
    for (Run run : runs) {
      run.run = std::to_string(++count[run.object]);
      run.training = training;
      all.push_back(run);
    }
  }
  return all;
}

results::Claim claim_of_one_training(const ClaimInputs& inputs, const std::string& id) {
  const auto claims = claims_of(inputs);
  const auto found = std::find_if(claims.begin(), claims.end(), [&](const results::Claim& claim) { return claim.id == id; });
  if (found == claims.end()) throw Error(id + ": no such claim");
  return *found;
}

results::Claim claim_named(ClaimInputs inputs, const std::string& id) {
  for (auto& [history, runs] : inputs.histories) runs = of_five_trainings(runs);
  inputs.detections = of_five_trainings(inputs.detections);
  inputs.seen = of_five_trainings(inputs.seen);
  inputs.held_out = of_five_trainings(inputs.held_out);
  inputs.over_time.first.trainings = inputs.over_time.last_minus_before.trainings = 5;
  return claim_of_one_training(inputs, id);
}

ClaimInputs with_histories(std::map<microseconds, std::vector<results::RunConfusion>> histories) {
  ClaimInputs inputs;
  inputs.histories = std::move(histories);
  return inputs;
}

TEST(Outcome, IsGivenOnlyIfTheWholeIntervalLiesOnOneSide) {
  EXPECT_EQ(below(figure(3, 2, 4), 5), results::Outcome::holds);
  EXPECT_EQ(below(figure(6, 5.1, 7), 5), results::Outcome::does_not);
  EXPECT_EQ(below(figure(6, 5, 7), 5), results::Outcome::cannot_tell) << "a bound at the limit is on neither side";
  EXPECT_EQ(below(figure(4, 3, 5), 5), results::Outcome::cannot_tell);
  EXPECT_EQ(above(figure(6, 5.1, 7), 5), results::Outcome::holds);
  EXPECT_EQ(above(figure(4, 3, 4.9), 5), results::Outcome::does_not);
  EXPECT_EQ(above(figure(4, 3, 5), 5), results::Outcome::cannot_tell);
  EXPECT_EQ(above(figure(6, 5, 7), 5), results::Outcome::cannot_tell);
  EXPECT_EQ(below(without_bounds(1), 5), results::Outcome::cannot_tell);
  EXPECT_EQ(above(results::Figure{}, 5), results::Outcome::cannot_tell);
  EXPECT_EQ(name_of(results::Outcome::does_not), "does not");
}

TEST(LargestOf, TakesTheLargestOfEachAndLeavesOpenWhatOneLeavesOpen) {
  const auto same = [](const std::map<std::string, results::Figure>& objects) { return ObjectFigures{objects, objects}; };
  const results::Figure all = largest_of(same({{"a", figure(3, 1, 9)}, {"b", figure(5, 4, 6)}}));
  EXPECT_EQ(all.value, 5);
  EXPECT_EQ(all.low, 4);
  EXPECT_EQ(all.high, 9);
  EXPECT_EQ(all.n, 2U);
  const results::Figure one_unknown = largest_of(same({{"a", without_bounds(3)}, {"b", figure(5, 4, 6)}}));
  EXPECT_EQ(one_unknown.low, 4) << "whatever the other is, the largest is no lower";
  EXPECT_EQ(one_unknown.high, std::nullopt);
  const results::Figure smallest = smallest_of(same({{"a", figure(3, 1, 9)}, {"b", without_bounds(5)}}));
  EXPECT_EQ(smallest.value, 3);
  EXPECT_EQ(smallest.high, 9);
  EXPECT_EQ(smallest.low, std::nullopt);
  const results::Figure unmeasured = largest_of(same({{"a", results::Figure{}}, {"b", figure(5, 4, 6)}}));
  EXPECT_EQ(unmeasured.high, std::nullopt) << "an object without a figure may be larger";
  EXPECT_TRUE(std::isnan(largest_of({}).value));
}

TEST(LargestOf, AllowsForManyLooksWhereOneObjectDecides) {
  const results::Figure all =
      largest_of({{{"a", figure(6, 5.5, 7)}, {"b", figure(5, 4, 8)}}, {{"a", figure(6, 4.5, 7.5)}, {"b", figure(5, 3, 9)}}});
  EXPECT_EQ(all.low, 4.5) << "of the wide interval";
  EXPECT_EQ(all.high, 8) << "of the objects' own";
  EXPECT_EQ(below(all, 5), results::Outcome::cannot_tell);
}

TEST(Claims, History2IsWorstOnlyIfItIsSoForEveryObject) {
  const auto holds = claim_named(
      with_histories({{2ms, runs_of(80, 81, 82)}, {20ms, runs_of(85, 90, 90)}, {40ms, runs_of(90, 84, 95)}}), "history-2-worst");
  EXPECT_NEAR(holds.measured.value, -3, 1e-9) << "usb-hub: 81 less 84";
  EXPECT_EQ(holds.measured.n, 3U);
  EXPECT_EQ(holds.outcome, results::Outcome::holds);
  EXPECT_NEAR(holds.objects.at("fan").value, -5, 1e-9);
  const auto not_for_one = claim_named(
      with_histories({{2ms, runs_of(80, 91, 82)}, {20ms, runs_of(85, 90, 90)}, {40ms, runs_of(90, 95, 95)}}), "history-2-worst");
  EXPECT_NEAR(not_for_one.measured.value, 1, 1e-9);
  EXPECT_EQ(not_for_one.outcome, results::Outcome::does_not);
  EXPECT_EQ(not_for_one.in_words,
            "2 ms is the worst for 2 of 3 objects; furthest off: usb-hub, where another history is 1.00 points worse.");
  EXPECT_EQ(holds.in_words, "2 ms is the worst for 3 of 3 objects; least so: usb-hub, where it is 3.00 points below the next.");
  const auto tied = claim_named(with_histories({{2ms, runs_of(80, 80, 80)}, {40ms, runs_of(80, 90, 90)}}), "history-2-worst");
  EXPECT_EQ(tied.outcome, results::Outcome::cannot_tell) << "a tie is on neither side";
  EXPECT_EQ(tied.kept, 2U);
}

TEST(Claims, NeedFiveTrainings) {
  const ClaimInputs inputs =
      with_histories({{2ms, runs_of(80, 81, 82)}, {20ms, runs_of(85, 90, 90)}, {40ms, runs_of(90, 84, 95)}});
  const auto claim = claim_of_one_training(inputs, "history-2-worst");
  EXPECT_EQ(claim.outcome, results::Outcome::cannot_tell);
  EXPECT_EQ(claim.why, "too few trainings: 1, 5 needed");
  EXPECT_FALSE(claim.can_be_decided);
}

TEST(Claims, ReportHowMuchMoreWouldDecide) {
  results::Claim claim;
  claim.scope = results::ClaimScope::over_objects;
  claim.limit = 5;
  claim.measured = {.value = 4, .low = 2, .high = 6, .n = 10, .trainings = 5};  // twice as wide as decides; counts by SciPy's t
  judge(claim);
  EXPECT_EQ(claim.why, "the interval lies across the limit; if the value stays, about 13 trainings and 33 objects would decide");
  claim.measured.value = 4.9;
  judge(claim);
  EXPECT_EQ(claim.why,
            "the interval lies across the limit; the value is so near the limit that 20 times the data would not decide");
  claim.scope = results::ClaimScope::one_object;
  claim.measured = {.value = 6, .low = 4.5, .high = 8, .n = 7, .trainings = 5};
  judge(claim);
  EXPECT_EQ(claim.why,
            "the interval lies across the limit; if the value stays, about 9 trainings and 13 runs of each object would decide");
}

TEST(Claims, RunsThatDisagreeLeaveItOpen) {
  auto longer = runs_of(85, 90, 90);
  for (std::size_t i : {0U, 1U, 2U}) longer[i] = run_of("fan", 70);  // the mean of nine is 80
  const auto claim = claim_named(with_histories({{2ms, runs_of(79, 80, 80)}, {40ms, longer}}), "history-2-worst");
  EXPECT_NEAR(claim.measured.value, -1, 1e-9);
  EXPECT_EQ(claim.outcome, results::Outcome::cannot_tell);
  EXPECT_EQ(claim.why,
            "the interval lies across the limit; the value is so near the limit that 20 times the data would not decide");
  EXPECT_TRUE(claim.can_be_decided);
}

TEST(Claims, OfManyObjectsOneThatIsBarelyBeyondTheLimitDecidesNothing) {
  // At 2 ms five of the fan's six runs are better: their 95 % interval lies above 0, that for ten looks does not.
  std::vector<results::RunConfusion> at_2, at_40;
  const auto add = [&](const std::string& object, unsigned right_at_2, unsigned right_at_40) {
    at_2.push_back(run_of(object, right_at_2));
    at_40.push_back(run_of(object, right_at_40));
  };
  for (const unsigned gain : {14U, 12U, 10U, 8U, 6U}) add("fan", 60 + gain, 60);
  add("fan", 45, 60);
  EXPECT_EQ(claim_named(with_histories({{2ms, at_2}, {40ms, at_40}}), "history-2-worst").outcome, results::Outcome::cannot_tell);
  at_2.back() = run_of("fan", 60);
  EXPECT_EQ(claim_named(with_histories({{2ms, at_2}, {40ms, at_40}}), "history-2-worst").outcome, results::Outcome::does_not)
      << "one look";
  for (int object = 0; object < 9; ++object) {
    for (int i = 0; i < 3; ++i) add("object-" + std::to_string(object), 50, 90);
  }
  const auto of_ten = claim_named(with_histories({{2ms, at_2}, {40ms, at_40}}), "history-2-worst");
  EXPECT_GT(*of_ten.objects.at("fan").low, 0) << "its own interval";
  EXPECT_LT(*of_ten.measured.low, 0) << "ten looks";
  EXPECT_EQ(of_ten.outcome, results::Outcome::cannot_tell);
}

TEST(Claims, OneRunOfAnObjectDecidesNothingAboutEveryObject) {
  const std::vector<results::RunConfusion> low{run_of("fan", 50), run_of("usb-hub", 50), run_of("white-box", 50)};
  const std::vector<results::RunConfusion> high{run_of("fan", 99), run_of("usb-hub", 99), run_of("white-box", 99)};
  const ClaimInputs inputs = with_histories({{2ms, low}, {20ms, high}, {40ms, high}});
  EXPECT_EQ(claim_named(inputs, "history-2-worst").outcome, results::Outcome::cannot_tell);
  EXPECT_EQ(claim_named(inputs, "accuracy-at-40").outcome, results::Outcome::cannot_tell);
  EXPECT_EQ(claim_named(inputs, "history-2-worst").why, "too few runs: 1 each, 3 needed");
  EXPECT_FALSE(claim_named(inputs, "history-2-worst").can_be_decided);
  EXPECT_EQ(claim_named(inputs, "marginal-past-20").outcome, results::Outcome::cannot_tell);
  EXPECT_EQ(claim_named(inputs, "marginal-past-20").why, "too few objects: 3, 5 needed");
  std::vector<results::RunConfusion> some = runs_of(50, 50, 50);
  some.resize(some.size() - 7);
  EXPECT_EQ(claim_named(with_histories({{2ms, some}, {40ms, some}}), "history-2-worst").why,
            "too few runs of white-box: 2, 3 needed of each object");
}

TEST(Claims, BestHistoryCountsObjectsAndTheShorterOfEquals) {
  const auto claim = claim_named(
      with_histories(
          {{2ms, runs_of(50, 50, 50)}, {20ms, runs_of(90, 90, 95)}, {40ms, runs_of(90, 92, 90)}, {50ms, runs_of(80, 92, 80)}}),
      "best-history-40");
  EXPECT_NEAR(claim.measured.value, -1, 1e-9) << "40 ms: usb-hub; 20 ms: fan, which 40 ms equals, and white-box";
  EXPECT_EQ(claim.in_words, "40 ms is the best for 1 of 3 objects; 20 ms for 2 (of equals, the shortest).");
  EXPECT_EQ(claim.kept, 1U);
  const auto all =
      claim_named(with_histories({{2ms, ten_objects(50, 50, 50)}, {40ms, ten_objects(90, 92, 90)}}), "best-history-40");
  EXPECT_NEAR(all.measured.value, 10, 1e-9);
  EXPECT_EQ(all.outcome, results::Outcome::holds);
}

TEST(Claims, NoHistoryIsTheBestOfThoseThatWereNotTrained) {
  ClaimInputs inputs = with_histories({{20ms, ten_objects(50, 50, 50)}, {40ms, ten_objects(90, 92, 90)}});
  ASSERT_EQ(claim_named(inputs, "best-history-40").outcome, results::Outcome::holds);
  inputs.untrained = {2ms, 50ms};
  const auto open = claim_named(inputs, "best-history-40");
  EXPECT_EQ(open.outcome, results::Outcome::cannot_tell);
  EXPECT_EQ(open.why, "no model was trained for 2, 50 ms, which the paper compares");
  EXPECT_EQ(claim_named(inputs, "marginal-past-20").outcome, results::Outcome::does_not) << "one history suffices for that";
}

TEST(Claims, LongerHistoriesAreBetterIfEachStepUpTo20Is) {
  const auto better = claim_named(
      with_histories({{2ms, ten_objects(80, 90, 90)}, {10ms, ten_objects(85, 88, 93)}, {20ms, ten_objects(87, 90, 95)}}),
      "longer-is-better");
  EXPECT_NEAR(better.measured.value, (2 + 2 + 8 * 2) / 10.0, 1e-9) << "the second step";
  EXPECT_EQ(better.in_words, "The mean over 10 objects is 89.00 % at 2 ms, 91.70 % at 10 ms, 93.70 % at 20 ms.");
  EXPECT_EQ(better.outcome, results::Outcome::holds);
  ClaimInputs worse = with_histories({{2ms, ten_objects(80, 80, 80)},
                                      {10ms, ten_objects(85, 86, 84)},
                                      {20ms, ten_objects(84, 85, 83)},
                                      {40ms, ten_objects(99, 99, 99)}});
  EXPECT_NEAR(claim_named(worse, "longer-is-better").measured.value, -1, 1e-9);
  EXPECT_EQ(claim_named(worse, "longer-is-better").outcome, results::Outcome::does_not) << "though 20 ms is better than 2 ms";
  EXPECT_EQ(claim_named(with_histories({{2ms, ten_objects(1, 1, 1)}, {40ms, ten_objects(9, 9, 9)}}), "longer-is-better").note,
            "Not measured in this study.")
      << "the paper's improvement is up to 20 ms";
}

TEST(Claims, ALongerHistoryThatWasNotTrainedLeavesOpenOnlyTheClaimsOnIt) {
  ClaimInputs inputs = with_histories({{2ms, ten_objects(80, 80, 80)}, {20ms, ten_objects(90, 90, 90)}});
  inputs.untrained = {40ms};
  EXPECT_EQ(claim_named(inputs, "longer-is-better").outcome, results::Outcome::holds);
  inputs.untrained = {10ms, 40ms};
  EXPECT_EQ(claim_named(inputs, "longer-is-better").why, "no model was trained for 10 ms, which the paper compares");
}

TEST(Claims, GainsPast20AreThoseOfTheBestMean) {
  const auto claim = claim_named(
      with_histories({{20ms, ten_objects(90, 90, 90)}, {40ms, ten_objects(93, 93, 93)}, {50ms, ten_objects(99, 80, 80)}}),
      "marginal-past-20");
  EXPECT_NEAR(claim.measured.value, 3, 1e-9);
  EXPECT_EQ(claim.in_words, "The mean over 10 objects is 90.00 % at 20 ms, and past that 93.00 % at best, at 40 ms.");
  EXPECT_EQ(claim.outcome, results::Outcome::does_not);
  EXPECT_EQ(claim_named(with_histories({{40ms, runs_of(93, 93, 93)}}), "marginal-past-20").outcome,
            results::Outcome::cannot_tell);
}

TEST(Claims, AccuracyAt40IsThatOfTheLowestObject) {
  const auto claim = claim_named(with_histories({{40ms, runs_of(99, 96, 97)}}), "accuracy-at-40");
  EXPECT_NEAR(claim.measured.value, 96, 1e-9);
  EXPECT_EQ(claim.outcome, results::Outcome::holds);
  EXPECT_EQ(claim_named(with_histories({{40ms, runs_of(99, 95, 97)}}), "accuracy-at-40").outcome, results::Outcome::cannot_tell)
      << "95 is on neither side of 95";
  const auto low = claim_named(with_histories({{40ms, runs_of(99, 94, 97)}}), "accuracy-at-40");
  EXPECT_EQ(low.outcome, results::Outcome::does_not);
  EXPECT_EQ(low.why, "");
  EXPECT_EQ(low.in_words, "Above 95 % for 2 of 3 objects; the lowest is usb-hub with 94.00 %.");
}

TEST(Claims, DelayIsThatOfTheSlowestObjectAndMissesKeepItFromHolding) {
  ClaimInputs inputs;
  for (int i = 0; i < 9; ++i) inputs.detections.insert(inputs.detections.end(), {met("fan", 2, 2), met("usb-hub", 4, 4)});
  inputs.detections.push_back(met("fan", 2, 0));
  EXPECT_EQ(claim_named(inputs, "press-delay").outcome, results::Outcome::holds);
  EXPECT_NEAR(claim_named(inputs, "press-delay").measured.value, 4, 1e-9);
  EXPECT_EQ(claim_named(inputs, "press-delay").in_words, "Below 5 ms for 2 of 2 objects; the slowest is usb-hub with 4.00 ms.");
  const auto slip = claim_named(inputs, "slip-delay");
  EXPECT_EQ(slip.outcome, results::Outcome::cannot_tell);
  EXPECT_EQ(slip.why, "some intervals have no delay; of the others the claim would hold");
  EXPECT_NE(slip.note.find("Of 95 intervals (of 5 trainings) 5 were missed"), std::string::npos) << slip.note;
  for (int i = 0; i < 9; ++i) inputs.detections.push_back(met("white-box", 30, 2));
  EXPECT_EQ(claim_named(inputs, "press-delay").outcome, results::Outcome::does_not);
}

TEST(Claims, AboutEveryObjectDoNotHoldWhereTheMeanOverTheseIsBeyondTheLimit) {
  ClaimInputs inputs;
  const auto add_object = [&](const std::string& name, int middle_ms) {
    for (const int more : {-2, 0, 2}) inputs.detections.push_back(met(name, middle_ms + more, 2));
  };
  for (int object = 0; object < 10; ++object) add_object("box-" + std::to_string(object), 8);
  const auto claim = claim_named(inputs, "press-delay");
  EXPECT_LT(*claim.measured.low, 5) << "three runs of no object are enough by themselves";
  EXPECT_EQ(claim.outcome, results::Outcome::does_not);
  EXPECT_EQ(claim.why, "");
  // The standard error is sqrt(4 / 3 / 10) ms, t of 20 degrees 2.42, the limit 500 ms: as of 19314 trials. From SciPy.
  EXPECT_NEAR(*claim.mean.low, 7.138835046954575, 1e-6);
  EXPECT_NEAR(*claim.mean.high, 8.935087199186478, 1e-6);
  EXPECT_EQ(
      claim.in_words,
      "Below 5 ms for 0 of 10 objects; the slowest is box-0 with 8.00 ms. It does not hold because of the mean over these 10 "
      "objects: 8.00 ms [7.14, 8.94].");

  // A mean that is on the claimed side says nothing of one object that may not be.
  for (auto& run : inputs.detections) {
    for (auto& detection : run.detections) detection.delay -= run.object == "box-0" ? 0ms : 4ms;
  }
  EXPECT_EQ(claim_named(inputs, "press-delay").outcome, results::Outcome::cannot_tell);
}

TEST(Claims, SlipAtOnceCountsObjectsWithoutALateMissedOrEarlySlip) {
  ClaimInputs inputs;
  inputs.tick_ms = 2;
  inputs.detections = {met("a", 9, 2), met("b", 2, 4), met("c", 2, 0), met("d", 2, -1), met("e", 2, 2), {{"none"}, {}}};
  auto claim = claim_named(inputs, "slip-at-once");
  EXPECT_NEAR(claim.measured.value, 40, 1e-9);
  EXPECT_EQ(claim.measured.n, 5U) << "an object without a slip is none of them";
  EXPECT_EQ(claim.in_words, "Every slip was detected at its first tick for 2 of 5 objects.");
  for (const char* object : {"f", "g", "h", "i", "j"}) inputs.detections.push_back(met(object, 2, 2));
  for (results::RunDetections& run : inputs.detections) {
    if (run.object != "none") run = met(run.object, 2, 2);
  }
  EXPECT_EQ(claim_named(inputs, "slip-at-once").outcome, results::Outcome::holds);
}

TEST(Claims, SlipAtOnceHasTheExactIntervalOverObjects) {
  // Each object has one late slip of three: none has all at once.
  ClaimInputs inputs;
  for (const char* object : {"a", "b", "c", "d", "e"})
    inputs.detections.insert(inputs.detections.end(), {met(object, 2, 2), met(object, 2, 2), met(object, 2, 8)});
  const auto claim = claim_named(inputs, "slip-at-once");
  EXPECT_EQ(claim.measured.value, 0);
  EXPECT_EQ(claim.measured.low, 0);
  EXPECT_NEAR(*claim.measured.high, 52.18, 0.01) << "1 - 0.025^(1/5)";
}

TEST(Claims, BeginningAndEndOfIntervals) {
  const auto of_five = [](double value, double low, double high) { return results::Figure{value, low, high, 5}; };
  ClaimInputs inputs;
  inputs.history_ms = 30;
  inputs.over_time = {.first = of_five(0.97, 0.96, 0.98),
                      .last_minus_before = of_five(-0.1, -0.2, -0.01),
                      .still_predicted = of_five(0.35, 0.3, 0.4),
                      .intervals = 20,
                      .short_ones = 12};
  EXPECT_EQ(claim_named(inputs, "right-at-first").outcome, results::Outcome::holds);
  EXPECT_NEAR(claim_named(inputs, "right-at-first").measured.value, 97, 1e-9);
  const auto end = claim_named(inputs, "worse-near-the-end");
  EXPECT_EQ(end.outcome, results::Outcome::holds);
  EXPECT_NE(end.in_words.find("10.00 points lower than before"), std::string::npos) << end.in_words;
  EXPECT_NE(end.in_words.find("8 of 20 intervals; 12 have no tick before"), std::string::npos) << end.in_words;
  EXPECT_NE(end.note.find("in the 100 ms after an interval 35.0 %"), std::string::npos) << end.note;
  EXPECT_NE(end.note.find("which looks 30 ms back"), std::string::npos) << end.note;
  inputs.over_time.last_minus_before = of_five(0.1, 0.05, 0.2);
  EXPECT_EQ(claim_named(inputs, "worse-near-the-end").outcome, results::Outcome::does_not);
  inputs.over_time.last_minus_before.n = 4;
  EXPECT_EQ(claim_named(inputs, "worse-near-the-end").outcome, results::Outcome::cannot_tell);
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
  EXPECT_EQ(near.outcome, results::Outcome::holds);
  ClaimInputs one_far = inputs;
  for (results::RunConfusion& run : one_far.held_out) {
    if (run.object == "sprayer") run = run_of("sprayer", 90);
  }
  const auto far = claim_named(one_far, "unseen-near-seen");
  EXPECT_EQ(far.outcome, results::Outcome::does_not) << "the mean is -4";
  EXPECT_EQ(far.in_words, "Less than 5 points are lost for 2 of 3 objects; sprayer loses most, 8.00 points.");
  EXPECT_NE(far.note.find("-4.00 points"), std::string::npos) << far.note;
  const auto exception = claim_named(inputs, "unseen-plastic-container");
  EXPECT_NEAR(exception.measured.value, -28, 1e-9);
  EXPECT_EQ(exception.outcome, results::Outcome::holds);
  const auto one_of_two = claim_named(one_far, "unseen-plastic-container");
  EXPECT_EQ(one_of_two.outcome, results::Outcome::does_not) << "sprayer loses 8 points: there are two exceptions";
  EXPECT_NE(one_of_two.why.find("does not"), std::string::npos) << one_of_two.why;
  inputs.held_out = inputs.seen;
  EXPECT_EQ(claim_named(inputs, "unseen-plastic-container").outcome, results::Outcome::does_not);
}

TEST(Claims, UnseenObjectsAreWorseInTheMeanAndNoneIsAbove95) {
  ClaimInputs inputs;
  const std::map<std::string, std::pair<unsigned, unsigned>> seen_and_held_out{{"fan", {98, 91}},
                                                                               {"plastic-container", {98, 88}},
                                                                               {"small-box", {99, 94}},
                                                                               {"sprayer", {97, 93}},
                                                                               {"textured-box", {98, 92}}};
  for (const auto& [object, right] : seen_and_held_out) {
    for (int i = 0; i < 3; ++i) {
      inputs.seen.push_back(run_of(object, right.first));
      inputs.held_out.push_back(run_of(object, right.second));
    }
  }
  const auto better = claim_named(inputs, "seen-better");
  EXPECT_NEAR(better.measured.value, (7 + 10 + 5 + 4 + 6) / 5.0, 1e-9) << "the exception is one of the objects";
  EXPECT_EQ(better.measured.n, 5U);
  const results::Figure gain = evaluation::accuracy_difference(inputs.held_out, inputs.seen).mean;
  EXPECT_NEAR(*better.measured.low, 100 * *gain.low, 1e-10);
  EXPECT_NEAR(*better.measured.high, 100 * *gain.high, 1e-10);
  EXPECT_EQ(better.in_words, "In training 5 of 5 objects are classified better; the mean gains 6.40 points.");
  EXPECT_EQ(better.outcome, results::Outcome::holds);
  const auto accurate = claim_named(inputs, "unseen-accurate");
  EXPECT_EQ(accurate.in_words, "Above 95 % for 0 of 4 objects; the lowest is fan with 91.00 %.");
  EXPECT_FALSE(accurate.objects.contains("plastic-container"));
  EXPECT_NE(accurate.note.find("95 % for objects in training"), std::string::npos) << accurate.note;
  EXPECT_EQ(accurate.outcome, results::Outcome::does_not);
  for (results::RunConfusion& run : inputs.held_out) run = run_of(run.object, run.object == "plastic-container" ? 70 : 99);
  EXPECT_EQ(claim_named(inputs, "unseen-accurate").outcome, results::Outcome::holds);
  EXPECT_EQ(claim_named(inputs, "seen-better").outcome, results::Outcome::cannot_tell) << "one of five objects is worse";
}

TEST(Claims, OfNoInputsAreAllPresentAndCannotTell) {
  const auto claims = claims_of({});
  EXPECT_EQ(claims.size(), 14U);
  for (const results::Claim& claim : claims) {
    EXPECT_EQ(claim.outcome, results::Outcome::cannot_tell) << claim.id;
    EXPECT_EQ(claim.note, "Not measured in this study.") << claim.id;
  }
  EXPECT_EQ(
      summary_of(claims, true),
      "On simulated runs 0 of the paper's 14 claims hold, 0 do not, and 14 cannot be decided: for 14 of them there are too few "
      "trainings, runs or objects.");
}

TEST(Claims, HistoriesOfDifferentRunsAreAnError) {
  EXPECT_THROW(claims_of(with_histories({{2ms, runs_of(1, 2, 3)}, {40ms, {run_of("fan", 3)}}})), Error);
}

}  // namespace
}  // namespace tactile::study
