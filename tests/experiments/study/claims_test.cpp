#include "tactile/experiments/study/claims.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tactile::study {
namespace {

using results::Cell;
using results::Outcome;

constexpr microseconds forty{40'000};

/// `right` of 1000 balanced samples.
Cell cell_of(const std::string& world, const std::string& object, const std::string& setting, std::uint64_t right) {
  Cell cell{{object, "02", 0, world}};
  cell.setting = setting;
  for (std::uint64_t i = 0; i < 1000; ++i) cell.samples.add(Touch::press, i < right ? Touch::press : Touch::none);
  return cell;
}

void add_touch(Cell& cell, Touch touch, double ms) {
  cell.touches.push_back({.touch = touch, .outcome = results::DetectionOutcome::detected, .ms = ms});
}

/// A world in which the paper's sentences are true of two objects and the plastic container.
std::vector<Cell> as_the_paper_has_it(const std::string& world) {
  std::vector<Cell> cells;
  for (const char* object : {"box", "fan", "plastic-container"}) {
    for (const auto& [setting, right] :
         {std::pair("th002", 800U), std::pair("th010", 900U), std::pair("th020", 965U), std::pair("th040", 970U)})
      cells.push_back(cell_of(world, object, setting, right));
    Cell& main = cells.back();
    add_touch(main, Touch::press, 2);
    add_touch(main, Touch::slip, 2);
    main.first = {100, 98};
    main.before_last = {100, 90};
    main.last = {100, 70};
    cells.push_back(cell_of(world, object, "th040-unseen", object == std::string("plastic-container") ? 600 : 960));
  }
  return cells;
}

std::vector<Cell> worlds_of(std::vector<Cell> (*world)(const std::string&), int count) {
  std::vector<Cell> cells;
  for (int i = 0; i < count; ++i) {
    for (Cell& cell : world(std::to_string(500 + i))) cells.push_back(std::move(cell));
  }
  return cells;
}

results::Claim claim_of(const std::vector<results::Claim>& claims, const std::string& id) {
  const auto found = std::find_if(claims.begin(), claims.end(), [&](const results::Claim& claim) { return claim.id == id; });
  EXPECT_NE(found, claims.end()) << id;
  return found == claims.end() ? results::Claim{} : *found;
}

TEST(Claims, HoldWhereAllOfFiveWorldsWriteThem) {
  const auto claims = claims_of(worlds_of(as_the_paper_has_it, 5), forty);
  ASSERT_EQ(claims.size(), 14U);
  for (const results::Claim& claim : claims) {
    EXPECT_EQ(claim.written, 5U) << claim.id;
    EXPECT_EQ(claim.replicates, 5U) << claim.id;
    // Five of five: the one-sided bound is 0.05^(1/5) = 0.55. A margin needs an interval, which equal worlds do not have.
    EXPECT_EQ(claim.outcome, claim.is_by_margin ? Outcome::cannot_tell : Outcome::holds) << claim.id;
  }
  EXPECT_DOUBLE_EQ(claim_of(claims, "accuracy-at-40").measured.value, 97);
  EXPECT_DOUBLE_EQ(claim_of(claims, "longer-is-better").measured.value, 6.5) << "the smaller of 10 and 6.5";
  EXPECT_DOUBLE_EQ(claim_of(claims, "best-history-40").measured.value, 3) << "objects";
  EXPECT_DOUBLE_EQ(claim_of(claims, "press-delay").measured.value, 2);
  EXPECT_DOUBLE_EQ(claim_of(claims, "worse-near-the-end").measured.value, -20);
  EXPECT_DOUBLE_EQ(claim_of(claims, "seen-better").measured.value, (1.0 + 1 + 37) / 3);
  EXPECT_DOUBLE_EQ(claim_of(claims, "unseen-plastic-container").measured.value, 36) << "37 points against 1";
}

TEST(Claims, CannotBeToldFromFourWorldsAndDoNotHoldWhereNoneOfFiveWritesThem) {
  EXPECT_EQ(claim_of(claims_of(worlds_of(as_the_paper_has_it, 4), forty), "press-delay").outcome, Outcome::cannot_tell);
  std::vector<Cell> slow = worlds_of(as_the_paper_has_it, 5);
  for (Cell& cell : slow) {
    for (results::TouchOutcome& touch : cell.touches) touch.ms = cell.object == "fan" ? 6 : 2;
  }
  const results::Claim claim = claim_of(claims_of(slow, forty), "press-delay");
  EXPECT_EQ(claim.written, 0U) << "one slow object is enough";
  EXPECT_EQ(claim.outcome, Outcome::does_not);
  EXPECT_DOUBLE_EQ(claim.measured.value, 6);
}

TEST(Claims, OfMarginsAreDecidedByTheirInterval) {
  std::vector<Cell> cells = worlds_of(as_the_paper_has_it, 5);
  // Unseen objects lose 1, 2, 1, 2, 1 points: within five.
  const auto lose = [&](std::uint64_t least) {
    for (Cell& cell : cells) {
      if (cell.setting != "th040-unseen" || cell.object == "plastic-container") continue;
      const auto more = static_cast<std::uint64_t>(cell.world.back() - '0') % 2;
      cell = cell_of(cell.world, cell.object, "th040-unseen", 970 - 10 * (least + more));
    }
    return claim_of(claims_of(cells, forty), "unseen-near-seen");
  };
  const results::Claim near = lose(1);
  EXPECT_DOUBLE_EQ(near.measured.value, 1.4);
  ASSERT_TRUE(near.measured.has_interval());
  EXPECT_LT(*near.measured.high, 5);
  EXPECT_EQ(near.outcome, Outcome::holds);
  EXPECT_EQ(lose(8).outcome, Outcome::does_not);
  EXPECT_EQ(lose(4).outcome, Outcome::cannot_tell) << "4 or 5 points";
}

TEST(Claims, WithoutTheirSettingsAreNotMeasured) {
  std::vector<Cell> cells = worlds_of(as_the_paper_has_it, 3);
  std::erase_if(cells, [](const Cell& cell) { return cell.setting == "th002" || cell.setting.ends_with("-unseen"); });
  const auto claims = claims_of(cells, forty);
  for (const char* id : {"history-2-worst", "longer-is-better", "seen-better", "unseen-accurate", "unseen-plastic-container"}) {
    EXPECT_EQ(claim_of(claims, id).replicates, 0U) << id;
    EXPECT_TRUE(std::isnan(claim_of(claims, id).measured.value)) << id;
    EXPECT_EQ(claim_of(claims, id).outcome, Outcome::cannot_tell) << id;
  }
  EXPECT_EQ(claim_of(claims, "accuracy-at-40").replicates, 3U);
}

TEST(Claims, TakeTheVerdictsAsTheyWereDecidedAlone) {
  std::vector<Cell> cells = worlds_of(as_the_paper_has_it, 5);
  Cell of_curve = cells.front(), confirmed = of_curve, stream = of_curve;
  of_curve.threshold = 3;
  confirmed.confirmed = true;
  stream.setting = "stream";
  for (Cell* other : {&of_curve, &confirmed, &stream}) {
    add_touch(*other, Touch::press, 400);
    cells.push_back(*other);
  }
  EXPECT_DOUBLE_EQ(claim_of(claims_of(cells, forty), "press-delay").measured.value, 2);
}

TEST(Claims, AreTestedOnEachTrainingOfOneWorld) {
  std::vector<Cell> cells;
  for (std::size_t training = 0; training < 5; ++training) {
    for (Cell& cell : as_the_paper_has_it("")) {
      cell.training = training;
      if (training == 4 && cell.setting == "th040") cell.touches.front().ms = 20;
      cells.push_back(std::move(cell));
    }
  }
  const results::Claim claim = claim_of(claims_of(cells, forty), "press-delay");
  EXPECT_EQ(claim.replicates, 5U);
  EXPECT_EQ(claim.written, 4U);
  EXPECT_EQ(claim.outcome, Outcome::cannot_tell) << "four of five";
}

TEST(Claims, AreCountedInASentence) {
  const auto claims = claims_of(worlds_of(as_the_paper_has_it, 5), forty);
  EXPECT_EQ(summary_of(claims, true),
            "Of the paper's 14 sentences 12 would usually be written on simulated runs, 0 seldom; of 2 this study cannot tell.");
}

}  // namespace
}  // namespace tactile::study
