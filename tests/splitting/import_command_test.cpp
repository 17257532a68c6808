#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "events/made_recording.hpp"
#include "support/events_in_file.hpp"
#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/run_files.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::splitting {
namespace {
namespace fs = std::filesystem;

class ImportCommand : public testing::Test {
 protected:
  ImportCommand() {
    fs::create_directory_symlink(fs::path(test::data_folder) / "aedat4", folder / "recordings");
    fs::create_directory_symlink(fs::path(test::data_folder) / "bags", folder / "bags");
  }
  test::CommandResult run(const std::string& arguments) const { return test::run_tactile(arguments, folder.path()); }
  nlohmann::json json_of(const std::string& arguments) const {
    const test::CommandResult result = run(arguments + " --json");
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(result.out);
  }
  fs::path run_folder(const std::string& name) const { return folder / "data" / name; }

  test::TemporaryFolder folder;
};

TEST_F(ImportCommand, MakesAHealthyRunOfARecordingWithAllItsEvents) {
  const auto json = json_of("import recordings/dv-lz4.aedat4 --object cup");
  ASSERT_EQ(json.at("runs").size(), 1U);
  const auto& run = json.at("runs").at(0);
  EXPECT_EQ(run.at("run"), "cup/01");
  EXPECT_EQ(run.at("folder"), "data/cup/01");
  EXPECT_EQ(run.at("kept"), false);
  EXPECT_EQ(run.at("healthy"), true);
  EXPECT_EQ(json.at("renamed"), nlohmann::json::array());
  const auto events = test::events_in_file(folder / "recordings/dv-lz4.aedat4");
  EXPECT_EQ(test::events_in_file(run_folder("cup/01") / "events.aedat4"), events);
  EXPECT_EQ(run.at("events"), events.size());
  const RunInfo info = read_run_info(run_folder_at(run_folder("cup/01")));
  EXPECT_EQ(info.object, "cup");
  EXPECT_EQ(info.run, "01");
  EXPECT_TRUE(info.complete);
  EXPECT_EQ(this->run("info --check data").exit_code, 0);
}

TEST_F(ImportCommand, CorrectsNamesAndSaysSo) {
  const auto result = run("import recordings/dv-lz4.aedat4 --object 'Water Bottle' --run 1");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("'Water Bottle' is named water-bottle.\n'1' is named 01.\n"), std::string::npos) << result.out;
  EXPECT_TRUE(fs::exists(run_folder("water-bottle/01/events.aedat4")));
  const auto json = json_of("import recordings/dv-zstd.aedat4 --object water_bottle --run 3");
  EXPECT_EQ(json.at("renamed"),
            nlohmann::json({{{"given", "water_bottle"}, {"used", "water-bottle"}}, {{"given", "3"}, {"used", "03"}}}));
  EXPECT_TRUE(fs::exists(run_folder("water-bottle/03/events.aedat4")));
  EXPECT_EQ(json_of("import recordings/dv-none.aedat4 --object water-bottle").at("runs").at(0).at("run"), "water-bottle/04");
  const auto nameless = run("import recordings/dv-lz4.aedat4 --object '!?'");
  EXPECT_EQ(nameless.exit_code, 1);
  EXPECT_NE(nameless.err.find("'!?'"), std::string::npos) << nameless.err;
  EXPECT_GE(run("import recordings/dv-lz4.aedat4 --object cup --run 0").exit_code, 100);
  EXPECT_GE(run("import recordings/dv-lz4.aedat4 --object cup --run 100").exit_code, 100);
}

TEST_F(ImportCommand, OverwritesNoRunAndImportsNoRecordingTwice) {
  ASSERT_EQ(run("import recordings/dv-lz4.aedat4 --object cup --run 02").exit_code, 0);
  const std::string before = sha256_of_file(run_folder("cup/02/events.aedat4"));
  const auto taken = run("import recordings/dv-zstd.aedat4 --object cup --run 2");
  EXPECT_EQ(taken.exit_code, 1);
  EXPECT_NE(taken.err.find("data/cup/02: the run exists already"), std::string::npos) << taken.err;
  EXPECT_EQ(sha256_of_file(run_folder("cup/02/events.aedat4")), before);
  for (const char* number : {"", " --run 02", " --run 05"}) {
    const auto again = json_of(std::string("import recordings/dv-lz4.aedat4 --object cup") + number).at("runs").at(0);
    EXPECT_EQ(again.at("kept"), true) << number;
    EXPECT_EQ(again.at("run"), "cup/02") << number;
  }
  const auto elsewhere = run("import recordings/dv-lz4.aedat4 --object mug");
  EXPECT_EQ(elsewhere.exit_code, 1);
  EXPECT_NE(elsewhere.err.find("the same events would be there twice"), std::string::npos) << elsewhere.err;
  EXPECT_FALSE(fs::exists(run_folder("mug/01")));
}

TEST_F(ImportCommand, TakesWhatConvertReadsAndFoldersOfRecordings) {
  fs::create_directory(folder / "dv");
  fs::copy_file(folder / "recordings/dv-zstd.aedat4", folder / "dv/dvSave-2024_05_02.aedat4");
  fs::copy_file(folder / "recordings/dv-lz4.aedat4", folder / "dv/dvSave-2024_05_01.aedat4");
  write_whole(folder / "dv/notes.txt", "the second one is the mug");
  const auto json = json_of("import dv bags/run.bag --object cup --run 7");
  ASSERT_EQ(json.at("runs").size(), 3U);
  EXPECT_EQ(json.at("runs").at(0).at("recording"), "dv/dvSave-2024_05_01.aedat4");
  EXPECT_EQ(json.at("runs").at(0).at("run"), "cup/07");
  EXPECT_EQ(json.at("runs").at(1).at("recording"), "dv/dvSave-2024_05_02.aedat4");
  EXPECT_EQ(json.at("runs").at(2).at("recording"), "bags/run.bag");
  EXPECT_EQ(json.at("runs").at(2).at("run"), "cup/09");
  EXPECT_TRUE(fs::exists(run_folder("cup/09/robot.csv"))) << "a bag brings it";
  EXPECT_EQ(json.at("runs").at(2).at("robot"), "bags/run.bag");
  ASSERT_EQ(run("convert recordings/dv-lz4.aedat4 events.csv").exit_code, 0);
  const auto csv = json_of("import events.csv --object mug");
  EXPECT_EQ(csv.at("runs").at(0).at("events"), json.at("runs").at(0).at("events"));

  fs::create_directory(folder / "empty");
  const auto empty = run("import empty --object cup");
  EXPECT_EQ(empty.exit_code, 1);
  EXPECT_NE(empty.err.find("empty: has no recording"), std::string::npos) << empty.err;
  EXPECT_EQ(run("import nowhere.aedat4 --object cup").exit_code, 1);
  EXPECT_NE(run("import cam.mp4 --object cup").err.find("cam.mp4: is a film; expected a recording"), std::string::npos);
}

TEST_F(ImportCommand, TakesRobotLogAndFilmAndNamesWhatIsLacking) {
  ASSERT_EQ(run("simulate sim --preset tiny --objects fan --runs 1").exit_code, 0);
  fs::create_directory(folder / "loose");
  for (const auto& [from, to] : {std::pair("events.aedat4", "take.aedat4"), std::pair("robot.csv", "ur10.csv"),
                                 std::pair("video.mp4", "cam.mp4"), std::pair("video.csv", "cam.csv")})
    fs::copy_file(folder / "sim/fan/01" / from, folder / "loose" / to);
  const auto whole = run("import loose/take.aedat4 --object fan --robot loose/ur10.csv --video loose/cam.mp4");
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  EXPECT_EQ(whole.out.find("has no"), std::string::npos) << whole.out;
  EXPECT_NE(whole.out.find("Next: tactile label data/fan\n"), std::string::npos) << whole.out;
  for (const char* file : {"events.aedat4", "robot.csv", "video.mp4", "video.csv"})
    EXPECT_EQ(sha256_of_file(run_folder("fan/01") / file), sha256_of_file(folder / "sim/fan/01" / file)) << file;
  EXPECT_EQ(run("label data/fan").exit_code, 0);

  fs::remove(folder / "loose/cam.csv");
  const auto film_alone = run("import loose/take.aedat4 --object fan --out film --robot loose/ur10.csv --video loose/cam.mp4");
  EXPECT_EQ(film_alone.out.find("has no"), std::string::npos) << film_alone.out;
  EXPECT_NE(film_alone.out.find("cam.mp4, no times"), std::string::npos) << film_alone.out;
  EXPECT_NE(run("info film/fan/01").out.find("a film with its own times only"), std::string::npos);
  const auto shared =
      run("import recordings/dv-lz4.aedat4 recordings/dv-zstd.aedat4 --object cup --out shared --robot loose/ur10.csv");
  EXPECT_NE(shared.err.find("2 recordings get the same robot log (loose/ur10.csv)"), std::string::npos) << shared.err;

  const auto bare = run("import loose/take.aedat4 --object fan --out other");
  EXPECT_NE(bare.out.find("fan/01 has no robot log and no film. 'tactile label' finds the lift by the IMU."), std::string::npos)
      << bare.out;
  const auto json = json_of("import recordings/dv-events-only.aedat4 --object cup --out third");
  EXPECT_EQ(json.at("runs").at(0).at("lacks"), nlohmann::json({"robot log", "IMU", "film"}));
  const auto alone = run("import recordings/dv-events-only.aedat4 --object cup --out third");
  EXPECT_NE(alone.out.find("cup/01 has no robot log, no IMU and no film."), std::string::npos) << alone.out;
}

TEST_F(ImportCommand, FindsRobotLogAndFilmOfTheSameName) {
  ASSERT_EQ(run("simulate sim --preset tiny --objects fan --runs 2").exit_code, 0);
  fs::create_directory(folder / "loose");
  for (const char* number : {"01", "02"}) {
    const fs::path from = folder / "sim/fan" / number, to = folder / "loose" / (std::string("take-") + number);
    fs::copy_file(from / "events.aedat4", to.string() + ".aedat4");
    fs::copy_file(from / "robot.csv", to.string() + ".robot.csv");
    fs::copy_file(from / "video.mp4", to.string() + ".mp4");
    fs::copy_file(from / "video.csv", to.string() + ".csv");
  }
  const auto runs = json_of("import loose --object fan").at("runs");
  ASSERT_EQ(runs.size(), 2U);
  EXPECT_EQ(runs.at(1).at("robot"), "loose/take-02.robot.csv");
  EXPECT_EQ(runs.at(1).at("film"), "loose/take-02.mp4");
  for (const char* file : {"robot.csv", "video.mp4", "video.csv"})
    EXPECT_EQ(sha256_of_file(run_folder("fan/02") / file), sha256_of_file(folder / "sim/fan/02" / file)) << file;

  // A table of the same name is a robot log only if it has one's times.
  fs::rename(folder / "loose/take-01.robot.csv", folder / "loose/take-01.csv");
  fs::remove(folder / "loose/take-01.mp4");
  EXPECT_EQ(json_of("import loose/take-01.aedat4 --object fan --out log").at("runs").at(0).at("robot"), "loose/take-01.csv");
  write_whole(folder / "loose/take-01.csv", "timestamp,x,y,polarity\n1,2,3,1\n");
  EXPECT_TRUE(json_of("import loose/take-01.aedat4 --object fan --out table").at("runs").at(0).at("robot").is_null());
}

TEST_F(ImportCommand, FindsTheOnlyRobotLogWhoseNameBeginsLikeTheRecording) {
  ASSERT_EQ(run("simulate sim --preset tiny --objects fan --runs 2").exit_code, 0);
  fs::create_directory(folder / "loose");
  for (const auto& [number, name] : {std::pair("01", "take 1"), std::pair("02", "take 1 again")}) {
    fs::copy_file(folder / "sim/fan" / number / "events.aedat4", folder / "loose" / (std::string(name) + ".aedat4"));
    fs::copy_file(folder / "sim/fan" / number / "robot.csv", folder / "loose" / (std::string(name) + " rtde.csv"));
  }
  const auto robot_of = [&](const std::string& recording, const std::string& out) {
    return json_of("import 'loose/" + recording + ".aedat4' --object fan --out " + out).at("runs").at(0).at("robot");
  };
  EXPECT_EQ(robot_of("take 1", "a"), "loose/take 1 rtde.csv") << "the other log is that of 'take 1 again'";
  EXPECT_EQ(robot_of("take 1 again", "a"), "loose/take 1 again rtde.csv");
  write_whole(folder / "loose/take 1_notes.csv", "a,b\n1,2\n");
  write_whole(folder / "loose/take 1 rtde.png", "a plot of it");
  EXPECT_EQ(robot_of("take 1", "b"), "loose/take 1 rtde.csv");
  fs::copy_file(folder / "sim/fan/02/robot.csv", folder / "loose/take 1_other.csv");
  EXPECT_TRUE(robot_of("take 1", "c").is_null()) << "two logs may be meant";
}

TEST_F(ImportCommand, ImportsTheOtherRecordingsOfAFolderWhereOneCannotBe) {
  fs::create_directory(folder / "loose");
  fs::copy_file(folder / "recordings/dv-zstd.aedat4", folder / "loose/b.aedat4");
  write_whole(folder / "loose/a.aedat4", "no recording");
  write_whole(folder / "loose/c.aedat4", "nor this");
  const auto result = run("import loose --object cup --json");
  EXPECT_EQ(result.exit_code, 1);
  const auto json = nlohmann::json::parse(result.out);
  ASSERT_EQ(json.at("runs").size(), 1U);
  EXPECT_EQ(json.at("runs").at(0).at("recording"), "loose/b.aedat4");
  ASSERT_EQ(json.at("errors").size(), 2U);
  for (const char* file : {"loose/a.aedat4", "loose/c.aedat4"}) EXPECT_NE(result.err.find(file), std::string::npos) << result.err;
  const auto numbered = run("import loose --object cup --run 5 --out other");
  EXPECT_NE(numbered.out.find("cup/06"), std::string::npos) << numbered.out << "a.aedat4 keeps its number";
  EXPECT_NE(numbered.out.find("1 of 3 imported, 0 of 1 healthy, 1 too short for a run"), std::string::npos) << numbered.out;
}

/// Each camera becomes a run of its own, with its own streams, that other commands take without a choice.
TEST_F(ImportCommand, MakesARunOfTheChosenCameraOfTwo) {
  test::write_two_cameras(folder / "two.aedat4");
  const auto unchosen = run("import two.aedat4 --object cup");
  EXPECT_EQ(unchosen.exit_code, 1);
  EXPECT_NE(unchosen.err.find("has 2 event streams; expected a choice of 0 (A), 4 (B)"), std::string::npos) << unchosen.err;
  for (const auto& [choice, name, count, ids] :
       {std::tuple("B", "cup/01", 20U, std::pair(4, 6)), std::tuple("0", "cup/02", 30U, std::pair(0, 2))}) {
    const auto made = json_of(std::string("import two.aedat4 --object cup --stream ") + choice).at("runs").at(0);
    EXPECT_EQ(made.at("run"), name);
    EXPECT_EQ(made.at("events"), count);
    EXPECT_EQ(made.at("healthy"), true) << made;
    const events::RecordingReader recording(run_folder(name) / "events.aedat4");
    ASSERT_EQ(recording.streams().size(), 2U);
    EXPECT_EQ(recording.streams()[0].id, ids.first);
    EXPECT_EQ(recording.streams()[1].id, ids.second);
    EXPECT_EQ(json_of(std::string("import two.aedat4 --object cup --stream ") + choice).at("runs").at(0).at("kept"), true);
  }
  EXPECT_EQ(run("info --check data").exit_code, 0);
}

/// A file can be sound, and too short for a run all the same.
TEST_F(ImportCommand, NamesARecordingThatIsTooShortForARun) {
  const auto made = [&](const std::string& name, std::int64_t last_us) {
    const std::vector<events::Event> events{test::event_at(0), test::event_at(last_us, 1)};
    test::write_plain_recording(folder / (name + ".aedat4"), events, {64, 48});
    return run("import " + name + ".aedat4 --object " + name);
  };
  const auto brief = made("brief", 99), enough = made("enough", 154'000);
  EXPECT_EQ(brief.exit_code, 0) << brief.err;
  EXPECT_NE(brief.out.find("0 of 1 healthy, 1 too short for a run"), std::string::npos) << brief.out;
  EXPECT_EQ(brief.out.find("Next:"), std::string::npos) << brief.out;
  EXPECT_NE(brief.err.find("brief/01: lasts 99 us, too short for a run; expected 154.0 ms or more"), std::string::npos)
      << brief.err;
  EXPECT_EQ(enough.out.find("too short"), std::string::npos) << enough.out;
  EXPECT_NE(enough.out.find("1 of 1 healthy"), std::string::npos) << enough.out;
  EXPECT_NE(enough.out.find("Next: tactile label"), std::string::npos) << enough.out;
}

TEST_F(ImportCommand, EndsWithTwoIfARunIsNotHealthy) {
  const std::string whole = read_text(folder / "recordings/dv-lz4.aedat4");
  write_whole(folder / "cut.aedat4", whole.substr(0, whole.size() * 3 / 4));
  const auto result = run("import cut.aedat4 recordings/dv-zstd.aedat4 --object cup --json");
  EXPECT_EQ(result.exit_code, 2) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("runs").at(0).at("healthy"), false);
  EXPECT_FALSE(json.at("runs").at(0).at("reasons").empty());
  EXPECT_EQ(json.at("runs").at(1).at("healthy"), true);
  EXPECT_TRUE(fs::exists(run_folder("cup/01/events.aedat4")));
}

}  // namespace
}  // namespace tactile::splitting
