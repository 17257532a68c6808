#include "tactile/core/csv_table.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace tactile {
namespace {

TEST(CsvTable, HasItsNamesAndARowForEachAdded) {
  CsvTable table("name,unit,n,value,low,high");
  EXPECT_EQ(table.text(), "name,unit,n,value,low,high\n");
  table.add_row("fan/01", std::string("a; \"b\""), std::int64_t{-7}, std::array<std::string, 3>{"1", "", "2.5"});
  table.add_row("", "ms", std::optional<std::size_t>(), std::vector<std::string>{"x", "y", "z"});
  EXPECT_EQ(table.text(),
            "name,unit,n,value,low,high\n"
            "fan/01,\"a; \"\"b\"\"\",-7,1,,2.5\n"
            ",ms,,x,y,z\n");
}

TEST(CsvNumber, HasItsDigitsAndIsEmptyUnlessFinite) {
  EXPECT_EQ(csv_number(1.0 / 3), "0.333333333");
  EXPECT_EQ(csv_number(1e-12, 3), "1e-12");
  EXPECT_EQ(csv_number(2.0), "2");
  EXPECT_EQ(csv_number(std::numeric_limits<double>::infinity()), "");
  EXPECT_EQ(csv_number(std::numeric_limits<double>::quiet_NaN()), "");
  EXPECT_EQ(csv_number(std::optional<double>()), "");
  EXPECT_EQ(csv_number(std::optional(static_cast<double>(0.1F)), 10), "0.1000000015");
}

}  // namespace
}  // namespace tactile
