#include <gtest/gtest.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "events/made_recording.hpp"
#include "robot/fake_controller.hpp"
#include "support/comes_true.hpp"
#include "support/events_in_file.hpp"
#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/running_command.hpp"
#include "support/temporary_folder.hpp"
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
using test::events_in_file;
using test::RunningCommand;
using test::ScriptedServer;

constexpr events::SensorSize size{640, 480};

std::ptrdiff_t lines_in(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

class RecordCommand : public testing::Test {
 protected:
  RecordCommand() { fs::create_directory_symlink(std::string(test::data_folder) + "/aedat4", folder / "recordings"); }
  CommandResult run(const std::string& arguments) const { return test::run_tactile(arguments, folder.path()); }
  RunFolder run_folder(const std::string& object, const std::string& number) const {
    return {folder / "data" / object / number, object, number};
  }
  nlohmann::json run_json(const std::string& object, const std::string& number) const {
    return read_json(run_folder(object, number).info());
  }
  /// Twenty seconds of events and an hour of one a second, so that a replay at its own pace outlives every test.
  std::vector<events::Event> make_long_recording() const {
    std::vector<events::Event> events = test::steady_events(400'000, 1'000'000, 50, size);
    for (const events::Event& later : test::steady_events(3'600, 22'000'000, 1'000'000, size)) events.push_back(later);
    events::RecordingWriter writer(folder / "long.aedat4", {events::event_stream_declaration(size, "DVXplorer_DXM00001")});
    writer.write_events(0, events);
    writer.close();
    return events;
  }
  bool has_begun(const RunFolder& run, RunningCommand& command) const {
    return test::comes_true(
               [&] { return (fs::exists(run.events()) && fs::file_size(run.events()) > 0) || command.has_ended(); }) &&
           !command.has_ended();
  }

  test::TemporaryFolder folder;
};

TEST_F(RecordCommand, RecordsAReplayWithAllItsStreams) {
  const CommandResult result = run("record --json --from file:recordings/dv-lz4.aedat4 --speed 0 --object fan");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("folder"), "data/fan/01");
  EXPECT_EQ(json.at("events"), 6000);
  EXPECT_EQ(json.at("others"), 59);
  EXPECT_EQ(json.at("complete"), true);
  EXPECT_EQ(json.at("dropped").at("events"), 0);
  EXPECT_EQ(json.at("ended"), "source ended");
  EXPECT_EQ(json.at("robot"), nullptr);
  EXPECT_EQ(events_in_file(folder / "data/fan/01/events.aedat4"), events_in_file(folder / "recordings/dv-lz4.aedat4"));
  const CommandResult check = run("info --check data/fan/01");
  EXPECT_EQ(check.exit_code, 0) << check.err;

  const CommandResult again = run("record --from file:recordings/dv-lz4.aedat4 --speed 0 --object fan --quiet");
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_EQ(again.err, "");
  EXPECT_NE(again.out.find("data/fan/02"), std::string::npos) << again.out;
  EXPECT_NE(run_json("fan", "01").at("session"), run_json("fan", "02").at("session"));
}

TEST_F(RecordCommand, ReportsWhatItRecordedBesidesTheEvents) {
  const std::vector<events::Event> events = test::steady_events(1001, 5'000'000, 100, size);  // 0.1 s of events
  {
    const events::Stream imu = test::stream_of(1, events::StreamType::imu, "IMUS", "DVXplorer_DXM00001");
    events::RecordingWriter writer(folder / "in.aedat4", {events::event_stream_declaration(size, "DVXplorer_DXM00001"), imu});
    writer.write_events(0, events);
    const std::array<events::ImuSample, 2> samples{events::ImuSample{.t = camera_time(5'000'000)},
                                                   events::ImuSample{.t = camera_time(6'000'000)}};
    writer.write_imu(1, samples);
    writer.close();
  }
  const CommandResult result = run("record --json --from file:in.aedat4 --speed 0");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("imu_samples"), 2);
  EXPECT_EQ(json.at("triggers"), 0);
  EXPECT_EQ(json.at("others"), 2);
  EXPECT_DOUBLE_EQ(json.at("duration_s").get<double>(), 1);
  EXPECT_DOUBLE_EQ(json.at("events_per_s").get<double>(), 10'010) << "over the events' own span";
  const CommandResult text = run("record --from file:in.aedat4 --speed 0");
  EXPECT_NE(text.out.find("imu      2 samples\n"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("1001 in 100.0 ms, 10.0 k/s"), std::string::npos) << text.out;
}

TEST_F(RecordCommand, ReportsWhatAReplayedRecordingLacks) {
  fs::copy_file(folder / "recordings/dv-lz4.aedat4", folder / "cut.aedat4");
  fs::resize_file(folder / "cut.aedat4", 40'000);
  const CommandResult cut = run("record --from file:cut.aedat4 --speed 0");
  EXPECT_EQ(cut.exit_code, 0);
  EXPECT_NE(cut.err.find("file:cut.aedat4: "), std::string::npos) << cut.err;
  EXPECT_NE(cut.err.find("after the last whole packet are lost"), std::string::npos) << cut.err;
  EXPECT_EQ(run("record --from file:recordings/dv-lz4.aedat4 --speed 0 --quiet").err, "") << "which is whole";

  test::cut_off_table(folder / "data/unnamed/02/events.aedat4");
  RunInfo info = read_run_info(run_folder("unnamed", "02"));
  info.complete = false;
  write_run_info(run_folder("unnamed", "02"), info);
  const CommandResult open = run("record --from file:data/unnamed/02 --speed 0 --quiet");
  EXPECT_EQ(open.exit_code, 0);
  EXPECT_NE(open.err.find("was not closed"), std::string::npos) << open.err;
  EXPECT_NE(open.err.find("run.json says that the run was not completed"), std::string::npos) << open.err;
  EXPECT_EQ(lines_in(open.err), 1) << open.err;
}

TEST_F(RecordCommand, NamesWhatWasProbablyMeant) {
  ASSERT_EQ(run("record --from file:recordings/dv-lz4.aedat4 --speed 0 --object fan").exit_code, 0);
  write_whole(folder / "plan.json", "{\"objects\": [\n  {\"name\": fan}]}");
  for (const auto& [arguments, meant] : std::vector<std::pair<std::string, std::string>>{
           {"--from 127.0.0.1:7777", "expected tcp://127.0.0.1:7777"},
           {"--from tcp:localhost:7777", "expected tcp://localhost:7777"},
           {"--from recordings/dv-lz4.aedat4", "expected file:recordings/dv-lz4.aedat4"},
           {"--from sim:fna", "the nearest is 'fan'"},
           {"--from file:data", "data: is a folder of a run; expected one run, such as data/fan/01"},
           {"--from sim --session plan.json", "plan.json: line 2 is no JSON at 'fan'; expected a value"}}) {
    const CommandResult result = run("record " + arguments);
    EXPECT_EQ(result.exit_code, 1) << arguments;
    EXPECT_EQ(lines_in(result.err), 1) << result.err;
    EXPECT_NE(result.err.find(meant), std::string::npos) << result.err;
  }
}

TEST_F(RecordCommand, NeverWritesOverARun) {
  ASSERT_EQ(run("record --from file:recordings/dv-lz4.aedat4 --speed 0 --run 07").exit_code, 0);
  const std::string before = read_text(run_folder("unnamed", "07").info());
  const CommandResult result = run("record --from file:recordings/dv-zstd.aedat4 --speed 0 --run 07");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("data/unnamed/07: the run exists already"), std::string::npos) << result.err;
  EXPECT_EQ(lines_in(result.err), 1);
  EXPECT_EQ(read_text(run_folder("unnamed", "07").info()), before);
  EXPECT_EQ(run("record --from file:recordings/dv-lz4.aedat4 --speed 0").exit_code, 0);
  EXPECT_TRUE(fs::exists(folder / "data/unnamed/08/events.aedat4"));
}

TEST_F(RecordCommand, ReportsInOneLineWhyItDoesNotBegin) {
  write_whole(folder / "no-plan.json", "{}");
  for (const char* arguments :
       {"--from tcp://127.0.0.1:1", "--from unix:nowhere", "--from file:nowhere.aedat4", "--from file:no-plan.json",
        "--from nonsense", "--from sim:no-such-object",
        "--from file:recordings/dv-lz4.aedat4 --from file:recordings/dv-lz4.aedat4", "--from sim --robot 127.0.0.1:1",
        "--from sim --robot 127.0.0.1:x", "--from sim --video nowhere.mp4", "--from sim --start-on output_bit_register_64",
        "--from sim --session no-plan.json", "--from sim --readout-mode variable-5000",
        "--from file:recordings/dv-lz4.aedat4 --out no-plan.json"}) {
    const CommandResult result = run(std::string("record ") + arguments);
    EXPECT_EQ(result.exit_code, 1) << arguments;
    EXPECT_EQ(lines_in(result.err), 1) << arguments << "\n" << result.err;
    EXPECT_FALSE(fs::exists(folder / "data") || fs::exists(folder / "data-sim")) << arguments;
  }
  for (const char* arguments : {"--object Fan", "--run 0", "--duration 0", "--duration nan", "--speed -1", "--compression best",
                                "--queue-mb 0", "--session no-plan.json --run 01"}) {
    EXPECT_GE(run(std::string("record --from sim ") + arguments).exit_code, 100) << arguments;
  }
}

TEST_F(RecordCommand, ListsWhatIsThere) {
  const CommandResult result = run("record --list --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_TRUE(json.at("sources").is_array());
  EXPECT_TRUE(json.at("videos").is_array());
  EXPECT_EQ(run("record --list").exit_code, 0);
}

TEST_F(RecordCommand, TakesTheSimulatorForAWholeRun) {
  const CommandResult result = run("record --json --from sim --speed 0 --object fan");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out).at("simulated"), true);
  EXPECT_EQ(nlohmann::json::parse(result.out).at("folder"), "data-sim/fan/01");
  EXPECT_FALSE(fs::exists(folder / "data"));
  EXPECT_EQ(read_run_info(run_folder_at(folder / "data-sim/fan/01")).extra.at("files").size(), 5U);
  EXPECT_EQ(run("info --check data-sim/fan/01").exit_code, 0);
  const CommandResult label = run("label --json data-sim/fan/01");
  EXPECT_EQ(label.exit_code, 0) << label.err;
  const CommandResult named = run("record --json --from sim:fan --speed 0 --duration 0.1 --object fan --out data");
  EXPECT_EQ(nlohmann::json::parse(named.out).at("folder"), "data/fan/01");
}

TEST_F(RecordCommand, EndsCleanlyOnCtrlCAndTermination) {
  const std::vector<events::Event> sent = make_long_recording();
  int number = 0;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const RunFolder run = run_folder("unnamed", "0" + std::to_string(++number));
    RunningCommand command("record --json --from file:long.aedat4", folder.path());
    ASSERT_TRUE(has_begun(run, command)) << command.err();
    ASSERT_TRUE(test::comes_true([&] { return fs::file_size(run.events()) > 20'000; }));
    command.signal(signal);
    const CommandResult result = command.wait();
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const nlohmann::json json = nlohmann::json::parse(result.out);
    EXPECT_EQ(json.at("ended"), "interrupted");
    EXPECT_EQ(json.at("complete"), true);
    const std::vector<events::Event> kept = events_in_file(run.events());
    EXPECT_EQ(json.at("events"), kept.size());
    EXPECT_TRUE(std::equal(kept.begin(), kept.end(), sent.begin()));
    EXPECT_EQ(test::run_tactile("info --check " + run.folder.string()).exit_code, 0);
  }
}

TEST_F(RecordCommand, LeavesAServerThatSendsNothingOnCtrlC) {
  std::atomic<bool> is_connected = false, is_over = false;
  ScriptedServer server([&](ScriptedServer::Socket&) {
    is_connected = true;
    EXPECT_TRUE(test::comes_true([&] { return is_over.load(); }));
  });
  const std::string address = server.address().text();
  for (const std::string& device : {"--from " + address, "--from sim --robot " + address.substr(std::string("tcp://").size())}) {
    RunningCommand command("record --json " + device, folder.path());
    if (device.starts_with("--from tcp")) {  // later connections wait in the server's queue
      EXPECT_TRUE(test::comes_true([&] { return is_connected || command.has_ended(); })) << command.err();
    } else {
      EXPECT_TRUE(test::comes_true([&] { return command.blocks_or_catches(SIGINT) || command.has_ended(); })) << command.err();
    }
    command.signal(SIGINT);
    const CommandResult result = command.wait();
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.out, "null\n");
    EXPECT_EQ(result.err, "");
  }
  is_over = true;
  EXPECT_FALSE(fs::exists(folder / "data") || fs::exists(folder / "data-sim"));
}

TEST_F(RecordCommand, RefusesAReadOutModeAheadOfALookForACamera) {
  const CommandResult result = run("record --readout-mode variable-5");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("'variable-5' is unknown; expected one of constant-100"), std::string::npos) << result.err;
}

TEST_F(RecordCommand, KeepsWhatCameFromAStreamThatBreaksOff) {
  const std::vector<events::Event> events = test::steady_events(1000, 1'000'000, 10, size);
  const std::string whole = test::packet(0, test::event_payload(events));
  const std::string bytes = test::event_stream_start() + whole + whole.substr(0, whole.size() / 2);
  ScriptedServer server([&](ScriptedServer::Socket& client) { test::send_all(client, bytes); });
  const CommandResult result = run("record --json --from " + server.address().text());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("source gone: " + server.address().text()), std::string::npos) << result.err;
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("complete"), true);
  EXPECT_EQ(run_json("unnamed", "01").at("ended"), json.at("ended"));
  EXPECT_EQ(events_in_file(run_folder("unnamed", "01").events()), events);
}

TEST_F(RecordCommand, ReportsThatAServerSendsGarbageOrNothing) {
  for (const bool silent : {false, true}) {
    ScriptedServer server([&](ScriptedServer::Socket& client) {
      if (!silent) test::send_all(client, std::string(100'000, 'x'));
      test::until_closed(client);
    });
    const CommandResult result = run("record --from " + server.address().text());
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_EQ(lines_in(result.err), 1) << result.err;
    EXPECT_NE(result.err.find(server.address().text()), std::string::npos) << result.err;
    EXPECT_FALSE(fs::exists(folder / "data"));
  }
}

TEST_F(RecordCommand, TakesSilenceForAStaticScene) {
  ScriptedServer server([&](ScriptedServer::Socket& client) {
    test::send_all(client, test::event_stream_start());
    test::until_closed(client);
  });
  const CommandResult result = run("record --json --duration 0.5 --from " + server.address().text());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out).at("ended"), "duration");
}

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

TEST_F(RecordCommand, EndsWithOneOnAFullDiskAndKeepsWhatFits) {
  const std::vector<events::Event> sent = make_long_recording();
  const CommandResult result = test::run_shell("ulimit -f 500 && '" + std::string(test::tactile_binary) +
                                                   "' record --json --compression none --from file:long.aedat4 --speed 0",
                                               folder.path());
  EXPECT_EQ(result.exit_code, 1) << result.err;
  EXPECT_NE(result.err.find("data/unnamed/01/events.aedat4: cannot be written"), std::string::npos) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out).at("complete"), false);
  EXPECT_EQ(run_json("unnamed", "01").at("complete"), false);
  const std::vector<events::Event> kept = events_in_file(run_folder("unnamed", "01").events());
  EXPECT_GT(kept.size(), 10'000U);
  EXPECT_LT(kept.size(), sent.size());
  EXPECT_TRUE(std::equal(kept.begin(), kept.end(), sent.begin()));
}

std::size_t count_of(const std::string& bytes, const std::string& word) {
  std::size_t count = 0;
  for (std::size_t at = bytes.find(word); at != std::string::npos; at = bytes.find(word, at + 1)) ++count;
  return count;
}

std::size_t pieces_of_film(const RunFolder& run) {
  return fs::exists(run.video()) ? count_of(test::bytes_of(run.video()), "moof") : 0;
}

// The moments are counted in events and pieces of film that are in the files: a slow machine is killed later, not elsewhere.
TEST_F(RecordCommand, LeavesAReadableRunWheneverItIsKilled) {
  const std::vector<events::Event> sent = make_long_recording();
  test::write_film(folder / "film.mp4", test::uneven_times(600, 33'333us));
  test::FakeController controller;
  std::mt19937 random(20);
  std::size_t with_events = 0, with_film = 0;
  for (int moment = 1; moment <= 20; ++moment) {
    const std::string number = (moment < 10 ? "0" : "") + std::to_string(moment);
    const RunFolder run = run_folder("fan", number);
    std::size_t seen = 0;
    {
      RunningCommand command(
          "record --object fan --from file:long.aedat4 --video film.mp4 --robot 127.0.0.1:" + std::to_string(controller.port()),
          folder.path());
      ASSERT_TRUE(has_begun(run, command)) << command.err();
      const std::size_t events = random() % 40'000;
      const std::size_t film_pieces = moment % 4 == 0 ? 2 : 0;
      ASSERT_TRUE(test::comes_true([&] {
        seen = events_in_file(run.events()).size();
        return (seen >= events && pieces_of_film(run) >= film_pieces) || command.has_ended();
      }));
      std::this_thread::sleep_for(std::chrono::milliseconds(random() % 50));
      ASSERT_FALSE(command.has_ended()) << command.err();
    }  // SIGKILL
    const std::vector<events::Event> kept = events_in_file(run.events());
    EXPECT_GE(kept.size(), seen);
    EXPECT_TRUE(std::equal(kept.begin(), kept.end(), sent.begin()));
    with_events += kept.empty() ? 0 : 1;

    if (fs::exists(run.info())) {
      EXPECT_FALSE(read_run_info(run).complete);
    }
    if (fs::exists(run.robot()) && fs::file_size(run.robot()) > 5000) {
      EXPECT_FALSE(robot::read_robot_log(run.robot()).longest().states.empty());
    }
    if (pieces_of_film(run) >= 2) {
      EXPECT_FALSE(test::decoded_times(run.video()).empty());
      ++with_film;
    }
    const CommandResult check = test::run_tactile("info --check " + run.folder.string());
    EXPECT_EQ(check.exit_code, 2);
    if (!kept.empty()) {
      EXPECT_NE(check.err.find("the run was not completed"), std::string::npos) << check.err;
      const fs::path whole = folder / ("whole-" + number + ".aedat4");
      EXPECT_EQ(test::run_tactile("repair " + run.events().string() + " " + whole.string()).exit_code, 0);
      EXPECT_EQ(test::run_tactile("info --check " + whole.string()).exit_code, 0);
      EXPECT_EQ(events_in_file(whole), kept);
    }
  }
  EXPECT_GE(with_events, 15U) << "too few kills came while events were written";
  EXPECT_GE(with_film, 5U) << "too few kills came while a film was written";
}

TEST_F(RecordCommand, HasChecksumsNextToARecordingUntilItHasItsHash) {
  ASSERT_EQ(run("record --from file:recordings/dv-lz4.aedat4 --speed 0 --object fan").exit_code, 0);
  const RunFolder whole = run_folder("fan", "01"), killed = run_folder("fan", "02");
  EXPECT_FALSE(fs::exists(events::checksums_beside(whole.events())));

  make_long_recording();
  {
    RunningCommand command("record --object fan --compression none --from file:long.aedat4", folder.path());
    ASSERT_TRUE(has_begun(killed, command)) << command.err();
    ASSERT_TRUE(test::comes_true([&] { return events_in_file(killed.events()).size() > 10'000; }));
  }  // SIGKILL
  ASSERT_TRUE(fs::exists(events::checksums_beside(killed.events())));
  const auto check = [&] { return nlohmann::json::parse(run("info --check --json data/fan/02").out).at("recordings").at(0); };
  const nlohmann::json sound = check();
  const std::size_t packets = sound.at("checksums").at("whole");
  EXPECT_EQ(sound.at("checksums").at("damaged"), 0);
  EXPECT_LE(sound.at("checksums").at("not_covered"), 1) << "the last one, if it was killed before it wrote the checksum";

  std::string bytes = read_text(killed.events());
  bytes.at(test::event_offset(test::packets_of(killed.events()).at(2), 7) + 13) ^= 1;  // a polarity, which nothing else shows
  test::write_bytes(killed.events(), bytes);
  const CommandResult sick = run("info --check data/fan/02");
  EXPECT_EQ(sick.exit_code, 2);
  EXPECT_NE(sick.err.find("1 packet has a wrong checksum: packet 2 of stream 0"), std::string::npos) << sick.err;
  EXPECT_EQ(check().at("checksums").at("first_damaged").at(0).at("packet"), 2);
  EXPECT_TRUE(nlohmann::json::parse(run("info --json data/fan/02").out).at("recordings").at(0).at("checksums").is_null());

  const CommandResult repair = run("repair data/fan/02 data/fan/03");
  EXPECT_EQ(repair.exit_code, 0) << repair.err;
  EXPECT_NE(repair.out.find("1 packet changed, according to the checksums"), std::string::npos) << repair.out;
  EXPECT_EQ(run("info --check data/fan/03").exit_code, 0);
  EXPECT_FALSE(fs::exists(events::checksums_beside(run_folder("fan", "03").events())));
  EXPECT_GE(test::packets_of(run_folder("fan", "03").events()).size(), packets - 1);

  // A kill after run.json was written leaves them next to a recording that has its hash: they are no longer used.
  fs::copy_file(events::checksums_beside(killed.events()), events::checksums_beside(whole.events()));
  const CommandResult left = run("info --check --json data/fan/01");
  EXPECT_EQ(left.exit_code, 0) << left.err;
  EXPECT_TRUE(nlohmann::json::parse(left.out).at("recordings").at(0).at("checksums").is_null());
  EXPECT_EQ(run("repair data/fan/01 data/fan/04").exit_code, 0);
}

}  // namespace
}  // namespace tactile::cli
