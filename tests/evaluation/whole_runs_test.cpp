#include "tactile/evaluation/whole_runs.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tactile::evaluation {
namespace {

using results::Cell;
using results::DetectionOutcome;

/// A minute outside of touches with so many alarms, and one press that is detected after some ticks of 2 ms.
Cell cell_of(std::string object, std::string run, std::uint64_t alarms, double ms,
             DetectionOutcome outcome = DetectionOutcome::detected) {
  Cell cell{{std::move(object), std::move(run)}};
  cell.outside_s = 60;
  if (alarms > 0) cell.alarms["quiet"] = alarms;
  cell.touches = {{.touch = Touch::press, .outcome = outcome, .ms = ms}};
  return cell;
}

/// Four objects with two runs each.
std::vector<Cell> eight_cells() {
  std::vector<Cell> cells;
  for (const char* object : {"box", "fan", "hub", "mug"}) {
    cells.push_back(cell_of(object, "02", 1, 4));
    cells.push_back(cell_of(object, "03", 3, 8));
  }
  return cells;
}

TEST(OperatingPoint, SumsCountsAndDividesOnce) {
  std::vector<Cell> cells = eight_cells();
  cells[0].outside_s = 180;
  cells[1].in_alarm_s = 6;
  cells[2].wrong_class = 2;
  cells[3].false_slips = 4;
  cells[4].false_slips = 0;
  const results::OperatingPoint point = operating_point(cells);
  EXPECT_EQ(point.alarms, 16U);
  EXPECT_DOUBLE_EQ(point.outside_min, 10);
  EXPECT_DOUBLE_EQ(point.alarms_per_min.value, 1.6);
  EXPECT_DOUBLE_EQ(point.in_alarm, 0.01);
  EXPECT_DOUBLE_EQ(point.wrong_class.value, 0.25);
  EXPECT_EQ(point.lifts, 2U);
  EXPECT_EQ(point.lifts_with_slip, 1U);
  EXPECT_DOUBLE_EQ(point.false_slips.value, 0.5) << "a share of lifts, not of episodes";
  EXPECT_EQ(point.median_ms.ms.value, 4);
  EXPECT_EQ(point.p90_ms.ms.value, 8);
  EXPECT_EQ(point.press_median_ms.ms.value, 4);
  EXPECT_TRUE(std::isnan(point.slip_median_ms.ms.value));
  EXPECT_EQ(point.alarms_per_min.n, 4U);
  ASSERT_TRUE(point.alarms_per_min.has_interval());
  EXPECT_LT(*point.alarms_per_min.low, 1.6);
  EXPECT_GT(*point.alarms_per_min.high, 1.6);
}

TEST(OperatingPoint, TakesWhatIsNotDetectedAsLaterThanAll) {
  std::vector<Cell> cells = eight_cells();
  for (std::size_t i = 0; i < 3; ++i) cells[i] = cell_of(cells[i].object, cells[i].run, 0, 300, DetectionOutcome::missed);
  cells[3] = cell_of(cells[3].object, cells[3].run, 0, 500, DetectionOutcome::early);
  results::OperatingPoint point = operating_point(cells);
  EXPECT_DOUBLE_EQ(point.missed.value, 0.5);
  EXPECT_EQ(point.misses, 3U);
  EXPECT_EQ(point.early, 1U);
  EXPECT_EQ(point.median_ms.ms.value, 8) << "the fourth of eight";
  EXPECT_FALSE(point.median_ms.is_lower_bound);
  EXPECT_EQ(point.p90_ms.ms.value, 500) << "no longer than it could be";
  EXPECT_TRUE(point.p90_ms.is_lower_bound);
  EXPECT_FALSE(point.p90_ms.ms.high) << "that of a limit says nothing of the delay";
}

TEST(OperatingPoint, HasNoBoundsFromTwoObjects) {
  std::vector<Cell> cells = eight_cells();
  cells.resize(4);
  const results::OperatingPoint point = operating_point(cells);
  EXPECT_FALSE(point.alarms_per_min.low || point.alarms_per_min.high);
  EXPECT_FALSE(point.missed.low || point.missed.high);
}

TEST(OperatingPoint, BoundsNoAlarmByTheirTime) {
  std::vector<Cell> cells = eight_cells();
  for (Cell& cell : cells) cell.alarms.clear();
  const results::OperatingPoint point = operating_point(cells);
  EXPECT_EQ(point.alarms_per_min.value, 0);
  ASSERT_TRUE(point.alarms_per_min.has_interval());
  EXPECT_EQ(*point.alarms_per_min.low, 0);
  EXPECT_GE(*point.alarms_per_min.high, 3.688879 / 8) << "Garwood's bound for none, in eight minutes";
}

TEST(OperatingPoint, OfOneObjectHasIntervalsOverItsRuns) {
  std::vector<Cell> cells;
  for (std::uint64_t run = 2; run < 8; ++run) cells.push_back(cell_of("fan", "0" + std::to_string(run), run % 3, 4));
  const results::Figure figure = operating_point(cells).alarms_per_min;
  EXPECT_EQ(figure.n, 6U);
  EXPECT_TRUE(figure.has_interval());
}

TEST(WholeRuns, TakeWorldsAsReplicatesWhereThereAreThree) {
  std::vector<Cell> cells;
  for (const char* world : {"7001", "7002", "7003", "7004"}) {
    for (Cell cell : eight_cells()) {
      cell.world = world;
      if (cell.world == "7004") cell.alarms["quiet"] += 8;  // worlds differ, objects do not
      cells.push_back(cell);
    }
  }
  const results::WholeRuns whole = whole_runs(cells, 1);
  EXPECT_EQ(whole.units, "worlds");
  EXPECT_EQ(whole.decided.alarms_per_min.n, 4U);
  EXPECT_EQ(whole.decided.alarms, 4 * 16U + 64U);
  const std::vector<Cell> first(cells.begin(), cells.begin() + 8);
  EXPECT_EQ(whole_runs(first, 1).units, "objects");
  const auto width = [](const results::Figure& figure) { return *figure.high - *figure.low; };
  EXPECT_GT(width(whole.decided.alarms_per_min), 4) << "three of 2 and one of 10 a minute";
}

TEST(WholeRuns, ChooseTheFirstThresholdFromWhichOnThereAreFewAlarms) {
  std::vector<Cell> cells = eight_cells();
  const auto add = [&](double threshold, std::uint64_t alarms) {
    for (Cell cell : eight_cells()) {
      cell.threshold = threshold;
      cell.alarms = {{"quiet", alarms}};
      cells.push_back(cell);
    }
  };
  add(0, 30), add(1, 1), add(2, 12), add(3, 5), add(4, 1);
  const results::WholeRuns whole = whole_runs(cells, 2);
  ASSERT_EQ(whole.curve.size(), 5U);
  ASSERT_EQ(whole.calm.size(), 4U);
  EXPECT_EQ(whole.calm[0].point->threshold, 1) << "at most 20 a minute";
  EXPECT_EQ(whole.calm[1].point->threshold, 3) << "at most 6: that a lower threshold has fewer by chance does not count";
  EXPECT_EQ(whole.calm[2].point->threshold, 4);
  EXPECT_FALSE(whole.calm[3].point);
  EXPECT_TRUE(whole.calm[0].point->alarms_per_min.has_interval());
  EXPECT_FALSE(whole.curve[0].alarms_per_min.has_interval());
}

TEST(WholeRuns, CountRunsAndCauses) {
  std::vector<Cell> cells = eight_cells();
  cells[0].by_truth = true;
  cells[1].alarms["release"] = 2;
  Cell again = cells[0];
  again.training = 1;
  cells.push_back(again);
  const results::WholeRuns whole = whole_runs(cells, 1);
  EXPECT_EQ(whole.runs.size(), 8U);
  EXPECT_EQ(whole.by_truth, std::vector<std::string>{"box/02"});
  EXPECT_EQ(whole.causes.at("release"), 2U);
  EXPECT_EQ(whole.causes.at("quiet"), 17U);
  EXPECT_EQ(whole.objects.at("fan").alarms, 4U);
  const nlohmann::json json = whole;
  const auto read = results::JsonView(json, "eval.json").get<results::WholeRuns>();
  EXPECT_EQ(nlohmann::json(read), json);
}

}  // namespace
}  // namespace tactile::evaluation
