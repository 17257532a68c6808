#include "tactile/report/csv_reader.hpp"

#include <gtest/gtest.h>

#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::report {
namespace {

TEST(CsvReader, GivesFieldsByColumnAndSkipsEmptyLines) {
  const test::TemporaryFolder folder;
  write_whole(folder / "a.csv", "t,x\r\n1,2\r\n\n3\n,5");
  CsvReader csv(folder / "a.csv", 100);
  EXPECT_TRUE(csv.has("x"));
  EXPECT_FALSE(csv.has("y"));
  ASSERT_TRUE(csv.next());
  EXPECT_EQ(csv["t"], "1");
  EXPECT_EQ(csv["x"], "2");
  EXPECT_EQ(csv["y"], std::nullopt);
  ASSERT_TRUE(csv.next());
  EXPECT_EQ(csv.line(), 4U);
  EXPECT_EQ(csv["t"], "3");
  EXPECT_EQ(csv["x"], std::nullopt) << "the row is too short";
  ASSERT_TRUE(csv.next());
  EXPECT_EQ(csv["t"], "");
  EXPECT_EQ(csv["x"], "5");
  EXPECT_FALSE(csv.next());
}

TEST(CsvReader, OfAnEmptyFileHasNeitherColumnsNorRows) {
  const test::TemporaryFolder folder;
  write_whole(folder / "a.csv", "");
  CsvReader csv(folder / "a.csv", 100);
  EXPECT_FALSE(csv.has("t"));
  EXPECT_FALSE(csv.next());
  write_whole(folder / "a.csv", std::string(101, 'x'));
  EXPECT_NE(test::error_of([&] { CsvReader(folder / "a.csv", 100); }).find("a.csv"), std::string::npos);
}

}  // namespace
}  // namespace tactile::report
