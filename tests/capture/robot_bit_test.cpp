#include "tactile/capture/robot_bit.hpp"

#include <gtest/gtest.h>

#include "tactile/core/error.hpp"

namespace tactile::capture {
namespace {

TEST(RobotBit, IsAWholeFieldOrOneBitOfIt) {
  const RobotBit whole = robot_bit("output_bit_register_64");
  EXPECT_EQ(whole.field, "output_bit_register_64");
  EXPECT_FALSE(whole.bit);
  EXPECT_TRUE(whole.is_high(1));
  EXPECT_TRUE(whole.is_high(-3));
  EXPECT_FALSE(whole.is_high(0));

  const RobotBit third = robot_bit("actual_digital_output_bits:3");
  EXPECT_EQ(third.field, "actual_digital_output_bits");
  EXPECT_EQ(third.text(), "actual_digital_output_bits:3");
  EXPECT_TRUE(third.is_high(8));
  EXPECT_TRUE(third.is_high(15));
  EXPECT_FALSE(third.is_high(7));
  EXPECT_TRUE(third.is_high(-1));
  EXPECT_TRUE(robot_bit("x:31").is_high(4294967295.0));
  EXPECT_FALSE(third.is_high(1e300));
}

TEST(RobotBit, RefusesWhatNamesNone) {
  for (const char* text : {"", ":3", "field:", "field:64", "field:-1", "field:1.5", "two words", "field:3:4"})
    EXPECT_THROW(robot_bit(text), Error) << text;
}

TEST(RisingEdge, NeedsALowBefore) {
  RisingEdge edge;
  EXPECT_FALSE(edge.rises(true));  // it may have been high for long
  EXPECT_FALSE(edge.rises(false));
  EXPECT_TRUE(edge.rises(true));
  EXPECT_FALSE(edge.rises(true));
  EXPECT_FALSE(edge.rises(false));
  EXPECT_FALSE(edge.rises(std::nullopt));  // out of reach: what was known still holds
  EXPECT_TRUE(edge.rises(true));
}

}  // namespace
}  // namespace tactile::capture
