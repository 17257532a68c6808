#include "tactile/labels/unlogged_lift.hpp"

#include <gtest/gtest.h>

#include "labels/made_bursts.hpp"

namespace tactile::labels {
namespace {

// A press, a slip and a release.
const std::vector<alignment::Burst> bursts = {burst(500, 700), burst(1'200, 1'800), burst(3'000, 3'200)};
const std::vector<bool> may_slip = {false, true, true};  // the release is not recognised

alignment::VideoMotion motion(std::int64_t start_ms, std::int64_t end_ms, double energy) {
  const auto around = [](std::int64_t ms) { return alignment::UncertainTime{at_ms(ms), at_ms(ms - 15), at_ms(ms + 15)}; };
  return {.start = around(start_ms), .end = around(end_ms), .energy = energy};
}

std::optional<UnloggedLift> by_film(const std::vector<alignment::VideoMotion>& filmed) {
  return unlogged_lift({}, filmed, quiet_rate, bursts, may_slip);
}

TEST(UnloggedLift, IsTheLastMotionThatChangesTheFilmMuch) {
  const auto lift = by_film({motion(300, 700, 20), motion(1'190, 1'800, 60), motion(3'000, 3'400, 20)});
  ASSERT_TRUE(lift);
  EXPECT_EQ(lift->witness, LiftWitness::film);
  EXPECT_EQ(lift->move.start, at_ms(1'190));
  EXPECT_EQ(lift->move.end, at_ms(1'800));
  EXPECT_EQ(lift->move.uncertainty, 15ms);
}

TEST(UnloggedLift, IsALongSlowMotionRatherThanAShortFastOne) {
  const auto lift = by_film({motion(600, 700, 40), motion(1'190, 1'800, 30), motion(3'000, 3'100, 40)});
  ASSERT_TRUE(lift);
  EXPECT_EQ(lift->move.start, at_ms(1'190));
}

TEST(UnloggedLift, IsTheOnlyMotionInTheFilmIfThatIsNoPress) {
  const auto lift = by_film({motion(1'190, 1'800, 60)});
  ASSERT_TRUE(lift);
  EXPECT_EQ(lift->move.start, at_ms(1'190));
  EXPECT_FALSE(by_film({motion(300, 700, 20)}));
}

TEST(UnloggedLift, IsNotKnownFromAFilmWithoutAMotionThatChangesLess) {
  EXPECT_FALSE(by_film({}));
  EXPECT_FALSE(by_film({motion(300, 700, 20), motion(3'000, 3'400, 20)}));
}

TEST(UnloggedLift, LiesInABurstThatMayBeASlip) {
  EXPECT_FALSE(by_film({motion(500, 700, 90), motion(1'190, 1'800, 3), motion(3'000, 3'200, 3)}));
  EXPECT_FALSE(by_film({motion(500, 700, 20), motion(2'000, 2'800, 60)}));
}

}  // namespace
}  // namespace tactile::labels
