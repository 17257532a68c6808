#include "tactile/robot/robot_monitor.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <mutex>
#include <sstream>
#include <thread>

#include "robot/fake_controller.hpp"
#include "support/comes_true.hpp"
#include "support/held_port.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile::robot {
namespace {

using test::comes_true;
using test::FakeController;
using test::FakeControllerOptions;

/// What the monitor told, kept over its threads.
class Told {
 public:
  void operator()(const std::string& text) {
    const std::lock_guard lock(mutex_);
    lines_ += text + "\n";
  }
  bool has(const std::string& words) const {
    const std::lock_guard lock(mutex_);
    return lines_.find(words) != std::string::npos;
  }
  std::string all() const {
    const std::lock_guard lock(mutex_);
    return lines_;
  }

 private:
  mutable std::mutex mutex_;
  std::string lines_;
};

RobotMonitorOptions options_for(const FakeController& controller, Told* told = nullptr) {
  RobotMonitorOptions options;
  options.host = "127.0.0.1";
  options.port = controller.port();
  options.patience = 30s;
  if (told != nullptr) options.log = [told](const std::string& text) { (*told)(text); };
  return options;
}

[[nodiscard]] bool has_rows(const RobotMonitor& monitor, std::uint64_t rows) {
  return comes_true([&] { return monitor.state().rows >= rows; });
}

/// A log as columns of text by name; empty lines left out.
std::map<std::string, std::vector<std::string>> columns_in(const std::filesystem::path& file) {
  std::istringstream in(read_text(file));
  std::string line, cell;
  std::vector<std::string> names;
  std::map<std::string, std::vector<std::string>> columns;
  while (std::getline(in, line)) {
    if (line.empty()) continue;
    std::istringstream cells(line);
    const bool is_header = names.empty();
    for (std::size_t i = 0; std::getline(cells, cell, ','); ++i) {
      if (is_header) {
        names.push_back(cell);
      } else {
        columns[names.at(i)].push_back(cell);
      }
    }
  }
  return columns;
}

std::vector<double> numbers_in_column(const std::filesystem::path& file, const std::string& name) {
  std::vector<double> numbers;
  const auto columns = columns_in(file);
  for (const std::string& cell : columns.at(name)) numbers.push_back(number_in(cell).value());
  return numbers;
}

/// True if the log has exactly what the controller sent from the log's first row to its last.
::testing::AssertionResult has_all_that_was_sent(const std::filesystem::path& file, const FakeController& controller) {
  const std::vector<double> logged = numbers_in_column(file, "timestamp");
  const std::vector<double> sent = controller.sent();
  const auto first = std::find(sent.begin(), sent.end(), logged.front());
  if (first == sent.end()) return ::testing::AssertionFailure() << logged.front() << " was never sent";
  if (static_cast<std::size_t>(sent.end() - first) < logged.size() || !std::equal(logged.begin(), logged.end(), first))
    return ::testing::AssertionFailure() << "the log's " << logged.size() << " rows are not those that were sent";
  return ::testing::AssertionSuccess();
}

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

std::string complaint_of(const std::function<void()>& step) {
  try {
    step();
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(RobotMonitor, LogsEveryPackageHoweverTheStreamIsCut) {
  FakeController controller({.split_writes = true, .text_every = 7});
  const test::TemporaryFolder folder;
  Told told;
  RobotMonitor monitor(options_for(controller, &told));
  EXPECT_EQ(monitor.state().controller, "5.11.6.1071234");
  monitor.start_log(folder / "robot.csv");
  ASSERT_TRUE(has_rows(monitor, 300));
  monitor.stop_log();

  EXPECT_TRUE(has_all_that_was_sent(folder / "robot.csv", controller));
  EXPECT_TRUE(told.has("warning of the robot: RTDE: please stand by"));
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
  // The press and the lift are told by then.
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
  Told told;
  RobotMonitor monitor(options_for(controller, &told));
  monitor.start_log(folder / "robot.csv");
  ASSERT_TRUE(has_rows(monitor, 100));
  controller.listen(false);
  controller.close_connections();
  ASSERT_TRUE(comes_true([&] { return !monitor.state().connected; }));
  EXPECT_FALSE(monitor.newest("timestamp").has_value());
  EXPECT_EQ(monitor.state().rate_hz, 0.0);
  EXPECT_TRUE(comes_true([&] { return told.has("robot gone (tcp://127.0.0.1:" + std::to_string(controller.port())); }))
      << told.all();
  // Some attempts find nobody.
  ASSERT_TRUE(comes_true([&] { return told.has("robot still gone"); }));
  const std::uint64_t rows = monitor.state().rows;
  controller.listen(true);
  ASSERT_TRUE(has_rows(monitor, rows + 50));
  monitor.stop_log();

  EXPECT_TRUE(comes_true([&] { return told.has("robot is back after"); })) << told.all();
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
    Told told;
    RobotMonitor monitor(options_for(controller, &told));
    monitor.start_log(folder / "robot.csv");
    ASSERT_TRUE(has_rows(monitor, 20)) << words;
    do_evil(controller);
    ASSERT_TRUE(comes_true([&] { return monitor.state().reconnects == 1; })) << words << "\n" << told.all();
    ASSERT_TRUE(has_rows(monitor, monitor.state().rows + 20)) << words;
    monitor.stop_log();
    EXPECT_TRUE(told.has(words)) << told.all();
    EXPECT_EQ(read_robot_log(folder / "robot.csv").longest().states.size(), monitor.state().rows) << words;
  }
}

TEST(RobotMonitor, TakesAShortSilenceAsAGapAndALongOneAsALoss) {
  FakeController controller;
  const test::TemporaryFolder folder;
  Told told;
  auto options = options_for(controller, &told);
  options.patience = 2s;
  RobotMonitor monitor(options);
  monitor.start_log(folder / "robot.csv");
  ASSERT_TRUE(has_rows(monitor, 20));
  controller.stall(true);
  ASSERT_TRUE(comes_true([&] { return told.has("no data for 2 s"); })) << told.all();
  controller.stall(false);
  ASSERT_TRUE(comes_true([&] { return monitor.state().connected && monitor.newest("timestamp").has_value(); })) << told.all();
  ASSERT_TRUE(has_rows(monitor, monitor.state().rows + 20));
  monitor.stop_log();
  EXPECT_GE(monitor.state().reconnects, 1U);
  EXPECT_EQ(monitor.state().missing, gaps_in(folder / "robot.csv").missing);
  EXPECT_GT(monitor.state().missing, 0U);
  EXPECT_GE(read_robot_log(folder / "robot.csv").longest().gaps.size(), 1U);
}

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
  Told told;
  auto options = options_for(controller, &told);
  options.extra_fields = {"output_bit_register_4711"};
  RobotMonitor monitor(options);
  EXPECT_TRUE(told.has("the robot has no actual_tool_accelerometer, safety_status, output_bit_register_4711")) << told.all();
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
  Told told;
  RobotMonitor monitor(options_for(controller, &told));
  monitor.start_log(folder / "robot.csv");
  ASSERT_TRUE(has_rows(monitor, 100));
  monitor.stop_log();
  EXPECT_TRUE(told.has("not finite numbers")) << told.all();
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
  Told told;
  auto options = options_for(controller, &told);
  options.required_fields = {"output_bit_register_64", "output_bit_register_4711"};
  EXPECT_NE(complaint_of([&] { RobotMonitor monitor(options); }).find("has no output 'output_bit_register_4711'"),
            std::string::npos);
  EXPECT_EQ(told.all(), "");
  options.required_fields = {"actual_TCP_pose"};
  EXPECT_NE(complaint_of([&] { RobotMonitor monitor(options); }).find("'actual_TCP_pose' is a VECTOR6D"), std::string::npos);
  options.required_fields = {"output_bit_register_64"};
  RobotMonitor monitor(options);
  EXPECT_TRUE(comes_true([&] { return monitor.newest("output_bit_register_64").has_value(); }));
}

TEST(RobotMonitor, ReportsARepeatedMessageOnceAndItsCountAtTheEnd) {
  FakeController controller({.text_every = 7});
  const test::TemporaryFolder folder;
  Told told;
  {
    RobotMonitor monitor(options_for(controller, &told));
    monitor.start_log(folder / "robot.csv");
    ASSERT_TRUE(has_rows(monitor, 100));
  }
  const std::string words = "warning of the robot: RTDE: please stand by";
  EXPECT_TRUE(told.has(words + "\n")) << told.all();
  EXPECT_TRUE(told.has(words + " (came ")) << told.all();
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
