#include "tactile/core/runs_below.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;

class LookForRuns : public testing::Test {
 protected:
  void make(const std::vector<std::string>& runs) const {
    for (const std::string& run : runs) write_whole(data.path() / run / "events.aedat4", "");
  }
  RunsBelow found() const { return look_for_runs(data.path()); }
  std::string sentence(const std::string& folder, const std::string& text) const {
    return (data.path() / folder).string() + text;
  }
  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const RunFolder& run : found().runs) names.push_back(run.name());
    return names;
  }

  test::TemporaryFolder data;
  const std::string object_rule = " left out, because an object's name is lower-case letters, digits and inner hyphens; ";
  const std::string run_rule = ": is left out, because a run's name is two digits from 01 on; ";
};

TEST_F(LookForRuns, NamesWhatAMisnamedFolderNeeds) {
  make({"White-Box/01", "White-Box/02", "Water Bottle/01", "fan/01", "mug/2", "mug/run-03"});
  EXPECT_EQ(names(), (std::vector<std::string>{"fan/01"}));
  EXPECT_EQ(found().misnamed,
            (std::vector<std::string>{sentence("Water Bottle", ": its run is" + object_rule + "rename it to water-bottle"),
                                      sentence("White-Box", ": its 2 runs are" + object_rule + "rename it to white-box"),
                                      sentence("mug/2", run_rule + "rename it to 02"),
                                      sentence("mug/run-03", run_rule + "rename it to 03")}));
  EXPECT_TRUE(found().unreadable.empty());
}

TEST_F(LookForRuns, NamesAnotherWhereTheNeededOneIsTaken) {
  make({"mug/2", "mug/02", "mug/002", "MUG/01", "2024-05/01"});
  fs::create_directories(data / "mug/01");
  EXPECT_EQ(found().misnamed,
            (std::vector<std::string>{
                sentence("MUG", ": its run is" + object_rule +
                                    "mug is taken: move the run there under free numbers, or rename it otherwise"),
                sentence("mug/002", run_rule + "rename it to 03, which is free; 02 is taken"),
                sentence("mug/2", run_rule + "rename it to 04, which is free; 02 is taken")}));
  EXPECT_EQ(names(), (std::vector<std::string>{"2024-05/01", "mug/02"}));
}

TEST_F(LookForRuns, GivesTwoMisnamedObjectsNoCommonName) {
  make({"Mug/01", "MUG/01"});
  EXPECT_EQ(found().misnamed.size(), 2U);
  EXPECT_TRUE(found().misnamed[0].ends_with("rename it to mug"));
  EXPECT_NE(found().misnamed[1].find("mug is taken"), std::string::npos);
}

TEST_F(LookForRuns, PassesOverHiddenFoldersDiscardedRunsAndThoseWithoutARecording) {
  make({"fan/01", "fan/01.discarded-1", "fan/02.discarded-12", ".trash/01", "fan/.02.removed"});
  fs::create_directories(data / "Notes/01");
  fs::create_directories(data / "fan/old");
  EXPECT_EQ(names(), (std::vector<std::string>{"fan/01"}));
  EXPECT_TRUE(found().misnamed.empty() && found().unreadable.empty() && found().without_recording.empty());
  make({"fan/01.discarded"});
  EXPECT_EQ(found().misnamed.size(), 1U) << "this is none of record's names";
}

TEST_F(LookForRuns, ReportsARecordingThatLiesAFolderTooHigh) {
  make({"fan/01", "Take", "07"});
  const std::string rule = ": is left out, because it has a recording where an object's runs belong; move it to ";
  EXPECT_EQ(found().misnamed, (std::vector<std::string>{sentence("Take", rule + (data / "take/01").string()),
                                                        sentence("07", rule + (data / "<object>/01").string())}));
}

TEST_F(LookForRuns, ReportsRunsThatLieAFolderTooDeep) {
  make({"fan/01", "lab/mug/01", "lab/mug/02", "lab/jar/01", "lab/.old/01"});
  fs::create_directories(data / "fan/02/notes");
  EXPECT_EQ(names(), (std::vector<std::string>{"fan/01"}));
  const std::string or_name = ", or name " + (data / "lab").string() + " as the folder of runs";
  EXPECT_EQ(found().misnamed,
            (std::vector<std::string>{sentence("lab/jar", ": its run is left out, one folder too deep; move it to ") +
                                          (data / "jar").string() + or_name,
                                      sentence("lab/mug", ": its 2 runs are left out, one folder too deep; move it to ") +
                                          (data / "mug").string() + or_name}));
  EXPECT_EQ(found().without_recording, (std::vector<fs::path>{data / "fan/02"}));
}

TEST_F(LookForRuns, NamesARecordingWhoseNameIsNotThatOfARunsRecording) {
  make({"fan/01"});
  for (const char* file : {"fan/02/Events.aedat4", "fan/03/take.AEDAT4", "fan/03/old.aedat4", "fan/old/take.aedat4"})
    write_whole(data / file, "");
  fs::create_directories(data / "fan/04");
  EXPECT_EQ(names(), (std::vector<std::string>{"fan/01"}));
  const std::string rule = ": is left out, because a run's recording is named events.aedat4; rename ";
  EXPECT_EQ(found().misnamed,
            (std::vector<std::string>{sentence("fan/02", rule + "Events.aedat4 to it"),
                                      sentence("fan/03", rule + "the right one of old.aedat4, take.AEDAT4 to it")}));
}

TEST_F(LookForRuns, NamesRunsWithoutARecording) {
  make({"fan/01", "fan/02", "07/01"});
  fs::create_directories(data / "fan/08");
  fs::create_symlink("nowhere", data / "fan/08/events.aedat4");  // unreadable
  for (const char* run : {"mug/02", "fan/03", "fan/04.discarded-1", "Fan/05", "06"}) fs::create_directories(data / run);
  EXPECT_EQ(names(), (std::vector<std::string>{"07/01", "fan/01", "fan/02"}));
  EXPECT_EQ(found().without_recording, (std::vector<fs::path>{data / "fan/03", data / "mug/02"}));
  EXPECT_EQ(sentence_on_missing_recordings(found().without_recording),
            "left out, because events.aedat4 is missing: " + (data / "fan/03").string() + ", " + (data / "mug/02").string());
  EXPECT_EQ(look_for_runs(data / "fan").without_recording, std::vector<fs::path>{data / "fan/03"}) << "of an object's folder";
  EXPECT_EQ(sentence_on_missing_recordings({}), "");
}

TEST_F(LookForRuns, TakesTheFolderOfAnObjectForNoDataFolder) {
  make({"mug/01", "mug/2"});
  const RunsBelow below = look_for_runs(data / "mug");
  EXPECT_TRUE(below.runs.empty());
  EXPECT_EQ(below.misnamed, (std::vector<std::string>{sentence("mug/2", run_rule + "rename it to 02")}));
}

TEST_F(LookForRuns, NamesWhatItCannotReadAndFindsTheOthers) {
  make({"fan/01", "fan/02"});
  fs::create_symlink("loop", data / "loop");
  fs::create_symlink("03", data / "fan/03");
  fs::create_symlink("/nowhere/at/all", data / "fan/04");
  fs::create_directories(data / "fan/05");
  fs::create_symlink("events.aedat4", data / "fan/05/events.aedat4");
  EXPECT_EQ(names(), (std::vector<std::string>{"fan/01", "fan/02"}));
  std::vector<std::string> unreadable = found().unreadable;
  std::sort(unreadable.begin(), unreadable.end());
  const std::string loops =
      ": cannot be read (Too many levels of symbolic links); expected a folder of runs, a run or its recording";
  EXPECT_EQ(
      unreadable,
      (std::vector<std::string>{
          sentence("fan/03", loops),
          sentence("fan/04", ": cannot be read (No such file or directory); expected a folder of runs, a run or its recording"),
          sentence("fan/05/events.aedat4", loops), sentence("loop", loops)}));
}

TEST_F(LookForRuns, NamesADataFolderThatCannotBeRead) {
  fs::create_symlink("data", data / "data");
  EXPECT_EQ(
      test::error_of([&] { look_for_runs(data / "data"); }),
      sentence("data", ": cannot be read (Too many levels of symbolic links); expected a folder of runs, DATA/<object>/<run>"));
  EXPECT_EQ(test::error_of([&] { look_for_runs(data / "none"); }),
            sentence("none", ": no such folder; expected a folder of runs, DATA/<object>/<run>"));
}

TEST_F(LookForRuns, RefusesAMisnamedRunByThePathThatWasTyped) {
  make({"Mug/01", "mug/2", "mug/01", "mug/01.discarded-1"});
  EXPECT_EQ(test::error_of([&] { named_run_at(data / "mug/2/"); }),
            sentence("mug/2/", ": a run's name is two digits from 01 on; rename it to 02"));
  EXPECT_EQ(
      test::error_of([&] { named_run_at(data / "Mug/01"); }),
      sentence("Mug/01", ": an object's name is lower-case letters, digits and inner hyphens; rename the folder Mug to mug"));
  EXPECT_EQ(named_run_at(data / "mug/01").name(), "mug/01");
  EXPECT_EQ(what_is_misnamed(data / "mug/01.discarded-1"), "");
}

TEST(NeededObjectName, IsLowerCaseWithHyphens) {
  EXPECT_EQ(needed_object_name("White-Box"), "white-box");
  EXPECT_EQ(needed_object_name("water_bottle"), "water-bottle");
  EXPECT_EQ(needed_object_name("Water  Bottle (2)"), "water-bottle-2");
  EXPECT_EQ(needed_object_name("_fan_"), "fan");
  EXPECT_EQ(needed_object_name("\xC3\xA9"), "");
}

}  // namespace
}  // namespace tactile
