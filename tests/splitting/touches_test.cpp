#include "tactile/splitting/touches.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "splitting/made_bursts.hpp"

namespace tactile::splitting {
namespace {

using Kinds = std::vector<BurstKind>;
using Moves = std::vector<ArmMove>;

const alignment::EventRate& rate = quiet_rate;

ArmMove move_between(std::int64_t start_ms, std::int64_t end_ms, microseconds uncertainty = 0us) {
  return {at_ms(start_ms), at_ms(end_ms), uncertainty};
}
Kinds kinds(const std::vector<alignment::Burst>& bursts, const std::optional<std::vector<ArmMove>>& lifts,
            const std::vector<double>& undoes, const std::vector<ArmMove>& taps = {}) {
  return kinds_of(rate, bursts, lifts, taps, undoes);
}
constexpr double inward = -0.9, outward = 0.9, other = 0.1;  // what they undo

TEST(KindsOf, CallsTheBurstInTheLiftTheSlipAndWhatCameBeforeThePress) {
  const std::vector<alignment::Burst> bursts = {burst(500, 700), burst(1'200, 1'800)};
  EXPECT_EQ(kinds(bursts, Moves{move_between(1'190, 1'800)}, {inward, other}), (Kinds{BurstKind::press, BurstKind::slip}));
}

TEST(KindsOf, TakesTheBurstWithTheMostEventsInTheLift) {
  const std::vector<alignment::Burst> bursts = {burst(500, 1'250), burst(1'300, 1'800)};
  EXPECT_EQ(kinds(bursts, Moves{move_between(1'190, 1'800)}, {inward, other}), (Kinds{BurstKind::press, BurstKind::slip}));
}

TEST(KindsOf, ReachesAsFarAsTheClockMayBeOff) {
  const std::vector<alignment::Burst> bursts = {burst(500, 700), burst(1'200, 1'300)};
  EXPECT_EQ(kinds(bursts, Moves{move_between(1'310, 1'500)}, {inward, other}), (Kinds{BurstKind::press, BurstKind::press}));
  EXPECT_EQ(kinds(bursts, Moves{move_between(1'310, 1'500, 20ms)}, {inward, other}), (Kinds{BurstKind::press, BurstKind::slip}));
}

TEST(KindsOf, FindsAReleaseByWhatItReverses) {
  const std::vector<alignment::Burst> bursts = {burst(300, 500), burst(900, 1'100), burst(1'500, 1'700), burst(2'200, 2'800)};
  EXPECT_EQ(kinds(bursts, Moves{move_between(2'190, 2'800)}, {inward, outward, inward, other}),
            (Kinds{BurstKind::press, BurstKind::release, BurstKind::press, BurstKind::slip}));
}

TEST(KindsOf, IgnoresWhatIsShortAndSmallButNotALightPress) {
  const std::vector<alignment::Burst> bursts = {burst(300, 320, 900), burst(500, 700, 900), burst(1'200, 1'800)};
  EXPECT_EQ(kinds(bursts, Moves{move_between(1'190, 1'800)}, {inward, inward, other}),
            (Kinds{BurstKind::brief, BurstKind::press, BurstKind::slip}));
}

TEST(KindsOf, DoesNotTakeTipsThatSpringBackDuringAPressForAnother) {
  const std::vector<alignment::Burst> bursts = {burst(300, 500), burst(700, 765, 20'000), burst(1'200, 1'800)};
  EXPECT_EQ(kinds(bursts, Moves{move_between(1'190, 1'800)}, {inward, outward, other}),
            (Kinds{BurstKind::press, BurstKind::brief, BurstKind::slip}));
  const std::vector<alignment::Burst> pressed_again = {burst(300, 500), burst(700, 850, 20'000), burst(1'200, 1'800)};
  EXPECT_EQ(kinds(pressed_again, Moves{move_between(1'190, 1'800)}, {inward, other, other}),
            (Kinds{BurstKind::press, BurstKind::press, BurstKind::slip}));
}

TEST(KindsOf, TakesABurstOfTheShortestLengthForAPress) {
  const auto second = [](std::size_t end_ms) {
    const std::vector<alignment::Burst> bursts = {burst(300, 500), burst(700, end_ms, 20'000), burst(1'200, 1'800)};
    return kinds(bursts, Moves{move_between(1'190, 1'800)}, {inward, other, other})[1];
  };
  EXPECT_EQ(second(799), BurstKind::brief);
  EXPECT_EQ(second(800), BurstKind::press);
  const auto slow_first = [](std::size_t end_ms) {
    alignment::Burst slow = burst(900, end_ms, 1'000);
    slow.slow = true;
    return kinds({slow, burst(1'200, 1'800)}, Moves{move_between(1'190, 1'800)}, {inward, other})[0];
  };
  EXPECT_EQ(slow_first(1'049), BurstKind::brief);
  EXPECT_EQ(slow_first(1'050), BurstKind::press);
}

TEST(KindsOf, SetsTapsAndWhatFollowsTheSlipAside) {
  const std::vector<alignment::Burst> bursts = {burst(100, 150), burst(500, 700), burst(1'200, 1'800), burst(2'400, 2'500)};
  EXPECT_EQ(kinds(bursts, Moves{move_between(1'190, 1'800)}, {inward, inward, other, other}, {move_between(80, 200)}),
            (Kinds{BurstKind::tap, BurstKind::press, BurstKind::slip, BurstKind::after}));
}

TEST(KindsOf, WithoutLiftsTheSlipIsTheLastBurstThatIsNoRelease) {
  EXPECT_EQ(kinds({burst(500, 700), burst(1'200, 1'800), burst(2'400, 2'600)}, std::nullopt, {inward, other, outward}),
            (Kinds{BurstKind::press, BurstKind::slip, BurstKind::release}));
}

TEST(KindsOf, KnowsTheReleaseAfterASlip) {
  const std::vector<alignment::Burst> bursts = {burst(500, 700), burst(1'200, 1'800), burst(2'400, 2'480)};
  EXPECT_EQ(kinds(bursts, Moves{move_between(1'190, 1'800)}, {inward, other, outward}),
            (Kinds{BurstKind::press, BurstKind::slip, BurstKind::release}));
}

TEST(KindsOf, TakesASlowBurstForAPressOnlyWhereNoneStands) {
  alignment::Burst slow = burst(900, 1'100, 1'000);
  slow.slow = true;
  EXPECT_EQ(kinds({burst(300, 500), slow, burst(1'200, 1'800)}, Moves{move_between(1'190, 1'800)}, {inward, other, other}),
            (Kinds{BurstKind::press, BurstKind::brief, BurstKind::slip}))
      << "the tips creep";
  EXPECT_EQ(kinds({slow, burst(1'200, 1'800)}, Moves{move_between(1'190, 1'800)}, {inward, other}),
            (Kinds{BurstKind::press, BurstKind::slip}));
  EXPECT_EQ(kinds({burst(300, 500), burst(700, 850), slow}, std::nullopt, {inward, other, other}),
            (Kinds{BurstKind::press, BurstKind::slip, BurstKind::after}))
      << "without a lift the slip is the last burst that the whole image shows";
  alignment::Burst spring_back = burst(900, 1'000, 1'000);
  spring_back.slow = true;
  EXPECT_EQ(kinds({spring_back, burst(1'200, 1'800)}, Moves{move_between(1'190, 1'800)}, {inward, other}),
            (Kinds{BurstKind::brief, BurstKind::slip}))
      << "no stage presses slowly for such a short time";
}

TEST(KindsOf, OfAnArmThatNeverRoseNoneIsASlip) {
  const std::vector<alignment::Burst> bursts = {burst(500, 700), burst(1'200, 1'800)};
  EXPECT_EQ(kinds(bursts, Moves{}, {inward, other}), (Kinds{BurstKind::press, BurstKind::press}));
}

TEST(KindsOf, UsesTheOrderWhereNoLiftIsKnown) {
  const std::vector<alignment::Burst> bursts = {burst(500, 700), burst(1'200, 1'800), burst(2'400, 2'410, 500)};
  EXPECT_EQ(kinds(bursts, std::nullopt, {inward, other, other}), (Kinds{BurstKind::press, BurstKind::slip, BurstKind::after}));
  EXPECT_EQ(kinds({bursts[0]}, std::nullopt, {inward}), (Kinds{BurstKind::press}));
  EXPECT_EQ(kinds({}, std::nullopt, {}), Kinds{});
}

}  // namespace
}  // namespace tactile::splitting
