// Logs that other programs write.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "robot/robot_log_text.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/table_file.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile::robot {
namespace {

using test::complaint_about;
using test::header;
using test::read;
using test::read_file;
using test::row;

/// A log of named columns. Vectors are written as six.
class MadeLog {
 public:
  using Row = std::vector<std::string>;

  MadeLog(std::vector<std::pair<std::string, int>> fields, std::string separator, std::string ending)
      : fields_(std::move(fields)), separator_(std::move(separator)), ending_(std::move(ending)) {
    Row names;
    for (const auto& [name, size] : fields_) {
      for (int i = 0; i < size; ++i) names.push_back(size == 1 ? name : name + "_" + std::to_string(i));
    }
    add(names);
  }

  void add(const Row& cells) {
    for (std::size_t i = 0; i < cells.size(); ++i) text_ += (i > 0 ? separator_ : "") + cells[i];
    text_ += ending_;
  }

  /// `value(name, i)` of each cell.
  void add(const std::function<std::string(const std::string&, int)>& value) {
    Row cells;
    for (const auto& [name, size] : fields_) {
      for (int i = 0; i < size; ++i) cells.push_back(value(name, i));
    }
    add(cells);
  }

  const std::string& text() const { return text_; }

 private:
  std::vector<std::pair<std::string, int>> fields_;
  std::string separator_, ending_, text_;
};

/// What record_configuration.xml of the RTDE Python client asks for.
const std::vector<std::pair<std::string, int>> record_py_fields{{"timestamp", 1},
                                                                {"target_q", 6},
                                                                {"target_qd", 6},
                                                                {"target_qdd", 6},
                                                                {"target_current", 6},
                                                                {"target_moment", 6},
                                                                {"actual_q", 6},
                                                                {"actual_qd", 6},
                                                                {"actual_current", 6},
                                                                {"joint_control_output", 6},
                                                                {"actual_TCP_pose", 6},
                                                                {"actual_TCP_speed", 6},
                                                                {"actual_TCP_force", 6},
                                                                {"target_TCP_pose", 6},
                                                                {"target_TCP_speed", 6},
                                                                {"actual_digital_input_bits", 1},
                                                                {"joint_temperatures", 6},
                                                                {"actual_execution_time", 1},
                                                                {"robot_mode", 1},
                                                                {"joint_mode", 6},
                                                                {"safety_status", 1},
                                                                {"actual_tool_accelerometer", 3},
                                                                {"speed_scaling", 1},
                                                                {"target_speed_fraction", 1},
                                                                {"actual_momentum", 1},
                                                                {"actual_main_voltage", 1},
                                                                {"actual_robot_voltage", 1},
                                                                {"actual_robot_current", 1},
                                                                {"actual_joint_voltage", 6},
                                                                {"actual_digital_output_bits", 1},
                                                                {"runtime_state", 1},
                                                                {"joint_position_deviation_ratio", 1}};

TEST(RobotLog, ReadsWhatRecordPyWrites) {
  for (const std::string ending : {"\r\n", "\r\r\n", "\n", "\r"}) {
    MadeLog made(record_py_fields, " ", ending);
    for (int row = 0; row < 3; ++row) {
      made.add([&](const std::string& name, int i) -> std::string {
        if (name == "timestamp") return std::to_string(31216 + row) + ".816000000001";
        if (name == "actual_TCP_pose") return "-0.0" + std::to_string(i + 1) + "8452311243e-05";
        if (name == "actual_TCP_speed") return std::to_string(row) + "." + std::to_string(i);
        if (name == "actual_digital_output_bits") return row == 2 ? "65536" : "0";
        return name == "robot_mode" ? "7" : "-3.2e-17";
      });
    }
    const RobotLogFile file = read_file(made.text());
    ASSERT_EQ(file.longest().states.size(), 3U);
    const RobotState& state = file.longest().states[1];
    EXPECT_EQ(us_of(state.t), 31'217'816'000);
    EXPECT_EQ(state.tcp_pose[3], -0.048452311243e-05);
    EXPECT_EQ(state.tcp_speed[4], 1.4);
    EXPECT_EQ(state.digital_output_bits, 0U);
    EXPECT_EQ(file.speed_from, RobotSpeedSource::actual_tcp_speed);
    ASSERT_EQ(file.longest().output_changes.size(), 1U);
    EXPECT_EQ(file.longest().output_changes[0].output, "digital output 16");
  }
}

TEST(RobotLog, TakesQuotedCellsAndIgnoresWhatItDoesNotNeed) {
  const std::string text = "\xEF\xBB\xBFnote \"operator \"\"A\"\" B\" " + header(" ", "output_bit_register_64 comment") +
                           "\r\n\"two words\" 7mm " + row("1.5", " ", "True nan") + "\r\n- \"\" \"1.508\"" +
                           row("", " ", "\"False\" \"and so on\"") + "\r\n";
  const RobotLog log = read(text);
  ASSERT_EQ(log.states.size(), 2U);
  EXPECT_EQ(us_of(log.states[1].t), 1'508'000);
  EXPECT_EQ(log.states[1].tcp_speed[5], 11.5);
  ASSERT_EQ(log.output_changes.size(), 1U);
  EXPECT_EQ(log.output_changes[0].from, 1);
  EXPECT_EQ(read("\"timestamp,x\"," + header(",") + "\n5," + row("1", ",") + "\n").states.size(), 1U)
      << "a quoted comma parts nothing";
}

/// The rows of a lift as ur_rtde's recorder writes them: six decimals; pose and speed of `packages[i].second`, while the time is
/// that of `packages[i].first`.
std::string ur_rtde_log(const std::vector<std::pair<int, int>>& packages) {
  MadeLog made({{"timestamp", 1}, {"actual_TCP_pose", 6}, {"actual_TCP_speed", 6}, {"robot_status_bits", 1}}, ",", "\n");
  Random random(11);
  std::vector<std::array<double, 3>> noise(200);
  for (auto& of_package : noise) of_package = {1e-5 * random.normal(), 3e-4 * random.normal(), 3e-4 * random.normal()};
  for (const auto& [time, motion] : packages) {
    const double s = 0.008 * motion, speed = std::min(1.2 * std::max(0.0, s - 0.2), 0.06);
    const double lift = speed < 0.06 ? 0.5 * speed * speed / 1.2 : 0.06 * (s - 0.225);
    const std::array<double, 3>& off = noise.at(static_cast<std::size_t>(motion));
    made.add([&, time = time](const std::string& name, int i) -> std::string {
      if (name == "timestamp") return std::to_string(500.0 + 0.008 * time);
      if (name == "actual_TCP_pose") return std::to_string(i == 2 ? 0.3 + lift + off[0] : 0.1 * i);
      if (name == "actual_TCP_speed") return std::to_string(i == 2 ? speed + off[1] : i == 0 ? off[2] : 0.0);
      return "3";
    });
  }
  return made.text();
}

TEST(RobotLog, DropsWhatUrRtdeWritesTwiceOrMixes) {
  std::vector<std::pair<int, int>> whole;
  whole.reserve(100);
  for (int i = 0; i < 100; ++i) whole.emplace_back(i, i);
  const RobotLog truth = read(ur_rtde_log(whole));
  ASSERT_EQ(truth.states.size(), 100U);
  EXPECT_EQ(truth.mixed_rows, 0U);
  const auto expect_true = [&](const RobotLog& log, std::size_t missing) {
    EXPECT_EQ(log.states.size(), 100U - missing);
    for (const RobotState& state : log.states) {
      const auto i = static_cast<std::size_t>((state.t - truth.states[0].t) / microseconds{8'000});
      EXPECT_EQ(state.tcp_pose, truth.states.at(i).tcp_pose) << i;
      EXPECT_EQ(state.tcp_speed, truth.states.at(i).tcp_speed) << i;
    }
  };

  auto repeated = whole;
  repeated.insert(repeated.begin() + 40, {39, 39});
  repeated.insert(repeated.begin() + 3, 2, {2, 2});
  expect_true(read(ur_rtde_log(repeated)), 0);

  for (const int at : {27, 29, 50}) {  // on the ramp, and at full speed
    auto late = whole;                 // the time is new, the motion still the old one
    late[static_cast<std::size_t>(at)].second -= 1;
    expect_true(read(ur_rtde_log(late)), 1);
    EXPECT_EQ(read(ur_rtde_log(late)).mixed_rows, 1U);
    auto early = whole;  // the other way round
    early[static_cast<std::size_t>(at)].second += 1;
    expect_true(read(ur_rtde_log(early)), 1);
    late.insert(late.begin() + at + 1, {at, at});  // and again, now whole
    expect_true(read(ur_rtde_log(late)), 0);
    EXPECT_EQ(read(ur_rtde_log(late)).mixed_rows, 1U);
  }
  auto at_rest = whole;
  at_rest[10].second -= 1;
  EXPECT_EQ(read(ur_rtde_log(at_rest)).mixed_rows, 0U)
      << "at rest it cannot be distinguished from a true row, and does not matter";
}

TEST(RobotLog, KeepsRowsWhoseSpeedHardlyChanges) {
  // At a steady speed that was worked out, neighbours differ by rounding, or not at all.
  std::string text = header(",") + "\n";
  for (int i = 0; i < 12; ++i) {
    text += "1." + std::to_string(100 + i);
    for (int k = 0; k < 6; ++k) text += k == 2 ? "," + std::to_string(0.3 + 5e-5 * i) : ",0";
    for (int k = 0; k < 6; ++k) text += k == 2 ? (i % 3 == 0 ? ",0.05" : ",0.05000000000000001") : ",0";
    text += "\n";
  }
  EXPECT_EQ(read(text).states.size(), 12U);
}

/// A lift whose rows hold the wanted vectors alone.
std::string log_of(const std::vector<std::string>& vectors, int period_ms,
                   const std::function<double(const std::string&, int, double)>& value) {
  std::vector<std::pair<std::string, int>> fields{{"timestamp", 1}};
  for (const std::string& vector : vectors) fields.emplace_back(vector, 6);
  MadeLog made(std::move(fields), ",", "\n");
  for (int i = 0; i < 60; ++i) {
    const double s = 1e-3 * period_ms * i;
    made.add([&](const std::string& name, int k) {
      return name == "timestamp" ? std::to_string(10 + s) : std::to_string(1e6 * value(name, k, s)) + "e-6";
    });
  }
  return made.text();
}

double lifted(const std::string& name, int part, double s) {
  const bool is_speed = name.ends_with("speed"), is_target = name.starts_with("target");
  if (part != 2) return is_speed ? 0.0 : 0.1 * part;
  return (is_target ? 2.0 : 1.0) * (is_speed ? 0.1 * s : 0.05 * s * s);
}

TEST(RobotLog, TakesItsSpeedFromTheBestThatIsThere) {
  const auto read_of = [](const std::vector<std::string>& vectors) { return read_file(log_of(vectors, 8, lifted)); };
  const auto speed_at_240_ms = [](const RobotLogFile& file) { return file.longest().states.at(30).tcp_speed[2]; };

  RobotLogFile file = read_of({"target_TCP_speed", "actual_TCP_pose", "actual_TCP_speed"});
  EXPECT_EQ(file.speed_from, RobotSpeedSource::actual_tcp_speed);
  EXPECT_NEAR(speed_at_240_ms(file), 0.024, 1e-9);

  file = read_of({"target_TCP_speed", "actual_TCP_pose"});
  EXPECT_EQ(file.speed_from, RobotSpeedSource::actual_tcp_pose);
  EXPECT_NEAR(speed_at_240_ms(file), 0.024, 1e-6);
  EXPECT_FALSE(file.arm.has_value());

  file = read_of({"actual_TCP_speed"});
  EXPECT_EQ(file.speed_from, RobotSpeedSource::actual_tcp_speed);
  EXPECT_NEAR(file.longest().states.at(30).tcp_pose[2], 0.05 * 0.24 * 0.24, 1e-6) << "the displacement that the speed makes";

  file = read_of({"target_TCP_pose", "target_TCP_speed"});
  EXPECT_EQ(file.speed_from, RobotSpeedSource::target_tcp_speed);
  EXPECT_TRUE(is_target(file.speed_from));
  EXPECT_NEAR(speed_at_240_ms(file), 0.048, 1e-9);

  file = read_of({"target_TCP_pose"});
  EXPECT_EQ(file.speed_from, RobotSpeedSource::target_tcp_pose);
  EXPECT_EQ(name_of(file.speed_from), "target_TCP_pose");
  EXPECT_NEAR(speed_at_240_ms(file), 0.048, 1e-6);

  const std::string complaint = complaint_about(log_of({"actual_qd"}, 8, lifted));
  EXPECT_NE(complaint.find("no column 'actual_TCP_speed_0'; expected those of actual_TCP_speed, actual_TCP_pose or actual_q"),
            std::string::npos)
      << complaint;
}

TEST(RobotLog, TakesItsSpeedFromTheJointsOfTheArm) {
  // The base alone turns, 0.5 rad/s: a circle about z as wide as the flange is off the axis.
  const std::array<double, 6> joints{0, -1.2, 1.4, -1.8, -1.5, 0.3};
  const auto turning = [&](const std::string&, int part, double s) {
    return part == 0 ? 0.5 * s : joints.at(static_cast<std::size_t>(part));
  };
  for (const auto& [period_ms, given, expected] : {std::tuple{8, std::optional<ArmModel>(), ArmModel::ur10},
                                                   {2, {}, ArmModel::ur10e},
                                                   {8, ArmModel::ur10e, ArmModel::ur10e}}) {
    const test::TemporaryFolder folder;
    write_whole(folder / "robot.csv", log_of({"actual_q"}, period_ms, turning));
    const RobotLogFile file = read_robot_log(folder / "robot.csv", {.arm = given});
    EXPECT_EQ(file.speed_from, RobotSpeedSource::actual_q);
    EXPECT_EQ(file.arm, expected);
    const auto pose = flange_pose(expected, joints);
    const RobotState& first = file.longest().states.front();
    for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(first.tcp_pose[k], pose[k], 1e-9);
    const RobotState& later = file.longest().states.at(30);
    EXPECT_NEAR(std::hypot(later.tcp_speed[0], later.tcp_speed[1]), 0.5 * std::hypot(pose[0], pose[1]), 1e-4);
    EXPECT_NEAR(later.tcp_speed[2], 0, 1e-6);
    EXPECT_NEAR(later.tcp_speed[5], 0.5, 1e-4);
  }
}

TEST(RobotLog, RefusesWhatRecordPyWritesInBytesAndExplainsHowToConvertIt) {
  const std::string text = "timestamp actual_q_0 actual_q_1 robot_mode actual_TCP_speed_0\nDOUBLE DOUBLE DOUBLE INT32 DOUBLE\n" +
                           std::string("\x40\x0a\n\r\0\"", 6) + std::string(4'000'000, '\x7f');
  const std::string header_of_all = header(" ", "robot_mode actual_digital_output_bits");
  std::string types = "DOUBLE";
  for (int i = 0; i < 12; ++i) types += " DOUBLE";
  const std::string complaint = complaint_about(header_of_all + "\n" + types + " INT32 UINT64\n" + text);
  EXPECT_NE(complaint.find("row 2 names types, so bytes follow, as record.py --binary writes them"), std::string::npos)
      << complaint;
  EXPECT_NE(complaint.find("struct.iter_unpack('>13diQ', rest)"), std::string::npos) << complaint;
}

TEST(RobotLog, RefusesWhatIsNoTextInRows) {
  const std::string complaint = complaint_about(header(",") + "\n" + std::string(TableFile::longest_row + 10, 'x'));
  EXPECT_NE(complaint.find("row 2 has no end within 1048576 bytes"), std::string::npos) << complaint;
  EXPECT_NE(
      complaint_about(header(",") + "\n" + row("1", ",") + "\n" + row("1e9999", ",") + "\n").find("row 3, column 'timestamp'"),
      std::string::npos);
  std::string far = row("1", ",");
  far.replace(far.find("2.5"), 3, "1e7");
  EXPECT_NE(complaint_about(header(",") + "\n" + far + "\n").find("holds '1e7'; expected metres and radians"), std::string::npos);
}

}  // namespace
}  // namespace tactile::robot
