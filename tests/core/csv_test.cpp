#include "tactile/core/csv.hpp"

#include <gtest/gtest.h>

namespace tactile {
namespace {

using Cells = std::vector<std::string_view>;

TEST(SplitCells, KeepsEmptyCells) {
  EXPECT_EQ(split_cells("a,,c,"), (Cells{"a", "", "c", ""}));
  EXPECT_EQ(split_cells(""), Cells{""});
  EXPECT_EQ(split_cells("1,5;2", ';'), (Cells{"1,5", "2"}));
}

TEST(CsvCell, IsQuotedOnlyIfItMustBe) {
  EXPECT_EQ(csv_cell("fan/01"), "fan/01");
  EXPECT_EQ(csv_cell("a; \"b\""), "\"a; \"\"b\"\"\"");
}

TEST(CsvRows, GivesNamesRowsAndLines) {
  CsvRows rows("t,x\r\n1,2\n\n3,4");
  EXPECT_EQ(rows.row(), "t,x");
  EXPECT_EQ(rows.column("x"), 1U);
  EXPECT_FALSE(rows.column("y"));
  ASSERT_TRUE(rows.next());
  EXPECT_EQ(rows.cells(), (Cells{"1", "2"}));
  ASSERT_TRUE(rows.next());
  EXPECT_EQ(rows.row(), "");
  ASSERT_TRUE(rows.next());
  EXPECT_EQ(rows.cells(), (Cells{"3", "4"}));
  EXPECT_EQ(rows.line(), 4U);
  EXPECT_FALSE(rows.next());
}

TEST(CsvRows, OfAnEmptyTextHaveNoColumns) {
  CsvRows rows("");
  EXPECT_FALSE(rows.column("t"));
  EXPECT_FALSE(rows.next());
}

}  // namespace
}  // namespace tactile
