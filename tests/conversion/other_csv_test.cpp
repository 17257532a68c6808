// CSV files of other programs.

#include <gtest/gtest.h>

#include <filesystem>

#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "support/vendor_files.hpp"
#include "tactile/conversion/convert.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::conversion {
namespace {

using test::vendor_files;

TEST(ConvertCsv, ReadsTheColumnsAndTimesOfOtherPrograms) {
  const test::TemporaryFolder folder;
  write_whole(folder / "in.txt", "0.000001 1 2 0\n0.5 3 4 1\n");
  const ConvertSummary summary = convert_recording(folder / "in.txt", folder / "out.csv", {.csv = {.columns = "t,x,y,p"}});
  EXPECT_EQ(read_text(folder / "out.csv"), "t_us,x,y,on\n1,1,2,0\n500000,3,4,1\n");
  EXPECT_EQ(summary.time_unit, events::TimeUnit::s);
  EXPECT_TRUE(summary.time_unit_guessed);
  convert_recording(folder / "in.txt", folder / "out.aedat4", {.csv = {.columns = "t,y,x,p", .time_unit = events::TimeUnit::ms}});
  convert_recording(folder / "out.aedat4", folder / "turned.csv");
  EXPECT_EQ(read_text(folder / "turned.csv"), "t_us,x,y,on\n0,2,1,0\n500,4,3,1\n");
}

TEST(ConvertCsv, ReadsWhatPythonWritesAsOtherProgramsDo) {
  const test::TemporaryFolder folder;
  write_whole(folder / "rewrite.py",
              "import csv\n"
              "rows = list(csv.DictReader(open('own.csv', newline='')))\n"
              "with open('other.csv', 'w', newline='') as out:\n"
              "    writer = csv.writer(out)\n"  // CR LF
              "    writer.writerow(['Polarity', 'y', 'frame', 'x', 'timestamp'])\n"
              "    for i, row in enumerate(rows):\n"
              "        t = row['t_us'].rjust(7, '0')\n"
              "        writer.writerow([2 * int(row['on']) - 1, row['y'], i // 7, row['x'], t[:-6] + '.' + t[-6:]])\n");
  convert_recording(vendor_files / "dv-lz4.aedat4", folder / "own.csv");
  ASSERT_EQ(test::run_shell("python3 rewrite.py", folder.path()).exit_code, 0);
  const ConvertSummary summary = convert_recording(folder / "other.csv", folder / "again.csv");
  EXPECT_EQ(summary.time_unit, events::TimeUnit::s);
  EXPECT_EQ(read_text(folder / "again.csv"), read_text(folder / "own.csv"));
}

}  // namespace
}  // namespace tactile::conversion
