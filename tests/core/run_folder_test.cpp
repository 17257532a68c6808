#include "tactile/core/run_folder.hpp"

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile {
namespace {

TEST(FindRuns, ListsThemByObjectThenRunAndPassesOverOtherFolders) {
  const test::TemporaryFolder data;
  for (const char* folder : {"fan/02", "fan/01", "box/01", "fan/01.discarded-1", "Notes/01", "fan/1"}) {
    write_whole(data.path() / folder / "events.aedat4", "");
  }
  std::filesystem::create_directories(data.path() / "fan" / "03");
  std::vector<std::string> names;
  for (const RunFolder& run : find_runs(data.path())) names.push_back(run.name());
  EXPECT_EQ(names, (std::vector<std::string>{"box/01", "fan/01", "fan/02"}));
}

TEST(FindRuns, RefusesAFolderThatIsNotThere) { EXPECT_THROW(find_runs("/nowhere/at/all"), Error); }

TEST(RunInfo, KeepsWhatItDoesNotKnow) {
  const test::TemporaryFolder data;
  std::filesystem::create_directories(data.path() / "fan" / "01");
  const RunFolder run = run_folder_at(data.path() / "fan" / "01");
  write_run_info(run, {.object = "fan",
                       .run = "01",
                       .session = "a",
                       .simulated = true,
                       .complete = true,
                       .width = 640,
                       .height = 480,
                       .extra = {{"weather", "fine"}}});
  const RunInfo info = read_run_info(run);
  EXPECT_EQ(info.object, "fan");
  EXPECT_EQ(info.width, 640);
  EXPECT_TRUE(info.simulated);
  EXPECT_EQ(info.extra.at("weather"), "fine");
}

TEST(RunInfo, RefusesASensorWithoutArea) {
  const test::TemporaryFolder data;
  write_whole(data.path() / "fan" / "01" / "run.json",
              R"({"object": "fan", "run": "01", "simulated": false, "complete": true, "sensor": {"width": 0, "height": 480}})");
  EXPECT_THROW(read_run_info(run_folder_at(data.path() / "fan" / "01")), Error);
}

TEST(Names, AreWhatTheFoldersMayBeCalled) {
  EXPECT_TRUE(is_run_id("01") && is_run_id("99"));
  EXPECT_FALSE(is_run_id("00") || is_run_id("1") || is_run_id("001") || is_run_id("0a"));
  EXPECT_TRUE(is_object_name("usb-hub") && is_object_name("3d-printed-object"));
  EXPECT_FALSE(is_object_name("Fan") || is_object_name("-fan") || is_object_name("") || is_object_name("a_b"));
}

}  // namespace
}  // namespace tactile
