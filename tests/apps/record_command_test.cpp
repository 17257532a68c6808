#include "apps/record_command.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "events/made_recording.hpp"
#include "robot/fake_controller.hpp"
#include "support/comes_true.hpp"
#include "support/events_in_file.hpp"
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
using test::events_in_file;
using test::lines_in;
using test::RecordCommand;
using test::RunningCommand;
using test::ScriptedServer;

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

}  // namespace
}  // namespace tactile::cli
