#include "tactile/model/bundle/gate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

namespace tactile::model {
namespace {

using namespace std::chrono_literals;

TEST(Gate, TakesNoMorePressesAndSlipsForNoneThanItsShare) {
  std::vector<std::uint64_t> counts(5'000);
  std::iota(counts.rbegin(), counts.rend(), std::uint64_t{100});  // 100, 101, … in no order of ticks
  const Gate gate = calibrated_gate(counts);
  EXPECT_EQ(gate.limit, 105U) << "5 of 5000 lie below";
  EXPECT_EQ(gate.ticks, 5'000U);
  EXPECT_DOUBLE_EQ(gate.share, 0.001);
}

TEST(Gate, TakesNoneOfFewTicks) {
  EXPECT_EQ(calibrated_gate({70, 9, 30}).limit, 9U);
  EXPECT_EQ(calibrated_gate({7, 7, 7, 7, 50}, 0.5).limit, 7U) << "equal counts stay together";
  EXPECT_EQ(calibrated_gate({}).limit, 0U) << "which gates nothing";
}

TEST(Gate, RefusesAShareThatIsNone) {
  EXPECT_THROW(calibrated_gate({1}, 1), std::exception);
  EXPECT_THROW(calibrated_gate({1}, -0.1), std::exception);
  EXPECT_THROW(calibrated_gate({1}, std::nan("")), std::exception);
}

TEST(Gate, MissesNoMoreIntervalsThanAskedFor) {
  Gate gate{.limit = 70, .share = 0.001, .ticks = 100};
  for (int i = 0; i < 1000; ++i) gate.ratios.push_back(10 + i);
  gate.intervals = 2000;  // the larger ratios are not kept
  EXPECT_EQ(rule_of(gate, 40ms).ratio, 12) << "2 of 2000 are below";
  EXPECT_EQ(rule_of(gate, 40ms, 0.1).ratio, 210);
  EXPECT_EQ(rule_of(gate, 40ms, 0.9).ratio, 1009) << "the largest that is kept";
  EXPECT_THROW(rule_of(gate, 40ms, 1), std::exception);
  EXPECT_THROW(rule_of(gate, 40ms, -0.1), std::exception);
}

TEST(Gate, OfTooFewIntervalsOpensAsSoonAsNoiseLeavesItClosed) {
  for (const std::vector<double>& ratios : {std::vector<double>{-0.5, 11.7, 13}, std::vector<double>{12.3, 12.6, 13}}) {
    const Gate gate{.limit = 70, .share = 0.001, .ticks = 100, .ratios = ratios, .intervals = 20};
    EXPECT_NEAR(rule_of(gate, 40ms).ratio.value(), std::log(20 / 0.02), 1e-12) << "neither of the smallest says what 0.1 % is";
    EXPECT_NEAR(rule_of(gate, 40ms, 0).ratio.value(), std::log(1000), 1e-12);
    EXPECT_NEAR(rule_of(gate, 40ms, 0.049).ratio.value(), std::log(1000), 1e-12);
    EXPECT_EQ(rule_of(gate, 40ms, 0.05).ratio, ratios[1]) << "1 of 20";
  }
}

TEST(Gate, HasALimitForEveryHistory) {
  EXPECT_NEAR(quiet_limit(100ms), std::log(2500), 1e-12);
  EXPECT_NEAR(quiet_limit(3ms), std::log(100), 1e-12) << "parts of two steps";
  EXPECT_NEAR(quiet_limit(1us), std::log(50), 1e-12);
}

TEST(Gate, ClosesBelowItsRatioWhateverTheNumberOfEvents) {
  const GateRule rule{.events = 70, .ratio = 12.5};
  EXPECT_TRUE(rule.closes(1'000'000, 12.4));
  EXPECT_FALSE(rule.closes(0, 12.5));
  EXPECT_FALSE(rule.closes(0, std::numeric_limits<double>::infinity())) << "the background is not known yet";
}

TEST(Gate, OfAnOlderBundleClosesBelowItsLimitOfEvents) {
  const nlohmann::json older{{"limit_events", 1321}, {"share", 0.001}, {"ticks", 4242}};
  const GateRule rule = rule_of(older.get<Gate>(), 40ms);
  EXPECT_FALSE(rule.ratio);
  EXPECT_TRUE(rule.closes(1320, 1e9));
  EXPECT_FALSE(rule.closes(1321, -1));
}

TEST(Gate, RefusesRatiosThatAreNotInOrder) {
  nlohmann::json json = Gate{.limit = 1, .share = 0.001, .ticks = 4, .ratios = {1, 2}, .intervals = 2};
  EXPECT_NO_THROW(json.get<Gate>());
  json["ratios"] = {2, 1};
  EXPECT_THROW(json.get<Gate>(), std::exception);
  json["ratios"] = {1, 2, 3};
  EXPECT_THROW(json.get<Gate>(), std::exception) << "more than intervals";
}

TEST(Gate, IsReadBackAsItWasWritten) {
  const Gate gate{.limit = 1321, .share = 0.001, .ticks = 4242, .ratios = {0.1, 12.625, 1e9}, .intervals = 7};
  const nlohmann::json json = gate;
  EXPECT_EQ(json.get<Gate>(), gate);
}

}  // namespace
}  // namespace tactile::model
