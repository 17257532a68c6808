// Joints in a bag.

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <functional>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "support/paths.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/conversion/bag_import.hpp"
#include "tactile/conversion/ros_messages.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/table_file.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile::conversion {
namespace {

const std::filesystem::path plain_bag = std::filesystem::path(test::data_folder) / "bags" / "run.bag";

/// What becomes of a message of a topic; an empty one is left out.
using Alteration = std::function<std::string(const std::string& topic, std::string message)>;

/// The plain bag without its chunk's frame, with altered messages.
std::string altered_bag(const Alteration& alter) {
  const std::string bytes = read_text(plain_bag);
  std::size_t at = 13 + 4096;  // after magic and bag header
  const auto number = [](const std::string& text, std::size_t where) {
    std::uint32_t value = 0;
    std::memcpy(&value, &text.at(where), 4);
    return value;
  };
  const auto take = [&] {
    const std::uint32_t size = number(bytes, at);
    at += 4 + size;
    return bytes.substr(at - size, size);
  };
  const auto sized = [](const std::string& text) {
    const auto size = static_cast<std::uint32_t>(text.size());
    return std::string(reinterpret_cast<const char*>(&size), 4) + text;
  };
  take();  // the chunk's header
  const std::size_t end = at + 4 + number(bytes, at);
  at += 4;
  std::map<std::uint32_t, std::string> topics;
  std::string flat = "#ROSBAG V2.0\n";
  while (at < end) {
    const std::string header = take();
    std::string data = take();
    const std::uint32_t connection = number(header, header.find("conn=") + 5);
    const std::size_t topic = header.find("topic=");
    if (topic != std::string::npos) {
      topics[connection] = header.substr(topic + 6, number(header, topic - 4) - 6);
    } else if (data = alter(topics.at(connection), data); data.empty()) {
      continue;
    }
    flat += sized(header) + sized(data);
  }
  return flat;
}

/// A message of joints whose names have a prefix.
std::string with_prefix(std::string message, const std::string& prefix) {
  for (const std::string_view name : joint_names) {
    const std::size_t at = message.find(name);
    message.insert(at, prefix);
    message[at - 4] = static_cast<char>(name.size() + prefix.size());
  }
  return message;
}

TEST(ImportBag, MakesARobotLogOfJointsAlone) {
  const test::TemporaryFolder folder;
  write_whole(folder / "made.bag", altered_bag([](const std::string& topic, const std::string& message) {
                return topic == "/tf" ? "" : topic == "/joint_states" ? with_prefix(message, "arm_") : message;
              }));
  const BagImportSummary summary = import_bag(folder / "made.bag", folder / "fan/01");
  EXPECT_TRUE(summary.has_joints);
  EXPECT_FALSE(summary.has_poses);
  EXPECT_TRUE(summary.warnings.empty());
  EXPECT_EQ(summary.robot_states, 126U);
  TableFile table(folder / "fan/01/robot.csv", {.name = "a robot log", .header = "names"});
  EXPECT_EQ(table.row(), "timestamp,actual_q_0,actual_q_1,actual_q_2,actual_q_3,actual_q_4,actual_q_5,host_time_us");
  ASSERT_TRUE(table.next());
  const std::vector<double> expected{1'700'000'000.008, 0.308, 0.208, 0.108, 0.408, 0.508, 0.608, 1'700'000'000'008'350};
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(table.number_at(i), expected[i], 1e-9) << i;
  const robot::RobotLogFile log = robot::read_robot_log(folder / "fan/01/robot.csv");
  EXPECT_EQ(log.speed_from, robot::RobotSpeedSource::actual_q);
  EXPECT_EQ(log.longest().states.size(), 126U);
  EXPECT_EQ(read_json(folder / "fan/01/run.json").at("robot_clock"), "host");
}

TEST(ImportBag, FindsJointsWithAPrefixBesideAPose) {
  const test::TemporaryFolder folder;
  write_whole(folder / "made.bag", altered_bag([](const std::string& topic, const std::string& message) {
                return topic == "/joint_states" ? with_prefix(message, "ur10e/") : message;
              }));
  import_bag(folder / "made.bag", folder / "fan/01");
  import_bag(plain_bag, folder / "fan/02");
  EXPECT_EQ(read_text(folder / "fan/01/robot.csv"), read_text(folder / "fan/02/robot.csv"));
}

TEST(ImportBag, NamesTwoArmsOfOneTopic) {
  const test::TemporaryFolder folder;
  int count = 0;
  write_whole(folder / "made.bag", altered_bag([&](const std::string& topic, const std::string& message) {
                return topic == "/joint_states" ? with_prefix(message, ++count % 2 == 0 ? "left_" : "right_") : message;
              }));
  const BagImportSummary summary = import_bag(folder / "made.bag", folder / "fan/01");
  ASSERT_EQ(summary.warnings.size(), 1U);
  EXPECT_TRUE(summary.warnings.front().ends_with(
      "/joint_states has the joints of 2 arms, 'left_shoulder_pan_joint' and 'right_shoulder_pan_joint' among them; expected "
      "those of one; robot.csv has no actual_q"))
      << summary.warnings.front();
}

TEST(ImportBag, RefusesJointsInDegrees) {
  const test::TemporaryFolder folder;
  write_whole(folder / "made.bag", altered_bag([](const std::string& topic, std::string message) {
                if (topic == "/tf") return std::string();
                if (topic == "/joint_states") {  // they end in six positions, no speeds and no efforts
                  for (std::size_t i = 0; i < 6; ++i) {
                    char* const position = &message.at(message.size() - 56 + 8 * i);
                    double angle = 0;
                    std::memcpy(&angle, position, 8);
                    angle *= 180 / std::numbers::pi;
                    std::memcpy(position, &angle, 8);
                  }
                }
                return message;
              }));
  std::string message;
  try {
    import_bag(folder / "made.bag", folder / "fan/01");
  } catch (const Error& e) {
    message = e.what();
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "fan/01"));
  EXPECT_NE(message.find("made.bag: robot.csv: actual_q_0 to _5 have values of "), std::string::npos) << message;
  EXPECT_NE(message.find("expected radians: multiply degrees by 0.0174533"), std::string::npos) << message;
}

}  // namespace
}  // namespace tactile::conversion
