#include "tactile/robot/robot_log.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "robot/robot_log_text.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/table_file.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::robot {
namespace {

using test::complaint_about;
using test::header;
using test::read;
using test::read_file;
using test::row;

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
  std::string changes_as_text;
  for (const OutputChange& change : file.pieces[0].output_changes) {
    changes_as_text += change.output + " " + std::to_string(change.from) + ">" + std::to_string(change.to) + " " +
                       std::to_string(us_of(change.last_before)) + ".." + std::to_string(us_of(change.at)) + "\n";
  }
  EXPECT_EQ(changes_as_text,
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
