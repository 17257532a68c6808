#include "tactile/robot/robot_monitor.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "robot/fake_controller.hpp"
#include "robot/monitored_robot.hpp"
#include "support/comes_true.hpp"
#include "support/held_port.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile::robot {
namespace {

using test::columns_in;
using test::comes_true;
using test::FakeController;
using test::FakeControllerOptions;
using test::has_all_that_was_sent;
using test::has_rows;
using test::MonitorLog;
using test::numbers_in_column;
using test::options_for;

struct LogGaps {
  std::uint64_t gaps = 0, missing = 0;
};

/// What a log of 500 Hz lacks by its own times.
LogGaps gaps_in(const std::filesystem::path& file) {
  const std::vector<double> times = numbers_in_column(file, "timestamp");
  LogGaps found;
  for (std::size_t i = 1; i < times.size(); ++i) {
    const auto steps = static_cast<std::uint64_t>(std::llround((times[i] - times[i - 1]) * 500));
    found.gaps += steps > 1 ? 1 : 0;
    found.missing += steps - 1;
  }
  return found;
}

TEST(RobotMonitor, LogsEveryPackageHoweverTheStreamIsCut) {
  FakeController controller({.split_writes = true, .text_every = 7});
  const test::TemporaryFolder folder;
  MonitorLog messages;
  RobotMonitor monitor(options_for(controller, &messages));
  EXPECT_EQ(monitor.state().controller, "5.11.6.1071234");
  monitor.start_log(folder / "robot.csv");
  ASSERT_TRUE(has_rows(monitor, 300));
  monitor.stop_log();

  EXPECT_TRUE(has_all_that_was_sent(folder / "robot.csv", controller));
  EXPECT_TRUE(messages.has("warning of the robot: RTDE: please stand by"));
  EXPECT_EQ(monitor.state().gaps, 0U);
  EXPECT_EQ(monitor.state().missing, 0U);
  EXPECT_EQ(monitor.state().rows, numbers_in_column(folder / "robot.csv", "timestamp").size());
}

TEST(RobotMonitor, WritesWhatTheRobotSentByItsNames) {
  FakeController controller({.first_timestamp = 100.1});
  const test::TemporaryFolder folder;
  auto options = options_for(controller);
  options.extra_fields = {"output_bit_register_64", "output_int_register_1"};
  RobotMonitor monitor(options);
  monitor.start_log(folder / "robot.csv");
  // The press and the lift are logged by then.
  ASSERT_TRUE(comes_true([&] { return monitor.newest("output_int_register_0") == 3.0; }));
  monitor.stop_log();

  const std::string text = read_text(folder / "robot.csv");
  const std::string header = text.substr(0, text.find('\n'));
  EXPECT_TRUE(header.starts_with("timestamp,target_q_0,target_q_1,")) << header;
  EXPECT_TRUE(header.ends_with(",output_double_register_0,output_bit_register_64,output_int_register_1,host_time_us")) << header;

  const auto columns = columns_in(folder / "robot.csv");
  const std::size_t rows = columns.at("timestamp").size();
  std::int64_t last_host_time = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    const double script_s = number_in(columns.at("timestamp")[i]).value() - 100.1;
    // The moment is rounded: an edge may fall on either side of it.
    const auto is_as_scripted = [&](const std::string& column, const RtdeField& field, std::size_t index) {
      const double logged = number_in(columns.at(column)[i]).value();
      return std::abs(logged - as_double(test::fake_output_at(field, script_s)[index])) < 1e-5 ||
             std::abs(logged - as_double(test::fake_output_at(field, std::max(0.0, script_s - 1e-6))[index])) < 1e-5 ||
             std::abs(logged - as_double(test::fake_output_at(field, script_s + 1e-6)[index])) < 1e-5;
    };
    ASSERT_TRUE(is_as_scripted("actual_TCP_pose_2", {"actual_TCP_pose", RtdeFieldType::vector6}, 2)) << "row " << i;
    ASSERT_TRUE(is_as_scripted("actual_TCP_speed_2", {"actual_TCP_speed", RtdeFieldType::vector6}, 2)) << "row " << i;
    ASSERT_TRUE(is_as_scripted("actual_digital_output_bits", {"actual_digital_output_bits", RtdeFieldType::uint64}, 0))
        << "row " << i;
    ASSERT_TRUE(is_as_scripted("output_int_register_1", {"output_int_register_1", RtdeFieldType::int32}, 0)) << "row " << i;
    const std::int64_t host_time = whole_number_in(columns.at("host_time_us")[i]).value();
    ASSERT_GE(host_time, last_host_time);
    last_host_time = host_time;
  }
  // And the reader finds the same.
  const RobotLogFile file = read_robot_log(folder / "robot.csv");
  const RobotLog& log = file.longest();
  EXPECT_EQ(log.states.size(), rows);
  EXPECT_EQ(us_of(log.states.back().host_time.value()), last_host_time);
  EXPECT_FALSE(file.cut_off);
  EXPECT_TRUE(file.restarts() == 0 && log.gaps.empty());
}

TEST(RobotMonitor, CountsThePackagesThatTheControllerSkipped) {
  FakeController controller({.drop_share = 0.1});
  const test::TemporaryFolder folder;
  RobotMonitor monitor(options_for(controller));
  monitor.start_log(folder / "robot.csv");
  ASSERT_TRUE(has_rows(monitor, 300));
  monitor.stop_log();
  const auto [gaps, missing] = gaps_in(folder / "robot.csv");
  EXPECT_GT(missing, 0U);
  EXPECT_EQ(monitor.state().gaps, gaps);
  EXPECT_EQ(monitor.state().missing, missing);
  EXPECT_TRUE(has_all_that_was_sent(folder / "robot.csv", controller));
}

TEST(RobotMonitor, TakesPackagesThatComeLateAndInBursts) {
  FakeController controller({.skew_ppm = 150, .jitter = true});
  const test::TemporaryFolder folder;
  RobotMonitor monitor(options_for(controller));
  monitor.start_log(folder / "robot.csv");
  ASSERT_TRUE(has_rows(monitor, 300));
  monitor.stop_log();
  EXPECT_TRUE(has_all_that_was_sent(folder / "robot.csv", controller));
  EXPECT_EQ(monitor.state().missing, 0U);
}

TEST(RobotMonitor, MarksARestartOfTheControllersClock) {
  FakeController controller;
  const test::TemporaryFolder folder;
  RobotMonitor monitor(options_for(controller));
  monitor.start_log(folder / "robot.csv");
  ASSERT_TRUE(has_rows(monitor, 100));
  controller.restart_clock();
  ASSERT_TRUE(comes_true([&] { return monitor.newest("timestamp").value_or(1e9) < 1'000; }));
  ASSERT_TRUE(has_rows(monitor, monitor.state().rows + 300));
  monitor.stop_log();
  EXPECT_EQ(monitor.state().gaps, 1U);
  EXPECT_EQ(monitor.state().missing, 0U);
  EXPECT_EQ(monitor.state().reconnects, 0U);

  const std::string text = read_text(folder / "robot.csv");
  EXPECT_NE(text.find("\n\n0,"), std::string::npos) << "an empty line ahead of the new clock's first row";
  const RobotLogFile file = read_robot_log(folder / "robot.csv");
  const RobotLog& log = file.longest();
  EXPECT_EQ(file.restarts(), 1U);
  EXPECT_EQ(log.states.size() + file.rows_elsewhere(), monitor.state().rows);
  EXPECT_GE(log.states.size(), file.rows_elsewhere());
  EXPECT_TRUE(std::is_sorted(log.states.begin(), log.states.end(), [](const auto& a, const auto& b) { return a.t < b.t; }));
}

TEST(RobotMonitor, ConnectsAgainAndMarksTheGap) {
  FakeController controller;
  const test::TemporaryFolder folder;
  MonitorLog messages;
  RobotMonitor monitor(options_for(controller, &messages));
  monitor.start_log(folder / "robot.csv");
  ASSERT_TRUE(has_rows(monitor, 100));
  controller.listen(false);
  controller.close_connections();
  ASSERT_TRUE(comes_true([&] { return !monitor.state().connected; }));
  EXPECT_FALSE(monitor.newest("timestamp").has_value());
  EXPECT_EQ(monitor.state().rate_hz, 0.0);
  EXPECT_TRUE(comes_true([&] { return messages.has("robot gone (tcp://127.0.0.1:" + std::to_string(controller.port())); }))
      << messages.all();
  // Some attempts find nobody.
  ASSERT_TRUE(comes_true([&] { return messages.has("robot still gone"); }));
  const std::uint64_t rows = monitor.state().rows;
  controller.listen(true);
  ASSERT_TRUE(has_rows(monitor, rows + 50));
  monitor.stop_log();

  EXPECT_TRUE(comes_true([&] { return messages.has("robot is back after"); })) << messages.all();
  EXPECT_EQ(monitor.state().reconnects, 1U);
  EXPECT_EQ(monitor.state().gaps, 1U);
  const RobotLogFile file = read_robot_log(folder / "robot.csv");
  const RobotLog& log = file.longest();
  EXPECT_EQ(file.restarts(), 0U);
  ASSERT_EQ(log.gaps.size(), 1U);
  const auto lost = std::llround(static_cast<double>((log.gaps[0].first_after - log.gaps[0].last_before).count()) / 2'000) - 1;
  EXPECT_EQ(monitor.state().missing, static_cast<std::uint64_t>(lost));
  EXPECT_EQ(log.states.size(), monitor.state().rows);
}

TEST(RobotMonitor, FindsARebootThatTheTimestampAloneDoesNotShow) {
  // The controller comes back with a clock that is ahead of what it was, by far more than it was away.
  auto controller = std::make_unique<FakeController>(FakeControllerOptions{.first_timestamp = 5});
  const std::uint16_t port = controller->port();
  const test::TemporaryFolder folder;
  RobotMonitor monitor(options_for(*controller));
  monitor.start_log(folder / "robot.csv");
  ASSERT_TRUE(has_rows(monitor, 50));
  controller.reset();
  controller = std::make_unique<FakeController>(FakeControllerOptions{.port = port, .first_timestamp = 900});
  ASSERT_TRUE(comes_true([&] { return monitor.newest("timestamp").value_or(0) > 900; }));
  ASSERT_TRUE(has_rows(monitor, monitor.state().rows + 100));
  monitor.stop_log();
  EXPECT_EQ(monitor.state().missing, 0U);
  EXPECT_EQ(read_robot_log(folder / "robot.csv").restarts(), 1U);
}

TEST(RobotMonitor, LeavesAControllerThatSendsGarbageAndConnectsAgain) {
  const std::vector<std::pair<std::string, std::function<void(FakeController&)>>> evils{
      {"type 254", [](FakeController& controller) { controller.send_garbage(); }},
      {"bytes too many", [](FakeController& controller) { controller.send_package_of_size(60'000); }},
      {"ends too early", [](FakeController& controller) { controller.send_package_of_size(40); }},
      {"closed the connection", [](FakeController& controller) { controller.send_half_a_package(); }}};
  for (const auto& [words, do_evil] : evils) {
    FakeController controller;
    const test::TemporaryFolder folder;
    MonitorLog messages;
    RobotMonitor monitor(options_for(controller, &messages));
    monitor.start_log(folder / "robot.csv");
    ASSERT_TRUE(has_rows(monitor, 20)) << words;
    do_evil(controller);
    ASSERT_TRUE(comes_true([&] { return monitor.state().reconnects == 1; })) << words << "\n" << messages.all();
    ASSERT_TRUE(has_rows(monitor, monitor.state().rows + 20)) << words;
    monitor.stop_log();
    EXPECT_TRUE(messages.has(words)) << messages.all();
    EXPECT_EQ(read_robot_log(folder / "robot.csv").longest().states.size(), monitor.state().rows) << words;
  }
}

TEST(RobotMonitor, TakesAShortSilenceAsAGapAndALongOneAsALoss) {
  FakeController controller;
  const test::TemporaryFolder folder;
  MonitorLog messages;
  auto options = options_for(controller, &messages);
  options.patience = 2s;
  RobotMonitor monitor(options);
  monitor.start_log(folder / "robot.csv");
  ASSERT_TRUE(has_rows(monitor, 20));
  controller.stall(true);
  ASSERT_TRUE(comes_true([&] { return messages.has("no data for 2 s"); })) << messages.all();
  controller.stall(false);
  ASSERT_TRUE(comes_true([&] { return monitor.state().connected && monitor.newest("timestamp").has_value(); })) << messages.all();
  ASSERT_TRUE(has_rows(monitor, monitor.state().rows + 20));
  monitor.stop_log();
  EXPECT_GE(monitor.state().reconnects, 1U);
  EXPECT_EQ(monitor.state().missing, gaps_in(folder / "robot.csv").missing);
  EXPECT_GT(monitor.state().missing, 0U);
  EXPECT_GE(read_robot_log(folder / "robot.csv").longest().gaps.size(), 1U);
}

}  // namespace
}  // namespace tactile::robot
