#include "tactile/robot/robot_log.hpp"

#include <gtest/gtest.h>

#include <string>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile {
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

TEST(RobotLog, IsPartedAsItsHeaderIs) {
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

TEST(RobotLog, IsInPiecesWhereItsClockStartsAnew) {
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

TEST(RobotLog, KnowsWhenItsRowsCameToTheHost) {
  const RobotLog log = read(header_with_host_time + row_at("1", "1700000000000123"));
  ASSERT_EQ(log.states.size(), 1U);
  EXPECT_EQ(us_of(log.states[0].host_time.value()), 1'700'000'000'000'123);
  EXPECT_FALSE(read(header(",") + "\n" + row("1", ",") + "\n").states[0].host_time.has_value());
  const std::string complaint = complaint_about(header_with_host_time + row_at("1", "12.5"));
  EXPECT_NE(complaint.find("column 'host_time_us' holds '12.5'; expected whole microseconds"), std::string::npos) << complaint;

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
  // However short it was, since nobody knows what was lost.
  EXPECT_EQ(read(header_with_host_time + row_at("1", "1") + "\n" + row_at("1.008", "8001")).gaps.size(), 1U);
  EXPECT_TRUE(read(header_with_host_time + "\n" + row_at("1", "1") + row_at("1.008", "8001") + "\n").gaps.empty())
      << "ahead of all rows and behind them nothing is between two";
}

TEST(RobotLog, SeesARebootThatTheTimestampAloneDoesNotShow) {
  // Away for 60 s by the host's clock, but only 2 s by the controller's, which must have started anew.
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

TEST(RobotLog, TellsWhenItsOutputsChange) {
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

}  // namespace
}  // namespace tactile
