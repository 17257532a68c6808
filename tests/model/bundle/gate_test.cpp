#include "tactile/model/bundle/gate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace tactile::model {
namespace {

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

TEST(Gate, IsReadBackAsItWasWritten) {
  const Gate gate{.limit = 1321, .share = 0.001, .ticks = 4242};
  const nlohmann::json json = gate;
  EXPECT_EQ(json.get<Gate>(), gate);
}

}  // namespace
}  // namespace tactile::model
