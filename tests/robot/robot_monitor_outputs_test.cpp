// What the monitor asks a controller for, and what it writes of it.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>

#include "robot/fake_controller.hpp"
#include "robot/monitored_robot.hpp"
#include "support/comes_true.hpp"
#include "support/held_port.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/robot/robot_log.hpp"
#include "tactile/robot/robot_monitor.hpp"

namespace tactile::robot {
namespace {

using test::columns_in;
using test::comes_true;
using test::complaint_of;
using test::FakeController;
using test::FakeControllerOptions;
using test::has_all_that_was_sent;
using test::has_rows;
using test::MonitorLog;
using test::numbers_in_column;
using test::options_for;

TEST(RobotMonitor, AsksForTheControllersHighestFrequency) {
  const auto step_of = [](const FakeControllerOptions& fake, double frequency_hz) {
    FakeController controller(fake);
    const test::TemporaryFolder folder;
    auto options = options_for(controller);
    options.frequency_hz = frequency_hz;
    RobotMonitor monitor(options);
    monitor.start_log(folder / "robot.csv");
    EXPECT_TRUE(has_rows(monitor, 10));
    monitor.stop_log();
    EXPECT_EQ(monitor.state().gaps, 0U);
    const auto times = numbers_in_column(folder / "robot.csv", "timestamp");
    return std::round(1e6 * (times.back() - times.front()) / static_cast<double>(times.size() - 1));
  };
  EXPECT_EQ(step_of({}, 0), 2'000);
  EXPECT_EQ(step_of({.version = {3, 15, 8, 106'339}, .highest_hz = 125}, 0), 8'000);
  EXPECT_EQ(step_of({}, 50), 20'000);
}

TEST(RobotMonitor, ReportsWhatTheControllerRefuses) {
  FakeController controller({.version = {3, 15, 8, 106'339}, .highest_hz = 125});
  auto options = options_for(controller);
  options.frequency_hz = 500;
  const std::string complaint = complaint_of([&] { RobotMonitor monitor(options); });
  EXPECT_NE(complaint.find("refuses to send"), std::string::npos) << complaint;
  EXPECT_NE(complaint.find("500 Hz; its version 3.15.8.106339 allows at most 125 Hz"), std::string::npos) << complaint;
  EXPECT_NE(complaint.find("500 Hz is more than 125"), std::string::npos) << complaint;
  options.frequency_hz = -1;
  EXPECT_NE(complaint_of([&] { RobotMonitor monitor(options); }).find("-1 Hz"), std::string::npos);

  FakeController old_one({.speaks_version_2 = false});
  EXPECT_NE(complaint_of([&] { RobotMonitor monitor(options_for(old_one)); }).find("does not speak RTDE version 2"),
            std::string::npos);
}

TEST(RobotMonitor, GoesWithoutWhatTheControllerDoesNotHave) {
  FakeController controller({.not_found = {"safety_status", "actual_tool_accelerometer"}});
  const test::TemporaryFolder folder;
  MonitorLog messages;
  auto options = options_for(controller, &messages);
  options.extra_fields = {"output_bit_register_4711"};
  RobotMonitor monitor(options);
  EXPECT_TRUE(messages.has("the robot has no actual_tool_accelerometer, safety_status, output_bit_register_4711"))
      << messages.all();
  monitor.start_log(folder / "robot.csv");
  ASSERT_TRUE(has_rows(monitor, 10));
  monitor.stop_log();
  const auto columns = columns_in(folder / "robot.csv");
  EXPECT_TRUE(columns.contains("safety_mode"));
  EXPECT_FALSE(columns.contains("safety_status"));
  EXPECT_FALSE(columns.contains("actual_tool_accelerometer_0"));
  EXPECT_THROW(monitor.newest("output_bit_register_4711"), Error);
}

TEST(RobotMonitor, NamesANeededOutputThatTheControllerDoesNotHave) {
  for (const std::string name : {"timestamp", "actual_TCP_pose", "actual_TCP_speed"}) {
    FakeController controller({.not_found = {name}});
    EXPECT_NE(complaint_of([&] { RobotMonitor monitor(options_for(controller)); }).find("has no output '" + name + "'"),
              std::string::npos);
  }
}

TEST(RobotMonitor, ReportsTheNewestValues) {
  FakeController controller;
  auto options = options_for(controller);
  options.extra_fields = {"output_bit_register_64", "timestamp"};
  RobotMonitor monitor(options);
  EXPECT_TRUE(comes_true([&] { return monitor.newest("output_bit_register_64") == 1.0; }));
  EXPECT_TRUE(comes_true([&] { return monitor.newest("actual_TCP_pose_2") == 0.25; }));
  EXPECT_EQ(monitor.newest("robot_mode"), 7.0);
  EXPECT_TRUE(comes_true([&] { return monitor.state().rate_hz > 100; }));
  EXPECT_THROW(monitor.newest("actual_TCP_pose"), Error) << "a vector has no one value";
  EXPECT_THROW(monitor.newest("output_bit_register_65"), Error) << "not asked for";
}

TEST(RobotMonitor, LeavesOutRowsThatAreNoNumbers) {
  FakeController controller({.sends_nan = true});
  const test::TemporaryFolder folder;
  MonitorLog messages;
  RobotMonitor monitor(options_for(controller, &messages));
  monitor.start_log(folder / "robot.csv");
  ASSERT_TRUE(has_rows(monitor, 100));
  monitor.stop_log();
  EXPECT_TRUE(messages.has("not finite numbers")) << messages.all();
  EXPECT_EQ(read_robot_log(folder / "robot.csv").longest().states.size(), monitor.state().rows);
  EXPECT_GE(monitor.state().missing, 9U);
}

TEST(RobotMonitor, WritesOneLogAfterTheOther) {
  FakeController controller;
  const test::TemporaryFolder folder;
  RobotMonitor monitor(options_for(controller));
  monitor.stop_log();  // there is none: nothing to do
  monitor.start_log(folder / "first.csv");
  EXPECT_THROW(monitor.start_log(folder / "other.csv"), Error);
  EXPECT_FALSE(std::filesystem::exists(folder / "other.csv"));
  ASSERT_TRUE(has_rows(monitor, 100));
  monitor.stop_log();
  const std::string first = read_text(folder / "first.csv");
  EXPECT_NE(complaint_of([&] { monitor.start_log(folder / "first.csv"); }).find("exists already"), std::string::npos);
  EXPECT_THROW(monitor.start_log(folder / "no such folder" / "robot.csv"), Error);
  monitor.start_log(folder / "second.csv");
  ASSERT_TRUE(has_rows(monitor, 10));
  monitor.stop_log();
  EXPECT_EQ(read_text(folder / "first.csv"), first);
  EXPECT_EQ(read_robot_log(folder / "second.csv").longest().states.size(), monitor.state().rows);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 2) << "no temporary file stays";
}

TEST(RobotMonitor, CountsAGapWhereALogBeginsOrEndsWithoutTheRobot) {
  FakeController controller;
  const test::TemporaryFolder folder;
  RobotMonitor monitor(options_for(controller));
  controller.listen(false);
  controller.close_connections();
  ASSERT_TRUE(comes_true([&] { return !monitor.state().connected; }));
  monitor.start_log(folder / "none.csv");
  EXPECT_EQ(monitor.state().gaps, 1U) << "at once";
  std::this_thread::sleep_for(100ms);  // at least: what must be missing follows from it
  monitor.stop_log();
  EXPECT_EQ(monitor.state().rows, 0U);
  EXPECT_EQ(monitor.state().gaps, 1U);
  EXPECT_GE(monitor.state().missing, 50U);

  monitor.start_log(folder / "late.csv");
  std::this_thread::sleep_for(100ms);
  controller.listen(true);
  ASSERT_TRUE(has_rows(monitor, 50));
  EXPECT_EQ(monitor.state().gaps, 1U);
  const std::uint64_t missing = monitor.state().missing;
  EXPECT_GE(missing, 50U);
  controller.listen(false);
  controller.close_connections();
  ASSERT_TRUE(comes_true([&] { return !monitor.state().connected; }));
  std::this_thread::sleep_for(100ms);
  monitor.stop_log();
  EXPECT_EQ(monitor.state().gaps, 2U);
  EXPECT_GE(monitor.state().missing, missing + 50);
  const RobotLogFile file = read_robot_log(folder / "late.csv");
  const RobotLog& log = file.longest();
  EXPECT_EQ(log.states.size(), monitor.state().rows);
  EXPECT_TRUE(file.restarts() == 0 && log.gaps.empty());
}

TEST(RobotMonitor, ReportsHowTheControllersClockGoesAgainstTheHosts) {
  FakeController controller({.first_timestamp = 5'000, .skew_ppm = 50'000});
  const test::TemporaryFolder folder;
  RobotMonitor monitor(options_for(controller));
  monitor.start_log(folder / "first.csv");
  ASSERT_TRUE(comes_true([&] { return monitor.state().clock.value_or(ClockOffset{}).span > 1500ms; }));
  const ClockOffset clock = *monitor.state().clock;
  const double expected = -0.05 * static_cast<double>(clock.span.count());
  EXPECT_NEAR(static_cast<double>(clock.change.count()), expected, 0.2 * std::abs(expected)) << "a fast clock";
  monitor.stop_log();
  // Its start is the smallest difference of the first two seconds by the host's clock.
  const auto robot_s = numbers_in_column(folder / "first.csv", "timestamp");
  const auto host_us = numbers_in_column(folder / "first.csv", "host_time_us");
  const double second = std::floor(host_us.front() / 1e6);
  double smallest_us = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < host_us.size() && std::floor(host_us[i] / 1e6) <= second + 1; ++i)
    smallest_us = std::min(smallest_us, host_us[i] - 1e6 * robot_s[i]);
  EXPECT_NEAR(static_cast<double>((clock.offset - clock.change).count()), smallest_us, 2);

  monitor.start_log(folder / "second.csv");
  EXPECT_LT(monitor.state().clock.value_or(ClockOffset{}).span, clock.span) << "each log begins again";
  ASSERT_TRUE(comes_true([&] { return monitor.state().clock.value_or(ClockOffset{}).span > 1000ms; }));
  controller.restart_clock();
  ASSERT_TRUE(comes_true([&] { return monitor.state().clock_starts == 2; }));
  EXPECT_LT(monitor.state().clock.value_or(ClockOffset{}).span, 1000ms) << "and so does each clock";
}

TEST(RobotMonitor, CountsStartsOfTheClockBetweenLogsToo) {
  auto controller = std::make_unique<FakeController>(FakeControllerOptions{.first_timestamp = 5'000});
  const std::uint16_t port = controller->port();
  RobotMonitor monitor(options_for(*controller));
  ASSERT_TRUE(comes_true([&] { return monitor.newest("timestamp").has_value(); }));
  EXPECT_EQ(monitor.state().clock_starts, 1U);
  controller->close_connections();
  ASSERT_TRUE(comes_true([&] { return monitor.state().reconnects == 1 && monitor.newest("timestamp").has_value(); }));
  EXPECT_EQ(monitor.state().clock_starts, 1U) << "the same clock is back";
  controller->restart_clock();
  ASSERT_TRUE(comes_true([&] { return monitor.newest("timestamp").value_or(1e9) < 4'000; }));
  EXPECT_EQ(monitor.state().clock_starts, 2U);
  controller.reset();
  controller = std::make_unique<FakeController>(FakeControllerOptions{.port = port, .first_timestamp = 9'000});
  ASSERT_TRUE(comes_true([&] { return monitor.newest("timestamp").value_or(0) >= 9'000; }));
  EXPECT_EQ(monitor.state().clock_starts, 3U);
}

TEST(RobotMonitor, RefusesAControllerWithoutARequiredNumber) {
  FakeController controller;
  MonitorLog messages;
  auto options = options_for(controller, &messages);
  options.required_fields = {"output_bit_register_64", "output_bit_register_4711"};
  EXPECT_NE(complaint_of([&] { RobotMonitor monitor(options); }).find("has no output 'output_bit_register_4711'"),
            std::string::npos);
  EXPECT_EQ(messages.all(), "");
  options.required_fields = {"actual_TCP_pose"};
  EXPECT_NE(complaint_of([&] { RobotMonitor monitor(options); }).find("'actual_TCP_pose' is a VECTOR6D"), std::string::npos);
  options.required_fields = {"output_bit_register_64"};
  RobotMonitor monitor(options);
  EXPECT_TRUE(comes_true([&] { return monitor.newest("output_bit_register_64").has_value(); }));
}

TEST(RobotMonitor, ReportsARepeatedMessageOnceAndItsCountAtTheEnd) {
  FakeController controller({.text_every = 7});
  const test::TemporaryFolder folder;
  MonitorLog messages;
  {
    RobotMonitor monitor(options_for(controller, &messages));
    monitor.start_log(folder / "robot.csv");
    ASSERT_TRUE(has_rows(monitor, 100));
  }
  const std::string words = "warning of the robot: RTDE: please stand by";
  EXPECT_TRUE(messages.has(words + "\n")) << messages.all();
  EXPECT_TRUE(messages.has(words + " (came ")) << messages.all();
}

TEST(RobotMonitor, ReportsThatNothingAnswers) {
  const test::HeldPort held;
  RobotMonitorOptions options;
  options.host = "127.0.0.1";
  options.port = held.port();
  const std::string refused = complaint_of([&] { RobotMonitor monitor(options); });
  EXPECT_NE(refused.find("tcp://127.0.0.1:" + std::to_string(held.port())), std::string::npos) << refused;

  // A server that takes the connection and never says a word.
  const int silent = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ASSERT_EQ(::bind(silent, reinterpret_cast<const sockaddr*>(&address), size), 0);
  ASSERT_EQ(::listen(silent, 1), 0);
  ASSERT_EQ(::getsockname(silent, reinterpret_cast<sockaddr*>(&address), &size), 0);
  options.port = ntohs(address.sin_port);
  options.patience = 200ms;
  const std::string complaint = complaint_of([&] { RobotMonitor monitor(options); });
  EXPECT_NE(complaint.find("no answer to the version request within 0.2 s"), std::string::npos) << complaint;
  ::close(silent);
}

TEST(RobotMonitor, EndsTheLogAndListensOnWhenTheDiskIsFull) {
  FakeController controller;
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "robot.csv";
  const auto result = test::run_shell(std::string("'") + LOG_ROBOT_BINARY + "' " + std::to_string(controller.port()) + " '" +
                                      file.string() + "' 100001");
  EXPECT_EQ(result.exit_code, 3) << result.err;
  EXPECT_NE(result.out.find("robot.csv: cannot be written any further (File too large)"), std::string::npos) << result.out;
  const std::string text = read_text(file);
  EXPECT_TRUE(text.ends_with("\n")) << "half a row stayed";
  EXPECT_GT(text.size(), 99'000U);
  EXPECT_GT(read_robot_log(file).longest().states.size(), 100U);
  EXPECT_TRUE(has_all_that_was_sent(file, controller));
}

}  // namespace
}  // namespace tactile::robot
