#include "tactile/conversion/bag_import.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <fstream>
#include <sstream>

#include "events/recording_contents.hpp"
#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/conversion/imported_files.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_health.hpp"
#include "tactile/robot/robot_log.hpp"
#include "tactile/video/video_times.hpp"

namespace tactile::conversion {
namespace {

namespace fs = std::filesystem;
const fs::path bags = fs::path(test::data_folder) / "bags";
constexpr std::int64_t start_us = 1'700'000'000'000'000;

nlohmann::json truth_of(const std::string& bag) { return read_json(bags / "truth.json").at(bag + ".bag"); }

void expect_events(const fs::path& recording, const nlohmann::json& truth) {
  const test::RecordingContents contents = test::contents_of(recording);
  EXPECT_EQ(contents.events.size(), truth.at("events"));
  EXPECT_EQ(truth.at("digest"), contents.event_digest());
  EXPECT_EQ(us_of(contents.events.front().t), truth.at("first_us"));
  EXPECT_EQ(us_of(contents.events.back().t), truth.at("last_us"));
  EXPECT_TRUE(events::examine_recording(recording).healthy());
}

std::string import_refusal_of(const std::string& bag, const BagImportOptions& options = {}) {
  const test::TemporaryFolder folder;
  try {
    import_bag(bags / (bag + ".bag"), folder / "fan/01", options);
  } catch (const Error& e) {
    EXPECT_FALSE(fs::exists(folder / "fan/01"));
    return e.what();
  }
  ADD_FAILURE() << bag << " was taken";
  return {};
}

TEST(ImportBag, MakesTheSameRunFromEveryCompression) {
  const test::TemporaryFolder folder;
  std::vector<std::string> hashes;
  for (const char* name : {"run", "run-lz4", "run-bz2"}) {
    const fs::path out = folder / name / "fan" / "01";
    const BagImportSummary summary = import_bag(bags / (std::string(name) + ".bag"), out);
    const nlohmann::json truth = truth_of(name);
    EXPECT_EQ(summary.events, truth.at("events"));
    EXPECT_EQ(summary.robot_states, truth.at("poses"));
    EXPECT_EQ(summary.frames, truth.at("frames"));
    EXPECT_EQ(summary.imu_samples, truth.at("imu"));
    EXPECT_TRUE(summary.has_joints);
    EXPECT_TRUE(summary.warnings.empty());
    EXPECT_EQ(summary.drops.events + summary.drops.broken_messages + summary.drops.frames + summary.drops.robot_states, 0U);
    expect_events(out / "events.aedat4", truth);
    std::string hash;
    for (const char* file : {"events.aedat4", "robot.csv", "video.mp4", "video.csv"}) hash += sha256_of_file(out / file);
    hashes.push_back(hash);
  }
  EXPECT_EQ(hashes.at(0), hashes.at(1));
  EXPECT_EQ(hashes.at(0), hashes.at(2));
}

TEST(ImportBag, MakesTheSameRunFromEveryFormOfRos2) {
  const test::TemporaryFolder folder;
  const nlohmann::json truth = truth_of("run");
  import_bag(bags / "run.bag", folder / "ros1/fan/01");
  for (const char* name : {"run-file.db3.zstd", "run-message.db3", "run-lz4.mcap", "run-zstd.mcap"}) {
    const fs::path out = folder / name / "fan" / "01";
    const BagImportSummary summary = import_bag(bags / name, out);
    EXPECT_EQ(summary.imu_samples, truth.at("imu")) << name;
    EXPECT_TRUE(summary.has_joints) << name;
    EXPECT_EQ(summary.drops.events + summary.drops.broken_messages + summary.drops.frames + summary.drops.robot_states, 0U);
    expect_events(out / "events.aedat4", truth);
    for (const char* file : {"robot.csv", "video.mp4", "video.csv"})
      EXPECT_EQ(sha256_of_file(out / file), sha256_of_file(folder / "ros1/fan/01" / file)) << name;
    EXPECT_EQ(read_json(out / "run.json").at("bag").at("format"), summary.format);
  }
}

TEST(ImportBag, JoinsTheFilesOfAFolderInTheOrderOfTheirNumbers) {
  const test::TemporaryFolder folder;
  fs::create_directory(folder / "trip");
  fs::copy(bags / "run-lz4.mcap", folder / "trip/trip_9.mcap");
  fs::copy(bags / "run-zstd.mcap", folder / "trip/trip_10.mcap");
  const BagImportSummary summary = import_bag(folder / "trip", folder / "fan/01");
  EXPECT_EQ(summary.events + summary.drops.late_events, 6'000U);  // the second file goes back in time
  EXPECT_EQ(summary.drops.imu_samples, 20U);
  const nlohmann::json files = read_json(folder / "fan/01/run.json").at("bag").at("files");
  EXPECT_EQ(files.at("trip_9.mcap").at("sha256"), sha256_of_file(bags / "run-lz4.mcap"));
}

class ImportedRun : public testing::Test {
 protected:
  ImportedRun() { import_bag(bags / "run.bag", run); }
  test::TemporaryFolder folder;
  fs::path run = folder / "fan/01";
};

TEST_F(ImportedRun, HasARobotLogWithPoseJointsAndTheSpeedThatFollows) {
  const robot::RobotLog log = robot::read_robot_log(run / "robot.csv").longest();
  ASSERT_EQ(log.states.size(), 126U);
  for (std::size_t i = 0; i < log.states.size(); ++i) {
    const robot::RobotState& state = log.states.at(i);
    const double s = 0.008 * static_cast<double>(i);
    EXPECT_EQ(us_of(state.t), start_us + 8'000 * static_cast<std::int64_t>(i));
    EXPECT_NEAR(state.tcp_pose.at(2), 0.2 + 0.05 * s, 1e-9);
    EXPECT_NEAR(state.tcp_pose.at(5), 0.3 * s, 1e-9);
    EXPECT_NEAR(state.tcp_speed.at(2), 0.05, 1e-6);
    EXPECT_NEAR(state.tcp_speed.at(5), 0.3, 1e-6);
    EXPECT_NEAR(state.tcp_speed.at(0), 0, 1e-9);
  }
  std::ifstream file(run / "robot.csv");
  std::string header, first, second;
  std::getline(file, header);
  std::getline(file, first);
  std::getline(file, second);
  EXPECT_TRUE(header.starts_with("timestamp,actual_q_0,actual_q_1,")) << header;
  EXPECT_TRUE(header.ends_with(",host_time_us")) << header;
  // The bag's joints stand in ROS's order: elbow, lift, pan, wrists at 0.1, 0.2, 0.3, ... rad and 1 rad/s.
  const std::array expected{0.308, 0.208, 0.108, 0.408, 0.508, 0.608};
  for (const std::string& line : {first, second}) {  // in front of the first are the first known
    std::istringstream values(line);
    std::string value;
    std::getline(values, value, ',');
    for (const double joint : expected) {
      std::getline(values, value, ',');
      EXPECT_NEAR(std::stod(value), joint, 1e-9);
    }
  }
  EXPECT_TRUE(second.ends_with(",1700000000008400")) << second;
}

TEST_F(ImportedRun, HasAVideoWithTheFramesOwnTimes) {
  std::vector<std::int64_t> times;
  for (const VideoTime t : video::read_video_times(run / "video.csv")) times.push_back(us_of(t));
  EXPECT_EQ(times, (std::vector<std::int64_t>{0, 33'333, 66'667, 133'333, 166'667, 200'000}));
  EXPECT_TRUE(
      read_text(run / "video.csv").starts_with("index,pts_us,host_time_us\n0,0,1700000000009000\n1,33333,1700000000042333\n"));
  EXPECT_EQ(read_json(run / "run.json").at("video_start_us"), start_us);
}

TEST_F(ImportedRun, HasTheImuInTheCamerasUnits) {
  const test::RecordingContents contents = test::contents_of(run / "events.aedat4");
  ASSERT_EQ(contents.imu.size(), 20U);
  EXPECT_EQ(us_of(contents.imu.at(3).t), start_us + 15'000);
  EXPECT_FLOAT_EQ(contents.imu.at(3).acceleration_g[2], 1);
  EXPECT_FLOAT_EQ(contents.imu.at(3).angular_rate_dps[2], 3);
}

TEST_F(ImportedRun, NamesItsBagInRunJson) {
  const nlohmann::json info = read_json(run / "run.json");
  EXPECT_EQ(info.at("object"), "fan");
  EXPECT_EQ(info.at("run"), "01");
  EXPECT_EQ(info.at("simulated"), false);
  EXPECT_EQ(info.at("complete"), true);
  EXPECT_EQ(info.at("sensor").at("width"), 160);
  EXPECT_EQ(info.at("robot_clock"), "host");
  EXPECT_EQ(info.at("robot_speed"), "differences of the pose");
  EXPECT_EQ(info.at("bag").at("sha256"), sha256_of_file(bags / "run.bag"));
  EXPECT_EQ(info.at("bag").at("topics").at("events"), "/dvs/events");
  EXPECT_EQ(info.at("host_time_us").at("begin"), start_us + 100);
  EXPECT_EQ(info.at("dropped").at("events"), 0);
  EXPECT_EQ(info.at("dropped").at("late_events"), 0);
  EXPECT_EQ(info.at("bag").at("problems").at("truncated_bytes"), 0);
  EXPECT_EQ(info.at("files").size(), 4U);
  for (const auto& [name, file] : info.at("files").items()) {
    EXPECT_EQ(file.at("sha256"), sha256_of_file(run / name));
    EXPECT_EQ(file.at("bytes"), fs::file_size(run / name));
  }
}

TEST(ImportedRobotLog, LeavesOutPosesThatNoArmComesTo) {
  const test::TemporaryFolder folder;
  ImportedRobotLog log(folder / "robot.csv", {});
  const auto pose = [](std::int64_t us, double x, std::array<double, 4> turn = {0, 0, 0, 1}) {
    return ToolPose{.t = HostTime{microseconds{us}}, .place = {x, 0, 0}, .turn = turn};
  };
  const auto add = [&](const ToolPose& one) { return log.add(one, one.t); };
  EXPECT_FALSE(add(pose(1'000'000, -1e242)));
  EXPECT_TRUE(add(pose(1'000'000, 0.1)));
  EXPECT_FALSE(add(pose(1'008'000, 1e5))) << "in 8 ms";
  EXPECT_FALSE(add(pose(1'000'001, 0.1, {1, 0, 0, 0}))) << "half a turn in a microsecond";
  EXPECT_TRUE(add(pose(1'016'000, 0.2)));
  EXPECT_TRUE(add(pose(1'016'001, 1.1))) << "as fast as can be";
  EXPECT_TRUE(add(pose(1'016'002, 0.2)));
  log.close();
  EXPECT_EQ(log.rows(), 4U);
  EXPECT_EQ(robot::read_robot_log(folder / "robot.csv").longest().states.size(), 4U);
}

TEST(ImportBag, ReadsEveryEncodingAndCountsWhatTheSequenceMisses) {
  for (const char* name : {"libcaer", "libcaer_cmp", "mono"}) {
    const test::TemporaryFolder folder;
    const BagImportSummary summary = import_bag(bags / (std::string(name) + ".bag"), folder / "fan/01");
    expect_events(folder / "fan/01/events.aedat4", truth_of(name));
    EXPECT_EQ(summary.drops.event_packets, truth_of(name).at("lost")) << name;
    const nlohmann::json info = read_json(folder / "fan/01/run.json");
    EXPECT_EQ(info.at("dropped").at("event_packets"), 1);
    EXPECT_EQ(info.at("camera").at("encoding"), name);
    EXPECT_FALSE(info.contains("robot_clock"));
    EXPECT_FALSE(fs::exists(folder / "fan/01/robot.csv"));
  }
}

TEST(ImportBag, SortsMessagesThatOverlap) {
  const test::TemporaryFolder folder;
  const BagImportSummary summary = import_bag(bags / "overlapping.bag", folder / "fan/01");
  expect_events(folder / "fan/01/events.aedat4", truth_of("overlapping"));
  EXPECT_GT(summary.sorted_events, 0U);
  EXPECT_EQ(summary.drops.late_events, 0U);
}

TEST(ImportBag, RequiresAChoiceAmongSeveralEventTopics) {
  const std::string message = import_refusal_of("two-cameras");
  EXPECT_NE(message.find("/left/events, /right/events; expected a choice by --events-topic"), std::string::npos) << message;
  const test::TemporaryFolder folder;
  EXPECT_EQ(import_bag(bags / "two-cameras.bag", folder / "fan/01", {.events_topic = "/right/events"}).events, 50U);
  EXPECT_NE(import_refusal_of("two-cameras", {.events_topic = "/up/events"}).find("has no topic /up/events with events"),
            std::string::npos);
}

TEST(ImportBag, OmitsADeselectedTopic) {
  const test::TemporaryFolder folder;
  import_bag(bags / "run.bag", folder / "fan/01", {.joints_topic = "none", .video_topic = "none", .imu_topic = "none"});
  EXPECT_FALSE(fs::exists(folder / "fan/01/video.mp4"));
  EXPECT_TRUE(read_text(folder / "fan/01/robot.csv").starts_with("timestamp,actual_TCP_pose_0,"));
  EXPECT_EQ(events::RecordingReader(folder / "fan/01/events.aedat4").streams().size(), 1U);
  EXPECT_NE(import_refusal_of("run", {.events_topic = "none"}).find("--events-topic"), std::string::npos);
}

TEST(ImportBag, ReportsWhatABagLacks) {
  EXPECT_NE(import_refusal_of("no-events").find("no topic has events"), std::string::npos);
  EXPECT_NE(import_refusal_of("evt2").find("encoded as 'evt2'; expected libcaer, libcaer_cmp, mono or evt3"), std::string::npos);
}

TEST(ImportBag, NamesADefinitionThatItDoesNotKnow) {
  const test::TemporaryFolder folder;
  std::string bytes = read_text(bags / "two-cameras.bag");
  const std::string known = "5e8beee5a6c107e504c2e78903c224b8";
  for (std::size_t at = bytes.find(known); at != std::string::npos; at = bytes.find(known, at)) bytes[at] = '0';
  write_whole(folder / "other.bag", bytes);
  try {
    import_bag(folder / "other.bag", folder / "fan/01");
    ADD_FAILURE() << "it was taken";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("a definition of dvs_msgs/EventArray that is not known"), std::string::npos) << e.what();
  }
}

TEST(ImportBag, ReadsACutBagUpToTheCutAndReportsIt) {
  const test::TemporaryFolder folder;
  const std::string bytes = read_text(bags / "run.bag");
  // The records of its chunk alone, as a bag without chunks has them: the chunk follows magic and bag header, 13 + 4096 bytes.
  std::uint32_t header_size = 0;
  std::memcpy(&header_size, &bytes.at(4109), 4);
  write_whole(folder / "flat.bag", "#ROSBAG V2.0\n" + bytes.substr(4109 + 4 + header_size + 4, 100'000));
  const BagImportSummary summary = import_bag(folder / "flat.bag", folder / "fan/01");
  EXPECT_GT(summary.events, 100U);
  EXPECT_LT(summary.events, 3'000U);
  EXPECT_GT(summary.problems.truncated_bytes, 0U);
  const nlohmann::json info = read_json(folder / "fan/01/run.json");
  EXPECT_EQ(info.at("complete"), false);
  EXPECT_EQ(info.at("bag").at("problems").at("truncated_bytes"), summary.problems.truncated_bytes);
}

/// The error for a bag of these bytes.
std::string refusal_of_bytes(const std::string& bytes, const BagImportOptions& options = {}) {
  const test::TemporaryFolder folder;
  write_whole(folder / "made.bag", bytes);
  try {
    import_bag(folder / "made.bag", folder / "fan/01", options);
  } catch (const Error& e) {
    return e.what();
  }
  ADD_FAILURE() << "it was taken";
  return {};
}

TEST(ImportBag, ReportsADamagedBagWithoutAnyMessage) {
  const std::string message = refusal_of_bytes(read_text(bags / "run.bag").substr(0, 4'200));
  EXPECT_NE(message.find("bytes cut off"), std::string::npos) << message;
}

/// The plain bag with every image's encoding replaced by another of its length.
std::string with_images_as(const std::string& encoding, const std::string& known) {
  std::string bytes = read_text(bags / "run.bag");
  for (std::size_t at = bytes.find(known); at != std::string::npos; at = bytes.find(known, at))
    bytes.replace(at, known.size(), encoding);
  return bytes;
}

TEST(ImportBag, RefusesImagesOfAnUnknownEncodingOnlyIfAskedByName) {
  const test::TemporaryFolder folder;
  const std::string bytes = with_images_as("mine", "rgb8");
  ASSERT_NE(bytes, read_text(bags / "run.bag"));
  write_whole(folder / "made.bag", bytes);
  EXPECT_EQ(import_bag(folder / "made.bag", folder / "fan/01").warnings.size(), 1U);
  EXPECT_FALSE(fs::exists(folder / "fan/01/video.mp4"));
  const std::string message = refusal_of_bytes(bytes, {.video_topic = "/camera/image_raw"});
  EXPECT_NE(message.find("topic /camera/image_raw has images encoded as 'mine', which is not known"), std::string::npos)
      << message;
}

TEST(ImportBag, CountsMessagesOfAnotherSensorApart) {
  const test::TemporaryFolder folder;
  std::string bytes = read_text(bags / "run.bag");
  const std::string size("\x78\0\0\0\xa0\0\0\0", 8);  // 120 rows of 160 pixels
  const std::size_t at = bytes.rfind(size);
  ASSERT_NE(at, std::string::npos);
  bytes[at] = 0x79;
  write_whole(folder / "made.bag", bytes);
  const BagImportSummary summary = import_bag(folder / "made.bag", folder / "fan/01");
  EXPECT_EQ(summary.drops.other_sensor_messages, 1U);
  EXPECT_EQ(summary.drops.broken_messages, 0U);
  EXPECT_EQ(read_json(folder / "fan/01/run.json").at("dropped").at("other_sensor_messages"), 1);
}

TEST(ImportBag, NeverTouchesARunThatIsThere) {
  const test::TemporaryFolder folder;
  fs::create_directories(folder / "fan/01");
  write_whole(folder / "fan/01/labels.json", "precious");
  EXPECT_THROW(import_bag(bags / "run.bag", folder / "fan/01"), Error);
  EXPECT_EQ(read_text(folder / "fan/01/labels.json"), "precious");
  for (const char* name : {"fan/1", "Fan/01", "fan/00", "run.aedat4"})
    EXPECT_THROW(import_bag(bags / "run.bag", folder / name), Error) << name;
  import_bag(bags / "run.bag", folder / "fan/02/");
  EXPECT_TRUE(fs::exists(folder / "fan/02/run.json"));
}

}  // namespace
}  // namespace tactile::conversion
