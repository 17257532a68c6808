#include "tactile/robot/robot_log.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/table_file.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::robot {
namespace {

/// A header with the needed columns and what a test adds, parted by `separator`.
std::string header(const std::string& separator, const std::string& last = "") {
  std::string text = "timestamp";
  for (const char* name : {"actual_TCP_pose_", "actual_TCP_speed_"}) {
    for (int i = 0; i < 6; ++i) text += separator + name + std::to_string(i);
  }
  return text + (last.empty() ? "" : separator + last);
}

/// A row at `time` whose values are 0.5, 1.5, ... 11.5.
std::string row(const std::string& time, const std::string& separator, const std::string& last = "") {
  std::string text = time;
  for (int i = 0; i < 12; ++i) text += separator + std::to_string(i) + ".5";
  return text + (last.empty() ? "" : separator + last);
}

RobotLogFile read_file(const std::string& text) {
  const test::TemporaryFolder folder;
  write_whole(folder / "robot.csv", text);
  return read_robot_log(folder / "robot.csv");
}

RobotLog read(const std::string& text) { return read_file(text).longest(); }

std::string complaint_about(const std::string& text) {
  try {
    read(text);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(RobotLog, ComesBackAsItWasWritten) {
  RobotLog log;
  for (int i = 0; i < 3; ++i) {
    RobotState state;
    state.t = RobotTime{microseconds{83'456'789'012 + 8000 * i}};
    for (std::size_t k = 0; k < 6; ++k) {
      state.tcp_pose[k] = 0.1 * i - 1.0 / (3.0 + static_cast<double>(k));
      state.tcp_speed[k] = 1e-7 * i * static_cast<double>(k);
    }
    state.digital_output_bits = i == 2 ? 5 : 0;
    log.states.push_back(state);
  }
  const test::TemporaryFolder folder;
  write_robot_log(folder / "robot.csv", log);
  const RobotLog back = read_robot_log(folder / "robot.csv").longest();
  ASSERT_EQ(back.states.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(back.states[i].t, log.states[i].t);
    EXPECT_EQ(back.states[i].tcp_pose, log.states[i].tcp_pose);
    EXPECT_EQ(back.states[i].tcp_speed, log.states[i].tcp_speed);
    EXPECT_EQ(back.states[i].digital_output_bits, log.states[i].digital_output_bits);
  }
  EXPECT_TRUE(read_text(folder / "robot.csv").find("\n83456.789012,") != std::string::npos);
}

TEST(RobotLog, HasTheSeparatorOfItsHeader) {
  for (const std::string separator : {",", " ", "\t", ";", ", "}) {
    const RobotLog log = read(header(separator) + "\n" + row("12.008", separator) + "\n");
    ASSERT_EQ(log.states.size(), 1U) << "'" << separator << "'";
    EXPECT_EQ(us_of(log.states[0].t), 12'008'000);
    EXPECT_EQ(log.states[0].tcp_pose[5], 5.5);
    EXPECT_EQ(log.states[0].tcp_speed[0], 6.5);
    EXPECT_FALSE(log.states[0].digital_output_bits.has_value());
  }
}

TEST(RobotLog, MayEndItsRowsAsWindowsDoesAndHoldBlankOnes) {
  const RobotLog log = read(header(" ") + "\r\r\n\r\n" + row("1.0", " ") + "\r\n\r\n" + row("1.008", " ") + "\r\n \r\n");
  ASSERT_EQ(log.states.size(), 2U);
  EXPECT_EQ(log.states[1].tcp_speed[5], 11.5);
}

TEST(RobotLog, FindsItsColumnsByName) {
  const RobotLog log = read("robot_mode," + header(",", "actual_digital_output_bits") + "\n7," + row("2.5", ",", "65537") + "\n");
  ASSERT_EQ(log.states.size(), 1U);
  EXPECT_EQ(us_of(log.states[0].t), 2'500'000);
  EXPECT_EQ(log.states[0].digital_output_bits, 65537U);
}

TEST(RobotLog, DropsARepeatedRow) {
  const RobotLog log = read(header(",") + "\n" + row("1", ",") + "\n" + row("1", ",") + "\n" + row("1.008", ",") + "\n");
  EXPECT_EQ(log.states.size(), 2U);
}

TEST(RobotLog, NamesTheColumnThatIsMissing) {
  std::string text = header(",");
  text.replace(text.find("actual_TCP_speed_3"), 18, "actual_TCP_spede_3");
  EXPECT_NE(complaint_about(text + "\n").find("no column 'actual_TCP_speed_3'"), std::string::npos);
  EXPECT_NE(complaint_about("31216.8 0 0 remote\n")
                .find("no column 'timestamp'; expected a header row with RTDE's names, or "
                      "--robot-columns with a name or - for each column"),
            std::string::npos);
}

TEST(RobotLog, NamesTheRowAndColumnThatIsNoNumber) {
  for (const std::string wrong : {"4,5", "nan", "inf", "", "0x10", "1.5mm"}) {
    std::string text = header(";") + "\n" + row("1", ";") + "\n" + row("2", ";") + "\n";
    text.replace(text.rfind("4.5"), 3, wrong);
    const std::string complaint = complaint_about(text);
    EXPECT_NE(complaint.find("row 3, column 'actual_TCP_pose_4' holds '" + wrong + "'"), std::string::npos) << complaint;
  }
  const std::string bits = complaint_about(header(",", "actual_digital_output_bits") + "\n" + row("1", ",", "-1") + "\n");
  EXPECT_NE(bits.find("row 2, column 'actual_digital_output_bits' holds '-1'"), std::string::npos) << bits;
}

TEST(RobotLog, RefusesARowOfAnotherLength) {
  EXPECT_NE(complaint_about(header(",") + "\n" + row("1", ",", "9") + "\n").find("row 2 has 14 values; expected 13"),
            std::string::npos);
}

/// A row at `time` that came to the host at `host_us`.
std::string row_at(const std::string& time, const std::string& host_us) { return row(time, ",", host_us) + "\n"; }
const std::string header_with_host_time = header(",", "host_time_us") + "\n";

TEST(RobotLog, IsInPiecesWhereItsClockRestarts) {
  const std::string rows = row("7", ",") + "\n" + row("7.002", ",") + "\n" + row("0.5", ",") + "\n" + row("0.502", ",") + "\n" +
                           row("0.504", ",") + "\n" + row("0.1", ",") + "\n";
  const RobotLogFile file = read_file(header(",") + "\n" + rows);
  ASSERT_EQ(file.pieces.size(), 3U);
  EXPECT_EQ(us_of(file.pieces[0].states.at(1).t), 7'002'000);
  EXPECT_EQ(us_of(file.pieces[1].states.at(0).t), 500'000);
  EXPECT_EQ(us_of(file.pieces[1].states.at(2).t), 504'000);
  EXPECT_EQ(us_of(file.pieces[2].states.at(0).t), 100'000);
  EXPECT_EQ(&file.longest(), &file.pieces[1]);
  EXPECT_EQ(file.restarts(), 2U);
  EXPECT_EQ(file.rows_elsewhere(), 3U);
  for (const RobotLog& piece : file.pieces) EXPECT_TRUE(piece.gaps.empty());
}

TEST(RobotLog, KnowsWhenItsRowsArrivedAtTheHost) {
  const RobotLog log = read(header_with_host_time + row_at("1", "1700000000000123"));
  ASSERT_EQ(log.states.size(), 1U);
  EXPECT_EQ(us_of(log.states[0].host_time.value()), 1'700'000'000'000'123);
  EXPECT_FALSE(read(header(",") + "\n" + row("1", ",") + "\n").states[0].host_time.has_value());
  const std::string complaint = complaint_about(header_with_host_time + row_at("1", "12.5"));
  EXPECT_NE(complaint.find("column 'host_time_us' holds '12.5'; expected a whole number"), std::string::npos) << complaint;

  const test::TemporaryFolder folder;
  write_robot_log(folder / "robot.csv", log);
  EXPECT_EQ(read_robot_log(folder / "robot.csv").longest().states[0].host_time, log.states[0].host_time);
}

TEST(RobotLog, TakesAnEmptyLineOfALogWithHostTimesAsALostConnection) {
  const std::string rows =
      row_at("1", "100000") + row_at("1.008", "108000") + "\n" + row_at("4", "3100000") + row_at("4.008", "3108000");
  const RobotLogFile file = read_file(header_with_host_time + rows);
  const RobotLog& log = file.longest();
  EXPECT_EQ(log.states.size(), 4U);
  EXPECT_EQ(file.restarts(), 0U);
  ASSERT_EQ(log.gaps.size(), 1U);
  EXPECT_EQ(us_of(log.gaps[0].last_before), 1'008'000);
  EXPECT_EQ(us_of(log.gaps[0].first_after), 4'000'000);
  // However short it was, since what was lost is not known.
  EXPECT_EQ(read(header_with_host_time + row_at("1", "1") + "\n" + row_at("1.008", "8001")).gaps.size(), 1U);
  EXPECT_TRUE(read(header_with_host_time + "\n" + row_at("1", "1") + row_at("1.008", "8001") + "\n").gaps.empty())
      << "before all rows and after them there is no gap between two";
}

TEST(RobotLog, FindsARebootThatTheTimestampAloneDoesNotShow) {
  // Away for 60 s by the host's clock, but only 2 s by the controller's, which must have started again.
  const std::string rows = row_at("10", "1000000") + row_at("10.008", "1008000") + "\n" + row_at("12", "61000000");
  const RobotLogFile file = read_file(header_with_host_time + rows);
  EXPECT_EQ(file.restarts(), 1U);
  EXPECT_EQ(file.longest().states.size(), 2U);
  EXPECT_EQ(file.rows_elsewhere(), 1U);
  // Rows that only came late are of the same clock.
  EXPECT_EQ(read_file(header_with_host_time + row_at("10", "1000000") + row_at("10.008", "9000000")).restarts(), 0U);
}

TEST(RobotLog, NamesAStepOfMoreThanAHundredMillisecondsAGap) {
  const auto gaps_with_step_to = [](const std::string& time) {
    return read(header(",") + "\n" + row("1", ",") + "\n" + row(time, ",") + "\n").gaps.size();
  };
  EXPECT_EQ(gaps_with_step_to("1.1"), 0U);
  EXPECT_EQ(gaps_with_step_to("1.108"), 1U);
}

TEST(RobotLog, LeavesOutALastRowThatIsNotWhole) {
  const std::string whole = header_with_host_time + row_at("1", "1000") + row_at("1.008", "9000");
  EXPECT_FALSE(read_file(whole).cut_off);
  const std::size_t last_row = whole.rfind('\n', whole.size() - 2) + 1;
  for (std::size_t size = last_row + 1; size < whole.size(); ++size) {
    const RobotLogFile file = read_file(whole.substr(0, size));
    EXPECT_EQ(file.longest().states.size(), 1U) << size;
    EXPECT_TRUE(file.cut_off) << size;
  }
  // Others do not end their last row; then it counts if it is whole as far as one can see.
  const RobotLogFile unended = read_file(header(",") + "\n" + row("1", ",") + "\n" + row("2", ","));
  EXPECT_EQ(unended.longest().states.size(), 2U);
  EXPECT_FALSE(unended.cut_off);
  const RobotLogFile cut = read_file(header(",") + "\n" + row("1", ",") + "\n2,0.5,1.");
  EXPECT_EQ(cut.longest().states.size(), 1U);
  EXPECT_TRUE(cut.cut_off);
}

TEST(RobotLog, HasNoPieceWithoutARow) {
  const RobotLogFile file = read_file(header(",") + "\n");
  EXPECT_TRUE(file.pieces.empty());
  EXPECT_TRUE(file.longest().states.empty());
  EXPECT_EQ(file.restarts(), 0U);
  EXPECT_EQ(file.rows_elsewhere(), 0U);
}

TEST(RobotLog, ReportsWhenItsOutputsChange) {
  const std::string names =
      "actual_digital_output_bits,output_bit_registers32_to_63,output_bit_register_127,output_int_register_0";
  const std::string text = header(",", names) + "\n" + row("1", ",", "1,0,False,-7") + "\n" + row("1.008", ",", "1,0,False,-7") +
                           "\n" + row("1.024", ",", "131072,4,True,12") + "\n" + row("1.032", ",", "131073,4,False,12") + "\n" +
                           row("0.5", ",", "0,0,True,3") + "\n" + row("0.6", ",", "0,0,True,3") + "\n";
  const RobotLogFile file = read_file(text);
  ASSERT_EQ(file.pieces.size(), 2U);
  std::string told;
  for (const OutputChange& change : file.pieces[0].output_changes) {
    told += change.output + " " + std::to_string(change.from) + ">" + std::to_string(change.to) + " " +
            std::to_string(us_of(change.last_before)) + ".." + std::to_string(us_of(change.at)) + "\n";
  }
  EXPECT_EQ(told,
            "digital output 0 1>0 1008000..1024000\ndigital output 17 0>1 1008000..1024000\n"
            "output_bit_register_34 0>1 1008000..1024000\noutput_bit_register_127 0>1 1008000..1024000\n"
            "output_int_register_0 -7>12 1008000..1024000\n"
            "digital output 0 0>1 1024000..1032000\noutput_bit_register_127 1>0 1024000..1032000\n");
  EXPECT_TRUE(file.pieces[1].output_changes.empty()) << "another clock's rows say nothing of when it changed";
}

TEST(RobotLog, RefusesAnEmptyFileAndOneThatIsNotThere) {
  EXPECT_NE(complaint_about("\n\n").find("is empty"), std::string::npos);
  EXPECT_THROW(read_robot_log("/nowhere/robot.csv"), Error);
}

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
    const double way = speed < 0.06 ? 0.5 * speed * speed / 1.2 : 0.06 * (s - 0.225);
    const std::array<double, 3>& off = noise.at(static_cast<std::size_t>(motion));
    made.add([&, time = time](const std::string& name, int i) -> std::string {
      if (name == "timestamp") return std::to_string(500.0 + 0.008 * time);
      if (name == "actual_TCP_pose") return std::to_string(i == 2 ? 0.3 + way + off[0] : 0.1 * i);
      if (name == "actual_TCP_speed") return std::to_string(i == 2 ? speed + off[1] : i == 0 ? off[2] : 0.0);
      return "3";
    });
  }
  return made.text();
}

TEST(RobotLog, DropsWhatUrRtdeWritesTwiceOrMixes) {
  std::vector<std::pair<int, int>> whole;
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
  EXPECT_EQ(file.longest().smoothed_over, microseconds{8'000}) << "exact poses at a constant acceleration say what a mean says";

  file = read_of({"target_TCP_speed", "actual_TCP_pose"});
  EXPECT_EQ(file.speed_from, RobotSpeedSource::actual_tcp_pose);
  EXPECT_NEAR(speed_at_240_ms(file), 0.024, 1e-6);
  EXPECT_EQ(file.longest().smoothed_over, microseconds{8'000});
  EXPECT_FALSE(file.arm.has_value());

  file = read_of({"actual_TCP_speed"});
  EXPECT_EQ(file.speed_from, RobotSpeedSource::actual_tcp_speed);
  EXPECT_NEAR(file.longest().states.at(30).tcp_pose[2], 0.05 * 0.24 * 0.24, 1e-6) << "the way that the speed makes";
  EXPECT_EQ(file.longest().smoothed_over, microseconds{0});

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

TEST(RobotLog, IsInPiecesWhereItsClockLeapsByMoreThanAMinute) {
  const auto pieces = [](const std::string& text) { return read_file(text).pieces.size(); };
  // A recorder that was ahead of its first package writes a row of zeros.
  EXPECT_EQ(pieces(header(",") + "\n" + row("0", ",") + "\n" + row("31216.8", ",") + "\n" + row("31216.808", ",") + "\n"), 2U);
  EXPECT_EQ(pieces(header(",") + "\n" + row("1", ",") + "\n" + row("60.5", ",") + "\n"), 1U);
  EXPECT_EQ(pieces(header_with_host_time + row_at("1", "1000000") + row_at("100", "100000000")), 1U) << "the host's clock agrees";
  EXPECT_EQ(pieces(header_with_host_time + row_at("1", "1000000") + row_at("100", "2000000")), 2U);
}

TEST(RobotLog, KnowsItsRateAndWhatItLost) {
  const auto log_at = [](const std::vector<int>& at_ms) {
    std::string text = header(",") + "\n";
    for (const int ms : at_ms)
      text += row(std::to_string(ms / 1000) + "." + std::to_string(1000 + ms % 1000).substr(1), ",") + "\n";
    return read(text);
  };
  const RobotLog slow = log_at({0, 8, 16, 24, 40, 48, 56, 88, 96, 104});
  EXPECT_DOUBLE_EQ(rate_hz(slow), 125.0);
  EXPECT_EQ(lost_packages(slow), 1U + 3U);
  EXPECT_TRUE(slow.gaps.empty());
  const RobotLog fast = log_at({0, 2, 4, 6, 8, 10, 200, 202});
  EXPECT_DOUBLE_EQ(rate_hz(fast), 500.0);
  EXPECT_EQ(lost_packages(fast), 94U);
  EXPECT_EQ(fast.gaps.size(), 1U);
  EXPECT_EQ(rate_hz(log_at({5})), 0.0);
  EXPECT_EQ(lost_packages(log_at({5})), 0U);
}

}  // namespace
}  // namespace tactile::robot
