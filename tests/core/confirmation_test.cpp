#include "tactile/core/confirmation.hpp"

#include <gtest/gtest.h>

#include "support/error_of.hpp"
#include "support/verdict_row.hpp"

namespace tactile {
namespace {

using test::error_of;
using test::verdict_row;

TEST(Confirmation, OneOfOneBelievesEachTick) {
  const auto verdicts = verdict_row(".p.ssp.");
  EXPECT_EQ(confirmed(verdicts, {1, 1}), verdicts);
}

TEST(Confirmation, WaitsForTheSecondOfThree) { EXPECT_EQ(confirmed(verdict_row("..ppp..."), {2, 3}), verdict_row("...ppp..")); }

TEST(Confirmation, BridgesAGapAndDropsWhatIsAlone) {
  EXPECT_EQ(confirmed(verdict_row(".p...pp.pp...."), {2, 3}), verdict_row("......ppppp..."));
}

TEST(Confirmation, NeedsTheSameClassEachTime) {
  EXPECT_EQ(confirmed(verdict_row("..pspsps"), {2, 3}), verdict_row("....psps"));
  EXPECT_EQ(confirmed(verdict_row("..pspsps"), {3, 3}), verdict_row("........"));
}

TEST(Confirmation, CountsTicksBeforeTheFirstAsNone) {
  EXPECT_EQ(confirmed(verdict_row("ssss"), {3, 4}), verdict_row("..ss"));
  EXPECT_TRUE(confirmed({}, {3, 4}).empty());
}

TEST(Confirmation, IsReadFromText) {
  EXPECT_EQ(confirmation_in("2/3"), (Confirmation{2, 3}));
  EXPECT_EQ(confirmation_in("1000/1000"), (Confirmation{1000, 1000}));
  EXPECT_EQ(text_of(confirmation_in("3/5")), "3/5");
  for (const char* bad : {"", "2", "2/", "/3", "0/1", "1/2", "2/4", "4/3", "-2/3", "2/3/4", "2 / 3", "1001/1001", "2.5/3"})
    EXPECT_NE(error_of([&] { confirmation_in(bad); }).find("more than half"), std::string::npos) << bad;
}

}  // namespace
}  // namespace tactile
