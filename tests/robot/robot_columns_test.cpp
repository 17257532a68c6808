#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "support/real_recordings.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile::robot {
namespace {

namespace fs = std::filesystem;

RobotLogFile read_file(const std::string& text, const std::string& columns) {
  const test::TemporaryFolder folder;
  write_whole(folder / "robot.csv", text);
  return read_robot_log(folder / "robot.csv", {.arm = {}, .columns = columns});
}

std::string complaint_about(const std::string& text, const std::string& columns) {
  try {
    read_file(text, columns);
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

/// A row of a pose that rises at 0.1 m/s: the time and six values.
std::string rising_row(const std::string& time, double s) { return time + ",0,0," + std::to_string(0.1 * s) + ",0,0,0\n"; }

const std::string pose_columns = "timestamp,actual_TCP_pose*6";

TEST(RobotColumns, AreNamesAndSkippedOnes) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(column_names("timestamp,actual_q_0"), (Names{"timestamp", "actual_q_0"}));
  EXPECT_EQ(column_names("timestamp, actual_q*3, -*2, -, x"),
            (Names{"timestamp", "actual_q_0", "actual_q_1", "actual_q_2", "", "", "", "x"}));
  for (const char* wrong : {"", "a,", ",a", "a*0", "a*x", "*6", "a*-1", "a*100000", "a*6*6"})
    EXPECT_THROW(column_names(wrong), Error) << wrong;
}

TEST(RobotColumns, NameTheColumnsOfALogWithoutHeader) {
  const RobotLogFile file = read_file("5.5,7,0.1,0.2,0.3,0,0,0\n5.508,7,0.1,0.2,0.4,0,0,0\n", "timestamp,-,actual_TCP_pose*6");
  ASSERT_EQ(file.longest().states.size(), 2U);
  EXPECT_EQ(us_of(file.longest().states[0].t), 5'500'000);
  EXPECT_EQ(file.longest().states[1].tcp_pose[2], 0.4);
  EXPECT_EQ(file.speed_from, RobotSpeedSource::actual_tcp_pose);
}

TEST(RobotColumns, ReplaceAHeaderWithOtherNames) {
  const RobotLogFile file = read_file("pc_ts x y z rx ry rz\n\n5.5 1 2 3 0 0 0\n5.6 1 2 3 0 0 0\n", pose_columns);
  EXPECT_EQ(file.longest().states.size(), 2U);
}

TEST(RobotColumns, AreAskedForWhereALogHasNoHeader) {
  EXPECT_NE(complaint_about("5.5,7,0\n", "")
                .find("begins with a row of 3 numbers, and has no header; expected a header row with "
                      "RTDE's names, or --robot-columns with a name or - for each column"),
            std::string::npos);
  EXPECT_NE(complaint_about("5.5,7,0\n", pose_columns).find("row 1 has 3 values, but --robot-columns names 7"),
            std::string::npos);
  EXPECT_NE(complaint_about("5.5,0,0,0,0,0,x\n", pose_columns).find("row 1, column 'actual_TCP_pose_5' holds 'x'"),
            std::string::npos);
}

TEST(RobotColumns, GiveTheSpeedAtEveryRateOfRealControllersWithTheirJitter) {
  // The steps of real logs: multiples of the controller's 2 ms or 8 ms, around the period that was asked for.
  struct Steps {
    double rate_hz;
    std::vector<int> steps_ms;
  };
  for (const Steps& logged : {Steps{100, {10, 10, 12, 10, 10, 8, 10, 2, 10, 10, 30, 10}}, Steps{125, {8, 8, 8, 16, 8, 8, 0}},
                              Steps{500, {2, 2, 2, 4, 2, 2, 2, 14, 2, 2}}}) {
    std::string text;
    int ms = 1'141'591;
    for (int i = 0; i < 2'000; ++i) {
      const int t = ms - 1'141'591;
      text += rising_row(std::to_string(ms / 1000) + "." + std::to_string(1000 + ms % 1000).substr(1), 1e-3 * t);
      ms += logged.steps_ms[static_cast<std::size_t>(i) % logged.steps_ms.size()];
    }
    const RobotLogFile file = read_file(text, pose_columns);
    const RobotLog& log = file.longest();
    EXPECT_DOUBLE_EQ(rate_hz(log), logged.rate_hz);
    EXPECT_TRUE(log.gaps.empty());
    EXPECT_EQ(log.mixed_rows, 0U);
    for (const RobotState& state : log.states) ASSERT_NEAR(state.tcp_speed[2], 0.1, 1e-3) << us_of(state.t);
  }
}

TEST(RobotColumns, DoNotHelpWhereTimesWereRounded) {
  const auto log_of = [](int digits, double moves) {
    std::string text;
    for (int i = 0; i < 1'000; ++i) {
      std::array<char, 32> time{};
      std::snprintf(time.data(), time.size(), "%.*f", digits, 1'759'936'358 + 0.008 * i);
      text += rising_row(time.data(), moves * i);
    }
    return text;
  };
  EXPECT_NE(
      complaint_about(log_of(0, 0.008), pose_columns)
          .find("have the time of the row before, and another motion: the times were rounded to whole seconds when the log was "
                "written, so the time of a row is not known; expected times as the controller gives them"),
      std::string::npos);
  EXPECT_NE(complaint_about(log_of(0, 0), pose_columns)
                .find("have the time of the row before: the times were rounded to whole seconds"),
            std::string::npos);
  EXPECT_NE(complaint_about(log_of(1, 0.008), pose_columns).find("and another motion: the times were rounded when"),
            std::string::npos);
  EXPECT_EQ(complaint_about(log_of(3, 0.008), pose_columns), "no error");
  // A recorder at 1 kHz repeats the rows of a controller at 125 Hz, and their motion.
  std::string repeated;
  for (int i = 0; i < 800; ++i) repeated += rising_row(std::to_string(0.008 * (i / 8)), 0.008 * (i / 8));
  EXPECT_EQ(read_file(repeated, pose_columns).longest().states.size(), 100U);
}

TEST(RobotColumns, ReadRealLogsWithoutHeader) {
  const fs::path file = test::real_recording("ur/ur-20_01_22-push_pose_1.csv");
  if (file.empty()) GTEST_SKIP() << test::not_tested_without("ur/ur-20_01_22-push_pose_1.csv");
  const RobotLogFile log = read_robot_log(file, {.arm = ArmModel::ur10e, .columns = "timestamp,actual_q*6,actual_qd*6,-*18"});
  EXPECT_EQ(log.restarts(), 0U);
  EXPECT_EQ(log.longest().states.size(), 1'727U);
  EXPECT_DOUBLE_EQ(rate_hz(log.longest()), 100.0);
  EXPECT_EQ(us_of(log.longest().states.front().t), 200'533'000);
  EXPECT_EQ(log.longest().mixed_rows, 0U);
}

TEST(RobotColumns, RefuseARealLogWithRoundedTimes) {
  const fs::path file = test::real_recording("ur/UR5e_motion_full.csv");
  if (file.empty()) GTEST_SKIP() << test::not_tested_without("ur/UR5e_motion_full.csv");
  try {
    read_robot_log(file, {.arm = {}, .columns = "timestamp,-*32,actual_TCP_pose*6,actual_TCP_speed*6,-*6"});
    ADD_FAILURE() << "expected an error";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("rounded to whole seconds"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace tactile::robot
