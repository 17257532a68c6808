#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "events/made_recording.hpp"
#include "power/cuts.hpp"
#include "robot/fake_controller.hpp"
#include "support/paths.hpp"
#include "support/power_cut.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/robot/robot_log.hpp"
#include "tactile/video/video_times.hpp"
#include "video/made_film.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;
using test::run_tactile;

constexpr events::SensorSize size{640, 480};
const std::string run_path = "data/fan/01/";

/// The bytes of the packets of a recording, by the position of their ends.
std::map<std::uint64_t, std::string> stored_packets(const fs::path& file) {
  const std::string bytes = read_text(file);
  std::map<std::uint64_t, std::string> packets;
  for (const events::PacketRecord& packet : test::packets_of(file)) {
    const std::uint64_t begin = packet.payload_offset - 8, end = packet.payload_offset + packet.payload_size;
    packets[end] = bytes.substr(begin, end - begin);
  }
  return packets;
}

std::size_t rows_in(const std::string& csv) { return static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')); }

/// The times of the frames of a film; none before its first fragment.
std::vector<VideoTime> times_of_frames(const fs::path& film) {
  try {
    return test::decoded_times(film);
  } catch (const std::runtime_error&) {
    return {};
  }
}

/// The journal of `record` that records events, robot and video for some seconds.
class RecordingAfterPowerCut : public testing::Test {
 protected:
  using Files = std::map<std::string, std::string>;  ///< contents, by name

  void SetUp() override {
    fs::create_directories(root());
    {
      events::RecordingWriter writer(folder / "long.aedat4", {events::event_stream_declaration(size, "DVXplorer_DXM00001")});
      writer.write_events(0, test::steady_events(200'000, 1'000'000, 20, size));
      writer.close();
    }
    test::write_film(folder / "film.mp4", test::uneven_times(150, 33'333us));
    test::FakeController controller;
    journal = test::journal_of(
        test::tactile_command("record --object fan --from file:../long.aedat4 --video ../film.mp4 --robot 127.0.0.1:" +
                              std::to_string(controller.port())),
        root());
    if (!journal) return;
    recorded = stored_packets(run() / "events.aedat4");
    filmed = test::decoded_times(run() / "video.mp4");
  }

  fs::path root() const { return folder / "lab"; }
  fs::path run() const { return root() / "data/fan/01"; }

  /// The synced contents of the files of the run, which must be in the image.
  static Files synced_files(const test::PowerCut& cut, std::size_t moment, const test::FolderImage& image) {
    Files synced;
    for (const char* name : {"events.aedat4", "robot.csv", "video.mp4", "video.csv"}) {
      const std::optional<std::string> content = cut.synced(run_path + name, moment);
      // The names of all files are on the disk when the recording is synced for the first time.
      if (!content || (!synced.contains("events.aedat4") && std::string_view(name) != "events.aedat4")) continue;
      synced[name] = *content;
      const auto found = image.find(run_path + name);
      EXPECT_NE(found, image.end()) << name << " was synced, but is not there";
      // The header of the recording is written again at the end.
      if (found == image.end() || std::string_view(name) == "events.aedat4") continue;
      EXPECT_TRUE(found->second->starts_with(*content)) << name << " has lost bytes that were synced";
    }
    return synced;
  }

  /// `info --check` of the run that was cut: synced packets are undamaged, and packets that are reported as damaged are.
  void expect_checksums_agree(const test::FolderImage& image, const fs::path& place, std::size_t packets_synced) {
    const test::CommandResult info = run_tactile("info --check --json data/fan/01", place);
    EXPECT_EQ(info.exit_code, 2) << info.err;
    const nlohmann::json checksums = nlohmann::json::parse(info.out).at("recordings").at(0).at("checksums");
    ASSERT_FALSE(checksums.is_null());
    EXPECT_FALSE(checksums.at("header_damaged"));
    EXPECT_GE(checksums.at("whole").get<std::size_t>() + checksums.at("not_covered").get<std::size_t>(), packets_synced);
    covered += checksums.at("whole").get<std::size_t>();
    damaged += checksums.at("damaged").get<std::size_t>();
    for (const nlohmann::json& packet : checksums.at("first_damaged")) {
      const auto position = packet.at("position").get<std::uint64_t>();
      const auto written = recorded.upper_bound(position);
      ASSERT_NE(written, recorded.end());
      EXPECT_NE(image.at(run_path + "events.aedat4")->substr(position, written->second.size()), written->second)
          << "an undamaged packet is reported as damaged, at byte " << position;
    }
  }

  /// The repaired recording has all packets of the first `synced_bytes`, and only packets that were recorded, in their order.
  void expect_packets_kept(const fs::path& recording, std::size_t synced_bytes) const {
    const auto kept = stored_packets(recording);
    auto next = recorded.begin();
    for (const auto& [end, packet] : kept) {
      next = std::find_if(next, recorded.end(), [&](const auto& each) { return each.second == packet; });
      ASSERT_NE(next, recorded.end()) << "the repaired run has a packet that was not recorded";
      ++next;
    }
    auto of_kept = kept.begin();
    for (const auto& [end, packet] : recorded) {
      if (end > synced_bytes) break;
      ASSERT_NE(of_kept, kept.end()) << "a packet that was synced is lost";
      ASSERT_EQ((of_kept++)->second, packet) << "the packet that ends at byte " << end;
    }
  }

  /// The repaired run has all synced rows of the robot, and all synced frames with their times.
  void expect_robot_and_video_kept(const fs::path& place, Files& synced) {
    const fs::path repaired_run = place / "data/fan/02";
    if (const std::size_t rows = rows_in(synced["robot.csv"]); rows > 2) {
      EXPECT_GE(robot::read_robot_log(repaired_run / "robot.csv").longest().states.size() + 1, rows);
      ++with_rows;
    }
    if (const std::size_t rows = rows_in(synced["video.csv"]); rows > 2) {
      EXPECT_GE(video::read_video_times(repaired_run / "video.csv").size() + 1, rows);
      test::write_image({{"synced.mp4", synced["video.mp4"]}}, place);
      const std::vector<VideoTime> expected = times_of_frames(place / "synced.mp4"),
                                   found = times_of_frames(repaired_run / "video.mp4");
      ASSERT_GE(found.size(), expected.size());
      EXPECT_TRUE(std::equal(expected.begin(), expected.end(), filmed.begin()));
      EXPECT_TRUE(std::equal(expected.begin(), expected.end(), found.begin()));
      with_film += expected.empty() ? 0 : 1;
    }
  }

  test::TemporaryFolder folder;
  std::optional<test::WrittenJournal> journal;
  std::map<std::uint64_t, std::string> recorded;  ///< packets
  std::vector<VideoTime> filmed;
  std::size_t complete = 0, repaired = 0, covered = 0, damaged = 0, with_film = 0, with_rows = 0;
};

TEST_F(RecordingAfterPowerCut, HasEverythingThatWasSynced) {
  REQUIRE_JOURNAL(journal);
  const test::PowerCut cut(*journal);
  const test::FolderImage whole = cut.whole();
  test::expect_complete(*journal, whole, root());
  ASSERT_GT(cut.syncs_of(run_path + "events.aedat4", journal->entries.size()), 3U) << "the recording takes four seconds";

  const std::uint64_t seed = test::power_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (const std::size_t moment : cut.moments(test::power_cuts(60), random)) {
    SCOPED_TRACE("cut after entry " + std::to_string(moment) + " of " + std::to_string(journal->entries.size()));
    const test::FolderImage image = cut.after(moment, &random);
    const test::TemporaryFolder place;
    test::write_image(image, place.path());
    Files synced = synced_files(cut, moment, image);
    if (!image.contains(run_path + "run.json")) {
      EXPECT_FALSE(synced.contains("events.aedat4"));
      continue;
    }
    if (read_run_info({place / "data/fan/01", "fan", "01"}).complete) {
      ++complete;
      EXPECT_EQ(run_tactile("info --check data/fan/01", place.path()).exit_code, 0);
      for (const auto& [path, content] : whole) EXPECT_EQ(image.at(path), content) << path;
      continue;
    }

    const std::size_t synced_bytes = synced["events.aedat4"].size();
    const auto packets_synced = static_cast<std::size_t>(
        std::count_if(recorded.begin(), recorded.end(), [&](const auto& packet) { return packet.first <= synced_bytes; }));
    const test::CommandResult repair = run_tactile("repair data/fan/01 data/fan/02", place.path());
    if (repair.exit_code != 0) {
      EXPECT_EQ(packets_synced, 0U) << repair.err;
      EXPECT_EQ(repair.exit_code, 1) << repair.err;
      continue;
    }
    ++repaired;
    expect_checksums_agree(image, place.path(), packets_synced);
    const test::CommandResult check = run_tactile("info --check data/fan/02", place.path());
    EXPECT_EQ(check.exit_code, 0) << check.err;
    expect_packets_kept(place / "data/fan/02/events.aedat4", synced_bytes);
    expect_robot_and_video_kept(place.path(), synced);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(complete, 0U);
  EXPECT_GT(repaired, 10U);
  EXPECT_GT(covered, 100 * repaired / 2) << "most packets lack a checksum";
  EXPECT_GT(with_rows, 5U);
  EXPECT_GT(with_film, 5U);
  EXPECT_GT(damaged, 0U) << "no cut left a packet with a wrong checksum";
}

}  // namespace
}  // namespace tactile::cli
