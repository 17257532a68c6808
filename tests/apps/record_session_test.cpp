#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/record_command.hpp"
#include "events/made_recording.hpp"
#include "robot/fake_controller.hpp"
#include "support/comes_true.hpp"
#include "support/run_command.hpp"
#include "support/running_command.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/packet_checksums.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/robot/robot_log.hpp"
#include "transport/dv/dv_stream_bytes.hpp"
#include "transport/scripted_server.hpp"
#include "video/made_film.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;
using test::CommandResult;
using test::lines_in;
using test::RecordCommand;
using test::RunningCommand;
using test::ScriptedServer;

TEST_F(RecordCommand, WalksASession) {
  write_whole(folder / "plan.json",
              R"({"session": "monday", "objects": [{"name": "fan", "runs": 2}, {"name": "usb-hub"}], "duration": 0.1})");
  {
    RunningCommand command("record --json --out data --session plan.json --from sim --speed 0", folder.path());
    command.type("\n\nr\nnonsense\n\n\n");
    const auto says = [&](const std::string& text) {
      return test::comes_true([&] { return command.err().find(text) != std::string::npos || command.has_ended(); });
    };
    ASSERT_TRUE(says("End of the list"));
    command.type("\n");
    const CommandResult result = command.wait();
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const nlohmann::json runs = nlohmann::json::parse(result.out).at("runs");
    ASSERT_EQ(runs.size(), 3U);
    for (const nlohmann::json& run : runs) {
      EXPECT_EQ(run.at("session"), runs.at(0).at("session"));
      EXPECT_EQ(run.at("ended"), "duration");
      EXPECT_GT(run.at("events"), 0);
    }
    EXPECT_EQ(runs.at(0).at("session").get<std::string>().substr(0, 7), "monday-");
    EXPECT_NE(result.err.find("fan/02 is now 02.discarded-1"), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("'nonsense' is no answer here"), std::string::npos) << result.err;
  }
  EXPECT_EQ(find_runs(folder / "data").size(), 3U);
  EXPECT_TRUE(fs::exists(folder / "data/fan/02.discarded-1/events.aedat4"));
  EXPECT_EQ(run("info --check data").exit_code, 0);

  // An interrupted session resumes where it stopped.
  write_whole(folder / "longer.json", R"({"objects": [{"name": "fan", "runs": 3}, {"name": "usb-hub"}], "duration": 0.1})");
  RunningCommand command("record --json --out data --session longer.json --from sim --speed 0", folder.path());
  command.type("\n\n");
  command.close_input();
  const CommandResult result = command.wait();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json runs = nlohmann::json::parse(result.out).at("runs");
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_EQ(runs.at(0).at("folder"), "data/fan/03");
}

TEST_F(RecordCommand, EndsASessionWhereItsFileEnds) {
  write_whole(folder / "plan.json", R"({"objects": [{"name": "fan", "runs": 3}], "duration": 10})");
  RunningCommand command("record --json --session plan.json --from file:recordings/dv-lz4.aedat4 --speed 0", folder.path());
  command.type("\n\n\n");
  const CommandResult result = command.wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out).at("runs").size(), 1U);
  EXPECT_NE(result.err.find("no further run can be recorded"), std::string::npos) << result.err;
}

TEST_F(RecordCommand, LetsTheRobotStartAndStopRuns) {
  test::FakeController controller;
  write_whole(folder / "plan.json", R"({"objects": [{"name": "fan", "runs": 1}], "start_on": "actual_digital_output_bits:0",
                                        "stop_on": "actual_digital_input_bits:1"})");
  RunningCommand command(
      "record --json --out data --session plan.json --from sim:fan --robot 127.0.0.1:" + std::to_string(controller.port()),
      folder.path());
  const CommandResult result = command.wait();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json runs = nlohmann::json::parse(result.out).at("runs");
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_EQ(runs.at(0).at("ended"), "stopped by actual_digital_input_bits:1");
  const robot::RobotLog log = robot::read_robot_log(folder / "data/fan/01/robot.csv").longest();
  ASSERT_FALSE(log.states.empty());
  EXPECT_EQ(runs.at(0).at("robot").at("rows"), log.states.size());
  EXPECT_EQ(log.states.back().digital_output_bits.value() & 1U, log.states.front().digital_output_bits.value() & 1U);
  EXPECT_EQ(run_json("fan", "01").at("settings").at("start_on"), "actual_digital_output_bits:0");
}

TEST_F(RecordCommand, ReportsThatNothingCameFromTheRobot) {
  test::FakeController controller;
  controller.stall(true);
  const CommandResult result =
      run("record --from file:recordings/dv-lz4.aedat4 --speed 0 --robot 127.0.0.1:" + std::to_string(controller.port()));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("unnamed/01: no data came from the robot"), std::string::npos) << result.err;
}

TEST_F(RecordCommand, ContinuesWithoutTheRobotAndTakesItBack) {
  test::FakeController controller;
  make_long_recording();
  RunningCommand command("record --json --from file:long.aedat4 --robot 127.0.0.1:" + std::to_string(controller.port()),
                         folder.path());
  const RunFolder run = run_folder("unnamed", "01");
  ASSERT_TRUE(has_begun(run, command)) << command.err();
  ASSERT_TRUE(test::comes_true([&] { return fs::exists(run.robot()) && fs::file_size(run.robot()) > 10'000; }));
  controller.close_connections();
  ASSERT_TRUE(test::comes_true([&] { return command.err().find("robot gone") != std::string::npos; })) << command.err();
  ASSERT_TRUE(test::comes_true([&] { return command.err().find("robot is back") != std::string::npos; })) << command.err();
  const auto rows = fs::file_size(run.robot());
  ASSERT_TRUE(test::comes_true([&] { return fs::file_size(run.robot()) > rows + 10'000; }));
  command.signal(SIGINT);
  const CommandResult result = command.wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("robot").at("reconnects"), 1);
  EXPECT_GE(json.at("robot").at("gaps"), 1);
  EXPECT_EQ(json.at("complete"), true);
  EXPECT_GE(run_json("unnamed", "01").at("dropped").at("robot_gaps"), 1);
  EXPECT_GE(robot::read_robot_log(run.robot()).longest().gaps.size(), 1U);
}

TEST_F(RecordCommand, NamesASessionByTheRobotsClock) {
  test::FakeController controller;
  write_whole(folder / "plan.json", R"({"objects": [{"name": "fan", "runs": 4}], "duration": 0.1})");
  RunningCommand command(
      "record --json --out data --session plan.json --from sim --speed 0 --robot 127.0.0.1:" + std::to_string(controller.port()),
      folder.path());
  const auto says = [&](const std::string& text) {
    return test::comes_true([&] { return command.err().find(text) != std::string::npos || command.has_ended(); }) &&
           !command.has_ended();
  };
  command.type("\n");
  ASSERT_TRUE(says("fan, run 2 of 4")) << command.err();
  controller.close_connections();
  ASSERT_TRUE(says("robot is back")) << command.err();
  command.type("\n");
  ASSERT_TRUE(says("fan, run 3 of 4")) << command.err();
  const std::size_t sent = controller.sent().size();
  controller.restart_clock();
  ASSERT_TRUE(test::comes_true([&] { return controller.sent().size() > sent + 1'000; }));  // of which it has read the first
  command.type("\n");
  ASSERT_TRUE(says("fan, run 4 of 4")) << command.err();
  controller.listen(false);
  controller.close_connections();
  ASSERT_TRUE(says("robot still gone")) << command.err();
  command.type("\n");
  ASSERT_TRUE(says("End of the list")) << command.err();
  command.type("\n");
  const CommandResult result = command.wait();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json runs = nlohmann::json::parse(result.out).at("runs");
  ASSERT_EQ(runs.size(), 4U);
  const auto session = [&](std::size_t index) { return runs.at(index).at("session").get<std::string>(); };
  EXPECT_EQ(session(1), session(0)) << "the network alone was gone";
  EXPECT_EQ(session(2), session(0) + "-2") << "the clock started again on an open connection";
  EXPECT_EQ(session(3), session(0) + "-3") << "its clock is not known";
  EXPECT_NE(result.err.find("fan/04 begins without the robot"), std::string::npos) << result.err;
  EXPECT_EQ(run_json("fan", "04").at("dropped").at("robot_gaps"), 1);
}

TEST_F(RecordCommand, RefusesABitThatTheRobotDoesNotHave) {
  test::FakeController controller;
  for (const char* field : {"--stop-on output_bit_register_4711", "--start-on actual_TCP_pose:1"}) {
    const CommandResult result =
        run("record --from sim " + std::string(field) + " --robot 127.0.0.1:" + std::to_string(controller.port()));
    EXPECT_EQ(result.exit_code, 1) << field;
    EXPECT_EQ(lines_in(result.err), 1) << result.err;
    EXPECT_FALSE(fs::exists(folder / "data") || fs::exists(folder / "data-sim")) << field;
  }
}

TEST_F(RecordCommand, ReportsThatABitIsHighAlready) {
  test::FakeController controller;
  RunningCommand command("record --from sim --start-on robot_mode --robot 127.0.0.1:" + std::to_string(controller.port()),
                         folder.path());
  ASSERT_TRUE(test::comes_true([&] {
    return command.err().find("robot_mode is high already: it must fall") != std::string::npos || command.has_ended();
  }));
  command.signal(SIGINT);
  const CommandResult result = command.wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, "no run recorded\n");
}

TEST_F(RecordCommand, EndsWithoutARunIfStoppedWhileItOpensItsSources) {
  std::atomic<bool> is_asked = false;
  ScriptedServer server([&](ScriptedServer::Socket& client) {
    is_asked = true;
    test::until_closed(client);
  });
  RunningCommand command("record --from sim --robot 127.0.0.1:" + std::to_string(server.address().port), folder.path());
  ASSERT_TRUE(test::comes_true([&] { return is_asked.load(); }));
  command.signal(SIGINT);
  const CommandResult result = command.wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, "no run recorded\n");
  EXPECT_FALSE(fs::exists(folder / "data") || fs::exists(folder / "data-sim"));
}

TEST_F(RecordCommand, RecordsAnInterruptedRunOfASessionAgain) {
  make_long_recording();
  write_whole(folder / "plan.json", R"({"objects": [{"name": "fan", "runs": 1}], "duration": 0.5})");
  write_whole(folder / "long.json", R"({"objects": [{"name": "fan", "runs": 1}], "duration": 1000})");
  {
    RunningCommand command("record --session long.json --from file:long.aedat4", folder.path());
    command.type("\n");
    ASSERT_TRUE(has_begun(run_folder("fan", "01"), command)) << command.err();
    command.signal(SIGINT);
    const CommandResult result = command.wait();
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_NE(result.err.find("does not count for the plan"), std::string::npos) << result.err;
  }
  RunningCommand command("record --json --session plan.json --from file:long.aedat4 --speed 0", folder.path());
  command.type("\n");
  command.close_input();
  const CommandResult result = command.wait();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out).at("runs").at(0).at("folder"), "data/fan/02");
  EXPECT_TRUE(fs::exists(folder / "data/fan/01/events.aedat4"));
}

TEST_F(RecordCommand, ReportsWhatASessionRecordedAheadOfAnError) {
  write_whole(folder / "plan.json", R"({"objects": [{"name": "fan"}, {"name": "usb-hub"}], "duration": 0.1})");
  fs::create_directory(folder / "data");
  write_whole(folder / "data/usb-hub", "no folder");
  RunningCommand command("record --json --out data --session plan.json --from sim --speed 0", folder.path());
  command.type("\n\n");
  const CommandResult result = command.wait();
  EXPECT_EQ(result.exit_code, 1);
  const nlohmann::json json = nlohmann::json::parse(result.out);
  ASSERT_EQ(json.at("runs").size(), 1U);
  EXPECT_NE(json.at("error").get<std::string>().find("data/usb-hub"), std::string::npos) << json.at("error");
  EXPECT_NE(result.err.find("data/usb-hub"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace tactile::cli
