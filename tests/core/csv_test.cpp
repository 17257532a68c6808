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

TEST(SplitCells, DropsBlanksAndQuotesAroundACell) {
  const auto cells_of = [](std::string_view row, char separator) {
    Cells cells{"old"};
    split_cells(row, separator, cells);
    return cells;
  };
  EXPECT_EQ(cells_of(" a , \"b, c\" ,,d\r", ','), (Cells{"a", "b, c", "", "d"}));
  EXPECT_EQ(cells_of("  1   2 \t 3 ", ' '), (Cells{"1", "2", "3"}));
  EXPECT_EQ(cells_of("\ta\t", '\t'), (Cells{"", "a", ""}));
  EXPECT_EQ(cells_of("\"a\"\"b\";\"c", ';'), (Cells{"a\"\"b", "\"c"})) << "the last quote is not closed";
  EXPECT_EQ(cells_of(" \t\r", ','), Cells{});
}

TEST(SeparatorOf, IsTheMostFrequentOutsideQuotes) {
  EXPECT_EQ(separator_of("t, x, y"), ',');
  EXPECT_EQ(separator_of("t;\"x, y, z\";u"), ';');
  EXPECT_EQ(separator_of("start s\tend s"), '\t');
  EXPECT_EQ(separator_of("t x y"), ' ');
  EXPECT_EQ(separator_of("t"), ',');
}

TEST(CsvRows, OfQuotedCellsMayContainSeparatorsLineEndsAndQuotes) {
  CsvRows rows("id;\"a \"\"b\"\"\"\r\n1;\"x;\ny\"\r\n2;z\"z;\n;", {.separator = ';', .has_quotes = true});
  EXPECT_EQ(rows.column("a \"b\""), 1U);
  ASSERT_TRUE(rows.next());
  EXPECT_EQ(rows.cells(), (Cells{"1", "x;\ny"}));
  EXPECT_EQ(rows.line(), 2U);
  ASSERT_TRUE(rows.next());
  EXPECT_EQ(rows.cells(), (Cells{"2", "z\"z", ""}));
  EXPECT_EQ(rows.line(), 4U);
  ASSERT_TRUE(rows.next());
  EXPECT_EQ(rows.cells(), (Cells{"", ""}));
  EXPECT_FALSE(rows.next());
}

TEST(CsvRows, GiveCellsByColumnAndSkipEmptyRows) {
  CsvRows rows("t,x\r\n1,2\r\n\n3\n,5");
  ASSERT_TRUE(rows.next_filled());
  EXPECT_EQ(rows["t"], "1");
  EXPECT_EQ(rows["x"], "2");
  EXPECT_EQ(rows["y"], std::nullopt);
  ASSERT_TRUE(rows.next_filled());
  EXPECT_EQ(rows.line(), 4U);
  EXPECT_EQ(rows["t"], "3");
  EXPECT_EQ(rows["x"], std::nullopt) << "the row is too short";
  ASSERT_TRUE(rows.next_filled());
  EXPECT_EQ(rows["t"], "");
  EXPECT_EQ(rows["x"], "5");
  EXPECT_FALSE(rows.next_filled());
}

TEST(CsvRows, OfAnEmptyTextHaveNoColumns) {
  CsvRows rows("");
  EXPECT_FALSE(rows.column("t"));
  EXPECT_FALSE(rows.next());
}

}  // namespace
}  // namespace tactile
