// What is left of a run whose recording is killed or fills the disk.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "apps/record_command.hpp"
#include "events/aedat4_bytes.hpp"
#include "events/made_recording.hpp"
#include "robot/fake_controller.hpp"
#include "support/comes_true.hpp"
#include "support/events_in_file.hpp"
#include "support/run_command.hpp"
#include "support/running_command.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/packet_checksums.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/robot/robot_log.hpp"
#include "transport/scripted_server.hpp"
#include "video/made_film.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;
using test::CommandResult;
using test::events_in_file;
using test::RecordCommand;
using test::RunningCommand;

TEST_F(RecordCommand, EndsWithOneOnAFullDiskAndKeepsWhatFits) {
  const std::vector<events::Event> sent = make_long_recording();
  const CommandResult result = test::run_shell("ulimit -f 500 && '" + std::string(test::tactile_binary) +
                                                   "' record --json --compression none --from file:long.aedat4 --speed 0",
                                               folder.path());
  EXPECT_EQ(result.exit_code, 1) << result.err;
  EXPECT_NE(result.err.find("data/unnamed/01/events.aedat4: cannot be written"), std::string::npos) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out).at("complete"), false);
  EXPECT_EQ(run_json("unnamed", "01").at("complete"), false);
  const std::vector<events::Event> kept = events_in_file(run_folder("unnamed", "01").events());
  EXPECT_GT(kept.size(), 10'000U);
  EXPECT_LT(kept.size(), sent.size());
  EXPECT_TRUE(std::equal(kept.begin(), kept.end(), sent.begin()));
}

std::size_t count_of(const std::string& bytes, const std::string& word) {
  std::size_t count = 0;
  for (std::size_t at = bytes.find(word); at != std::string::npos; at = bytes.find(word, at + 1)) ++count;
  return count;
}

std::size_t pieces_of_film(const RunFolder& run) {
  return fs::exists(run.video()) ? count_of(test::bytes_of(run.video()), "moof") : 0;
}

// The moments are counted in events and pieces of film that are in the files: a slow machine is killed later, not elsewhere.
TEST_F(RecordCommand, LeavesAReadableRunWheneverItIsKilled) {
  const std::vector<events::Event> sent = make_long_recording();
  test::write_film(folder / "film.mp4", test::uneven_times(600, 33'333us));
  test::FakeController controller;
  std::mt19937 random(20);
  std::size_t with_events = 0, with_film = 0;
  for (int moment = 1; moment <= 20; ++moment) {
    const std::string number = (moment < 10 ? "0" : "") + std::to_string(moment);
    const RunFolder run = run_folder("fan", number);
    std::size_t seen = 0;
    {
      RunningCommand command(
          "record --object fan --from file:long.aedat4 --video film.mp4 --robot 127.0.0.1:" + std::to_string(controller.port()),
          folder.path());
      ASSERT_TRUE(has_begun(run, command)) << command.err();
      const std::size_t events = random() % 40'000;
      const std::size_t film_pieces = moment % 4 == 0 ? 2 : 0;
      ASSERT_TRUE(test::comes_true([&] {
        seen = events_in_file(run.events()).size();
        return (seen >= events && pieces_of_film(run) >= film_pieces) || command.has_ended();
      }));
      std::this_thread::sleep_for(std::chrono::milliseconds(random() % 50));
      ASSERT_FALSE(command.has_ended()) << command.err();
    }  // SIGKILL
    const std::vector<events::Event> kept = events_in_file(run.events());
    EXPECT_GE(kept.size(), seen);
    EXPECT_TRUE(std::equal(kept.begin(), kept.end(), sent.begin()));
    with_events += kept.empty() ? 0 : 1;

    if (fs::exists(run.info())) {
      EXPECT_FALSE(read_run_info(run).complete);
    }
    if (fs::exists(run.robot()) && fs::file_size(run.robot()) > 5000) {
      EXPECT_FALSE(robot::read_robot_log(run.robot()).longest().states.empty());
    }
    if (pieces_of_film(run) >= 2) {
      EXPECT_FALSE(test::decoded_times(run.video()).empty());
      ++with_film;
    }
    const CommandResult check = test::run_tactile("info --check " + run.folder.string());
    EXPECT_EQ(check.exit_code, 2);
    if (!kept.empty()) {
      EXPECT_NE(check.err.find("the run was not completed"), std::string::npos) << check.err;
      const fs::path whole = folder / ("whole-" + number + ".aedat4");
      EXPECT_EQ(test::run_tactile("repair " + run.events().string() + " " + whole.string()).exit_code, 0);
      EXPECT_EQ(test::run_tactile("info --check " + whole.string()).exit_code, 0);
      EXPECT_EQ(events_in_file(whole), kept);
    }
  }
  EXPECT_GE(with_events, 15U) << "too few kills came while events were written";
  EXPECT_GE(with_film, 5U) << "too few kills came while a film was written";
}

TEST_F(RecordCommand, HasChecksumsNextToARecordingUntilItHasItsHash) {
  ASSERT_EQ(run("record --from file:recordings/dv-lz4.aedat4 --speed 0 --object fan").exit_code, 0);
  const RunFolder whole = run_folder("fan", "01"), killed = run_folder("fan", "02");
  EXPECT_FALSE(fs::exists(events::checksums_beside(whole.events())));

  make_long_recording();
  {
    RunningCommand command("record --object fan --compression none --from file:long.aedat4", folder.path());
    ASSERT_TRUE(has_begun(killed, command)) << command.err();
    ASSERT_TRUE(test::comes_true([&] { return events_in_file(killed.events()).size() > 10'000; }));
  }  // SIGKILL
  ASSERT_TRUE(fs::exists(events::checksums_beside(killed.events())));
  const auto check = [&] { return nlohmann::json::parse(run("info --check --json data/fan/02").out).at("recordings").at(0); };
  const nlohmann::json sound = check();
  const std::size_t packets = sound.at("checksums").at("whole");
  EXPECT_EQ(sound.at("checksums").at("damaged"), 0);
  EXPECT_LE(sound.at("checksums").at("not_covered"), 1) << "the last one, if it was killed before it wrote the checksum";

  std::string bytes = read_text(killed.events());
  bytes.at(test::event_offset(test::packets_of(killed.events()).at(2), 7) + 13) ^= 1;  // a polarity, which nothing else shows
  test::write_bytes(killed.events(), bytes);
  const CommandResult sick = run("info --check data/fan/02");
  EXPECT_EQ(sick.exit_code, 2);
  EXPECT_NE(sick.err.find("1 packet has a wrong checksum: packet 2 of stream 0"), std::string::npos) << sick.err;
  EXPECT_EQ(check().at("checksums").at("first_damaged").at(0).at("packet"), 2);
  EXPECT_TRUE(nlohmann::json::parse(run("info --json data/fan/02").out).at("recordings").at(0).at("checksums").is_null());

  const CommandResult repair = run("repair data/fan/02 data/fan/03");
  EXPECT_EQ(repair.exit_code, 0) << repair.err;
  EXPECT_NE(repair.out.find("1 packet changed, according to the checksums"), std::string::npos) << repair.out;
  EXPECT_EQ(run("info --check data/fan/03").exit_code, 0);
  EXPECT_FALSE(fs::exists(events::checksums_beside(run_folder("fan", "03").events())));
  EXPECT_GE(test::packets_of(run_folder("fan", "03").events()).size(), packets - 1);

  // A kill after run.json was written leaves them next to a recording that has its hash: they are no longer used.
  fs::copy_file(events::checksums_beside(killed.events()), events::checksums_beside(whole.events()));
  const CommandResult left = run("info --check --json data/fan/01");
  EXPECT_EQ(left.exit_code, 0) << left.err;
  EXPECT_TRUE(nlohmann::json::parse(left.out).at("recordings").at(0).at("checksums").is_null());
  EXPECT_EQ(run("repair data/fan/01 data/fan/04").exit_code, 0);
}

}  // namespace
}  // namespace tactile::cli
