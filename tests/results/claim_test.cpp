#include "tactile/results/claim.hpp"

#include <gtest/gtest.h>

namespace tactile::results {
namespace {

TEST(Claim, SaysInHowManyReplicatesItWouldBeWritten) {
  Claim claim{.measure = "the mean delay of the slowest object",
              .unit = "ms",
              .is_below = true,
              .limit = 5,
              .written = 6,
              .replicates = 7,
              .measured = {4.25, 4, 4.5, 7}};
  EXPECT_EQ(words_of(claim),
            "Written in 6 of 7 replicates: where the mean delay of the slowest object is below 5 ms. Measured: 4.25 ms [4.00, "
            "4.50].");
  claim.is_by_margin = true;
  EXPECT_EQ(words_of(claim),
            "The mean delay of the slowest object must be below 5 ms, a margin; it is in 6 of 7 replicates. Measured: 4.25 ms "
            "[4.00, 4.50].");
  EXPECT_EQ(words_of(Claim{}), "Not measured in this study.");
}

}  // namespace
}  // namespace tactile::results
