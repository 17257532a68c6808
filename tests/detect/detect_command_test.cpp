#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "evaluation/trained_model.hpp"
#include "robot/fake_controller.hpp"
#include "support/comes_true.hpp"
#include "support/error_of.hpp"
#include "support/events_in_file.hpp"
#include "support/held_port.hpp"
#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/running_command.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/recording_writer.hpp"
#include "tactile/heatmaps/run_heatmaps.hpp"
#include "transport/dv/dv_stream_bytes.hpp"
#include "transport/scripted_server.hpp"

namespace tactile::detect {
namespace {

namespace fs = std::filesystem;
using test::comes_true;
using test::FakeController;
using test::run_tactile;
using test::RunningCommand;
using test::Trained;

using Row = std::map<std::string, std::string>;

std::vector<Row> rows_of(const fs::path& file) {
  std::istringstream text(read_text(file));
  std::vector<std::string> header;
  std::vector<Row> rows;
  for (std::string line; std::getline(text, line);) {
    std::istringstream cells(line);
    std::vector<std::string> values;
    for (std::string cell; std::getline(cells, cell, ',');) values.push_back(cell);
    if (header.empty()) {
      header = values;
      continue;
    }
    Row& row = rows.emplace_back();
    for (std::size_t i = 0; i < std::min(values.size(), header.size()); ++i) row[header[i]] = values[i];
  }
  return rows;
}

/// What has a model takes a while to make: all tests share one.
const Trained& trained() {
  static const Trained shared;
  return shared;
}

/// A datagram socket on loopback.
struct Listener {
  int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
  std::uint16_t port = 0;

  Listener() {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof address;
    ::bind(socket, reinterpret_cast<sockaddr*>(&address), length);
    ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &length);
    port = ntohs(address.sin_port);
    const int bytes = 8 << 20;
    ::setsockopt(socket, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
  }
  ~Listener() { ::close(socket); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
};

TEST(DetectCommand, AgreesWithEvalAtEveryTickOfARecording) {
  const fs::path folder = trained().folder.path();
  for (const std::string options : {"", " --confirm 3/4", " --gate", " --gate --gate-miss 0.5 --confirm 2/3", " --filter",
                                    " --gate --filter --alarm-cost 0.1"}) {
    const auto eval = run_tactile("eval --quiet --model small --run fan/02 --out offline" + options, folder);
    ASSERT_EQ(eval.exit_code, 0) << eval.err;
    const std::vector<Row> offline = rows_of(folder / "offline/fan-02.csv");
    ASSERT_GT(offline.size(), 100U);
    for (const std::string speed : {"0", "7"}) {
      const auto live = run_tactile(
          "detect --quiet --json --model small --from file:data/fan/02 --ticks live.csv --speed " + speed + options, folder);
      ASSERT_EQ(live.exit_code, 0) << live.err;
      const std::vector<Row> told = rows_of(folder / "live.csv");
      ASSERT_EQ(told.size(), offline.size()) << options;
      for (std::size_t i = 0; i < offline.size(); ++i) {
        for (const char* column : {"t_us", "verdict", "events"})
          ASSERT_EQ(told[i].at(column), offline[i].at(column)) << column << " of tick " << i << options;
        ASSERT_NEAR(std::stod(told[i].at("p_slip")), std::stod(offline[i].at("p_slip")), 1e-5);
      }
      const auto json = nlohmann::json::parse(live.out);
      EXPECT_EQ(json.at("ticks").at("told"), offline.size());
      EXPECT_EQ(json.at("ticks").at("skipped"), 0);
      EXPECT_TRUE(json.at("ticks").at("late").is_null()) << "what is played has no deadline";
      EXPECT_TRUE(json.at("ticks").at("missed_share").is_null());
      EXPECT_EQ(json.at("ended"), "source ended");
      EXPECT_EQ(json.at("gate").is_null(), options.find("gate") == std::string::npos);
      if (!json.at("gate").is_null()) {
        EXPECT_GT(json.at("gate").at("limit_ratio").get<double>(), 5);
        EXPECT_EQ(json.at("gate").at("limit_events"), 0);
        EXPECT_GT(json.at("gate").at("gated").get<int>(), 10);
      }
      EXPECT_GT(json.at("verdicts").at("slip").get<int>(), 0);
      EXPECT_EQ(json.at("latency_us").at("network").at("count"), offline.size());
    }
  }
}

/// Models of kinds that read no heatmaps.
class DetectOtherKinds : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Kinds, DetectOtherKinds, testing::Values("trees --rounds 20", "temporal --epochs 40"));

TEST_P(DetectOtherKinds, AgreesWithEvalAtEveryTick) {
  const Trained own;
  const fs::path folder = own.folder.path();
  const auto train = run_tactile("train --quiet --name other --kind " + GetParam(), folder);
  ASSERT_EQ(train.exit_code, 0) << train.err;
  for (const std::string options : {"", " --gate --filter --alarm-cost 0.1"}) {
    const auto eval = run_tactile("eval --quiet --model other --run fan/02 --out offline" + options, folder);
    ASSERT_EQ(eval.exit_code, 0) << eval.err;
    const std::vector<Row> offline = rows_of(folder / "offline/fan-02.csv");
    ASSERT_GT(offline.size(), 100U);
    const auto live =
        run_tactile("detect --quiet --json --model other --from file:data/fan/02 --ticks live.csv --speed 0" + options, folder);
    ASSERT_EQ(live.exit_code, 0) << live.err;
    const std::vector<Row> reported = rows_of(folder / "live.csv");
    ASSERT_EQ(reported.size(), offline.size()) << options;
    std::map<std::string, int> verdicts;
    for (std::size_t i = 0; i < offline.size(); ++i) {
      for (const char* column : {"t_us", "verdict", "events"})
        ASSERT_EQ(reported[i].at(column), offline[i].at(column)) << column << " of tick " << i << options;
      ASSERT_NEAR(std::stod(reported[i].at("p_slip")), std::stod(offline[i].at("p_slip")), 1e-6);
      ++verdicts[reported[i].at("verdict")];
    }
    EXPECT_EQ(verdicts.size(), 3U) << "each class occurs";
  }
  const auto finer = run_tactile("detect --quiet --json --model other --from file:data/fan/02 --speed 0 --tick-us 1000", folder);
  ASSERT_EQ(finer.exit_code, 0) << finer.err;
  EXPECT_GT(nlohmann::json::parse(finer.out).at("verdicts").at("slip").get<int>(), 100);
  const auto refused = run_tactile("detect --model other --from file:data/fan/02 --speed 0 --precision int8", folder);
  EXPECT_NE(refused.err.find("has no precision int8; expected fp32"), std::string::npos) << refused.err;
}

TEST(DetectCommand, AgreesWithEvalOnAStreamWithoutLateEvents) {
  const fs::path folder = trained().folder.path();
  ASSERT_EQ(run_tactile("eval --quiet --model small --run fan/02 --out offline", folder).exit_code, 0);
  std::map<std::string, Row> offline;
  for (const Row& row : rows_of(folder / "offline/fan-02.csv")) offline[row.at("t_us")] = row;
  RunningCommand server("serve data/fan/02 --port 0", folder);
  const std::string address = server.logged_after(" on ");
  const auto live =
      run_tactile("detect --json --model small --reconnect 0 --slack-us 500000 --ticks stream.csv --from " + address, folder);
  ASSERT_EQ(live.exit_code, 0) << live.err;
  const auto json = nlohmann::json::parse(live.out);
  EXPECT_EQ(json.at("ended"), "source ended");
  // On a machine that stood still the detector drops what waited and begins a new history: such ticks are not reported.
  const nlohmann::json& faults = json.at("faults").at("kinds");
  if (!faults.contains("behind") && !faults.contains("stopped")) {
    EXPECT_EQ(json.at("events").at("dropped"), 0);
  }
  const std::vector<Row> told = rows_of(folder / "stream.csv");
  ASSERT_GT(told.size(), 10U);
  std::int64_t last = 0;
  for (const Row& row : told) {
    const std::int64_t t = std::stoll(row.at("t_us"));
    EXPECT_EQ(t % 2'000, 0);
    EXPECT_GT(t, last);
    last = t;
    const auto same = offline.find(row.at("t_us"));
    if (same == offline.end() || json.at("events").at("late") != 0 || row.at("incomplete") != "0") continue;
    EXPECT_EQ(row.at("events"), same->second.at("events")) << row.at("t_us");
    EXPECT_EQ(row.at("verdict"), same->second.at("verdict")) << row.at("t_us");
  }
}

TEST(DetectCommand, SetsTheRobotsBitsAndClearsThemInTheEnd) {
  const FakeController controller;
  const auto result = run_tactile(
      "detect --json --quiet --model small --from file:data/fan/02 --speed 1 --bit 64 --press-bit 65 --slip-bit 66 --robot "
      "127.0.0.1:" +
          std::to_string(controller.port()),
      trained().folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_GE(json.at("robot").at("raised").get<int>(), 2);
  EXPECT_GE(json.at("robot").at("event_to_write_us").at("count").get<int>(), 1);
  EXPECT_EQ(json.at("robot").at("controller"), "5.11.6.1071234");
  EXPECT_TRUE(comes_true([&] { return controller.writes() >= 4; }));
  for (const char* bit : {"64", "65", "66"})
    EXPECT_TRUE(comes_true([&] { return controller.input(std::string("input_bit_register_") + bit) == false; })) << bit;
}

TEST(DetectCommand, WritesBitsThatFollowTheFilter) {
  const fs::path folder = trained().folder.path();
  const FakeController controller;
  const auto result = run_tactile(
      "detect --json --quiet --model small --filter --from file:data/fan/02 --speed 1 --ticks filtered.csv --press-bit 65 "
      "--slip-bit 66 --robot 127.0.0.1:" +
          std::to_string(controller.port()),
      folder);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::vector<Row> ticks = rows_of(folder / "filtered.csv");
  const auto rises = [&](const char* column) {
    int count = 0;
    for (std::size_t i = 0; i < ticks.size(); ++i) {
      const std::string& now = ticks[i].at(column);
      count += now != "none" && (i == 0 || ticks[i - 1].at(column) != now);
    }
    return count;
  };
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_GE(rises("verdict"), 2);
  EXPECT_EQ(json.at("robot").at("raised"), rises("verdict"));
  const bool differs =
      std::any_of(ticks.begin(), ticks.end(), [](const Row& row) { return row.at("verdict") != row.at("said"); });
  EXPECT_TRUE(differs) << "the filter changes no tick";
}

/// Noise of 3 s with 20 times the rate of the training runs. @return  its folder
fs::path write_loud_run(const fs::path& folder) {
  if (fs::exists(folder)) return folder;
  fs::create_directories(folder);
  std::vector<events::Event> events;
  for (std::int64_t us = 0; us < 3'000'000; us += 25) {
    events.push_back({camera_time(us), static_cast<std::int16_t>(us / 25 * 37 % test::small_sensor.width),
                      static_cast<std::int16_t>(us / 25 * 53 % test::small_sensor.height), 1});
  }
  events::RecordingWriter writer(folder / "events.aedat4", {events::event_stream_declaration(test::small_sensor, "test")});
  writer.write_events(0, events);
  writer.close();
  return folder;
}

TEST(DetectCommand, PrintsOneLineWhenTheSceneLeavesTheTrainingRuns) {
  const fs::path folder = trained().folder.path();
  write_loud_run(folder / "loud");
  const auto loud = run_tactile("detect --json --model small --speed 0 --from file:loud", folder);
  ASSERT_EQ(loud.exit_code, 0) << loud.err;
  const std::string line = "scene: background 42 kev/s, training 2.4 to 2.4; ";
  const std::size_t at = loud.err.find(line);
  ASSERT_NE(at, std::string::npos) << loud.err;
  EXPECT_EQ(loud.err.find("scene:", at + 1), std::string::npos) << "once";
  const auto json = nlohmann::json::parse(loud.out);
  EXPECT_EQ(json.at("faults").at("kinds").at("scene"), 1);
  EXPECT_EQ(json.at("scene").at("left"), 1);
  EXPECT_EQ(json.at("scene").at("returned"), 0);
  EXPECT_TRUE(json.at("scene").at("is_outside").get<bool>());
  EXPECT_NEAR(json.at("scene").at("last").at("background_hz").get<double>(), 42'000, 1'000)
      << "6 % more than 40 kev/s, since it is regular";
  EXPECT_EQ(json.at("scene").at("training"), read_json(folder / "models/small/model.json").at("scene"));
  const auto text = run_tactile("detect --quiet --model small --speed 0 --from file:loud", folder);
  EXPECT_NE(text.out.find("left the training runs 1 time"), std::string::npos) << text.out;

  const auto usual = run_tactile("detect --json --model small --speed 0 --from file:data/fan/02", folder);
  ASSERT_EQ(usual.exit_code, 0) << usual.err;
  EXPECT_EQ(usual.err.find("scene:"), std::string::npos) << usual.err;
  EXPECT_EQ(nlohmann::json::parse(usual.out).at("scene").at("left"), 0);
}

TEST(DetectCommand, DoesNotWatchTheSceneWithAnOlderModel) {
  const fs::path folder = trained().folder.path();
  fs::copy(folder / "models/small", folder / "models/older", fs::copy_options::recursive);
  nlohmann::json description = read_json(folder / "models/older/model.json");
  description.erase("scene");
  write_json(folder / "models/older/model.json", description);
  write_loud_run(folder / "loud");
  const auto older = run_tactile("detect --json --model older --speed 0 --from file:loud", folder);
  ASSERT_EQ(older.exit_code, 0) << older.err;
  EXPECT_NE(older.err.find("older does not know the scenes of its training runs"), std::string::npos) << older.err;
  EXPECT_TRUE(nlohmann::json::parse(older.out).at("scene").is_null());
  fs::remove_all(folder / "models/older");
}

TEST(DetectCommand, SendsARecordEachTick) {
  const Listener listener;
  const auto result =
      run_tactile("detect --json --quiet --model small --from file:data/fan/02 --speed 0 --ticks udp.csv --udp 127.0.0.1:" +
                      std::to_string(listener.port),
                  trained().folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::vector<Row> told = rows_of(trained().folder.path() / "udp.csv");
  std::size_t got = 0;
  for (std::array<char, 100> bytes{}; ::recv(listener.socket, bytes.data(), bytes.size(), MSG_DONTWAIT) == 64; ++got) {
    std::uint64_t number = 0;
    std::int64_t t = 0;
    std::memcpy(&number, bytes.data() + 8, sizeof number);
    std::memcpy(&t, bytes.data() + 16, sizeof t);
    ASSERT_LT(number, told.size());
    EXPECT_EQ(std::to_string(t), told[number].at("t_us"));
    EXPECT_EQ(told[number].at("verdict"), bytes[60] == 0 ? "none" : bytes[60] == 1 ? "press" : "slip");
  }
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("udp").at("sent").get<std::size_t>() + json.at("udp").at("failed").get<std::size_t>(), told.size());
  EXPECT_GT(got, 0U);
}

/// The bridge beside a detector, until it has printed a slip; at the latest after two minutes it is ended.
const std::string bridge_script =
    "comes() { for i in $(seq 1200); do grep -q \"$1\" \"$2\" && return; sleep 0.1; done; }\n"
    "PYTHONUNBUFFERED=1 '" +
    std::string(test::data_folder) +
    "/../../scripts/ros-bridge' --print --port 0 >bridge.out 2>bridge.err &\n"
    "trap 'kill $!; wait $!; cat bridge.out' EXIT\n"
    "comes listening bridge.err\n"
    "'" +
    test::tactile_binary +
    "' detect --quiet --model small --from file:data/fan/02 --udp 127.0.0.1:$(sed 's/.*://' bridge.err) >/dev/null || exit 1\n"
    "comes slip bridge.out\n";

TEST(RosBridge, PrintsTheVerdictsOfReceivedRecords) {
  write_whole(trained().folder / "bridge.sh", bridge_script);
  const auto result = test::run_shell("sh bridge.sh", trained().folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(result.out.starts_with("none\n")) << result.out;
  EXPECT_NE(result.out.find("\nslip\n"), std::string::npos) << result.out;
}

TEST(DetectCommand, RecordsTheRun) {
  const fs::path folder = trained().folder.path();
  const auto result =
      run_tactile("detect --json --model small --from file:data/fan/02 --speed 0 --record --out recorded --object fan", folder);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("recorded").at("complete"), true);
  EXPECT_EQ(test::events_in_file(folder / "recorded/fan/01/events.aedat4"),
            test::events_in_file(folder / "data/fan/02/events.aedat4"));
  EXPECT_EQ(run_tactile("info --check recorded/fan/01", folder).exit_code, 0);
}

TEST(DetectCommand, DrawsVerdictsWithLabelsAndTruth) {
  const fs::path folder = trained().folder.path();
  const auto result = run_tactile("detect --model small --from file:data/fan/02 --speed 0 --plot told.svg", folder);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("Drawn in told.svg"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("no deadline"), std::string::npos) << result.out;
  EXPECT_EQ(result.out.find("a tick late"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("slip  at "), std::string::npos) << result.out;
  const std::string svg = read_text(folder / "told.svg");
  EXPECT_NE(svg.find("labelled"), std::string::npos);
  EXPECT_NE(svg.find("first right verdict"), std::string::npos);
}

TEST(DetectCommand, EndsAtCtrlCAndAfterItsDuration) {
  const fs::path folder = trained().folder.path();
  RunningCommand server("serve data/fan/02 --port 0 --loop", folder);
  const std::string address = server.logged_after(" on ");
  const auto timed = run_tactile("detect --json --model small --duration 0.5 --from " + address, folder);
  EXPECT_EQ(timed.exit_code, 0) << timed.err;
  EXPECT_EQ(nlohmann::json::parse(timed.out).at("ended"), "duration");
  RunningCommand detect("detect --json --model small --ticks c.csv --from " + address, folder);
  EXPECT_TRUE(comes_true([&] { return fs::exists(folder / "c.csv") && fs::file_size(folder / "c.csv") > 1000; })) << detect.err();
  detect.signal(SIGINT);
  const auto result = detect.wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("ended"), "interrupted");
  EXPECT_GT(json.at("ticks").at("told").get<int>(), 0);
}

/// A stream of the model's sensor: half a second of events a millisecond apart, then `end`.
std::string stream_then(const std::string& end, std::int64_t from_us = 5'000'000) {
  std::string bytes = test::stream_start(0, test::event_node(0, 160, 120, "DVXplorer_DXM00001"));
  for (std::int64_t t = 0; t < 500'000; t += 1'000) {
    events::Event event;
    event.t = camera_time(from_us + t);
    event.x = static_cast<std::int16_t>(t / 1'000 % 160);
    bytes += test::packet(0, test::event_payload({event}));
  }
  return bytes + end;
}

TEST(DetectCommand, ReportsGarbageAndTheTicksBeforeIt) {
  std::string impossible = test::packet(0, test::event_payload({}));
  test::put(impossible, 4, 0xFFFF'FFFFU);
  const test::ScriptedServer server([&](test::ScriptedServer::Socket& client) {
    test::send_all(client, stream_then(impossible));
    test::until_closed(client);
  });
  const auto result =
      run_tactile("detect --json --model small --reconnect 0 --from " + server.address().text(), trained().folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("4294967295"), std::string::npos) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_GT(json.at("ticks").at("told").get<int>(), 0);
  EXPECT_EQ(json.at("faults").at("kinds").at("broken"), 1);
}

/// What `end` does to the connection after the stream.
nlohmann::json detected_from(const std::function<void(test::ScriptedServer::Socket&)>& end, const std::string& options,
                             int exit_code) {
  // A reset takes with it what was not read yet. Where that was the header, no stream was opened, and another is tried.
  for (int attempt = 0; attempt < 50; ++attempt) {
    const test::ScriptedServer server([&](test::ScriptedServer::Socket& client) {
      test::send_all(client, stream_then(""));
      end(client);
    });
    const auto result =
        run_tactile("detect --json --model small " + options + " --from " + server.address().text(), trained().folder.path());
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    if (!result.out.empty()) return nlohmann::json::parse(result.out);
  }
  ADD_FAILURE() << "no stream was ever opened";
  return {};
}

TEST(DetectCommand, EndsWithAStreamThatCloses) {
  // A day: what tries to open it again is never done.
  const auto json = detected_from([](auto&) {}, "--reconnect 86400", 0);
  EXPECT_EQ(json.at("ended"), "source ended");
  EXPECT_TRUE(json.at("faults").at("kinds").empty()) << json.at("faults");
  EXPECT_GT(json.at("ticks").at("told").get<int>(), 0);
}

TEST(DetectCommand, ReportsThatItGaveUpABrokenStream) {
  const auto within_a_packet = [](test::ScriptedServer::Socket& client) {
    test::send_all(client, test::packet(0, test::event_payload({events::Event{}})).substr(0, 20));
  };
  for (const auto& breaks : {std::function<void(test::ScriptedServer::Socket&)>(test::reset), {within_a_packet}}) {
    const auto json = detected_from(breaks, "--reconnect 0.2", 1);
    EXPECT_EQ(json.at("faults").at("kinds").at("broken"), 1) << json.at("faults");
    EXPECT_EQ(json.at("faults").at("kinds").at("gave up"), 1) << json.at("faults");
    EXPECT_NE(json.at("ended").get<std::string>().find("; gave up after "), std::string::npos) << json.at("ended");
  }
}

/// A line for each press and slip goes to standard output as they begin: where that is full the source is not waited for.
TEST(DetectCommand, EndsSoonIfStandardOutputIsFull) {
  const fs::path folder = trained().folder.path();
  RunningCommand server("serve data/fan/02 --port 0 --loop", folder);
  const std::string address = server.logged_after(" on ");
  const auto result = run_tactile("detect --model small --from " + address + " >/dev/full", folder);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("standard output: cannot be written (No space left on device); expected a place with room\n"),
            std::string::npos)
      << result.err;
}

TEST(DetectCommand, TriesAStreamAgainThatBreaks) {
  const fs::path folder = trained().folder.path();
  std::uint16_t port = 0;
  std::unique_ptr<test::ScriptedServer> broken;
  std::atomic<bool> breaks{false};
  broken = std::make_unique<test::ScriptedServer>([&](test::ScriptedServer::Socket& client) {
    test::send_all(client, stream_then(""));
    test::comes_true([&] { return breaks.load(); });
    test::reset(client);
  });
  port = broken->address().port;
  RunningCommand detect("detect --json --model small --reconnect 100 --from " + broken->address().text(), folder);
  EXPECT_TRUE(comes_true([&] {
    return detect.err().find("silence") != std::string::npos || detect.err().find("no event") != std::string::npos;
  })) << detect.err();
  breaks = true;
  EXPECT_TRUE(comes_true([&] { return detect.err().find("trying to open it again") != std::string::npos; })) << detect.err();
  broken = nullptr;
  const test::ScriptedServer again([&](test::ScriptedServer::Socket& client) { test::send_all(client, stream_then("")); },
                                   asio::ip::tcp::endpoint(asio::ip::address_v4::loopback(), port));
  const auto result = detect.wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("is back after"), std::string::npos) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out).at("reopened"), 1);
}

/// The run's events, and one so long behind the last.
fs::path with_an_event_ahead(const fs::path& name, microseconds ahead) {
  const fs::path folder = trained().folder.path();
  const events::RecordingReader recording(folder / "data/fan/02/events.aedat4");
  const events::Stream& stream = events::event_stream(recording);
  std::vector<events::Event> events = test::events_in_file(recording.file());
  events::RecordingWriter writer(folder / name, std::vector<events::Stream>{stream});
  writer.write_events(stream.id, std::span<const events::Event>(events));
  events::Event far = events.back();
  far.t = after(far.t, ahead);
  writer.write_events(stream.id, std::span<const events::Event>(&far, 1));
  writer.close();
  return folder / name;
}

TEST(DetectCommand, RejectsARecordingWithATimeAYearAheadLikeEval) {
  const fs::path folder = trained().folder.path();
  const fs::path file = with_an_event_ahead("year.aedat4", 365 * 24h);
  events::RecordingReader recording(file);
  const std::string of_eval = test::error_of([&] {
    heatmaps::for_every_tick(recording, events::event_stream(recording).id, {}, [](auto&&...) { FAIL() << "a tick"; });
  });
  const auto whole = run_tactile("detect --quiet --model small --speed 0 --ticks year.csv --from file:" + file.string(), folder);
  EXPECT_EQ(whole.exit_code, 1);
  EXPECT_NE(whole.err.find(of_eval), std::string::npos) << whole.err;
  EXPECT_FALSE(fs::exists(folder / "year.csv"));
  const auto piece =
      run_tactile("detect --quiet --json --model small --speed 0 --duration 0.4 --from file:" + file.string(), folder);
  EXPECT_EQ(piece.exit_code, 0) << piece.err;
  EXPECT_EQ(nlohmann::json::parse(piece.out).at("ticks").at("told"), 200);
}

TEST(DetectCommand, AgreesWithEvalThroughASilence) {
  const fs::path folder = trained().folder.path();
  const fs::path file = with_an_event_ahead("minute.aedat4", 60s);
  std::vector<std::pair<std::string, std::string>> offline;
  events::RecordingReader recording(file);
  heatmaps::for_every_tick(recording, events::event_stream(recording).id, {}, [&](CameraTime t, auto, std::uint64_t events) {
    offline.emplace_back(std::to_string(us_of(t)), std::to_string(events));
  });
  ASSERT_GT(offline.size(), 30'000U);
  const auto result =
      run_tactile("detect --quiet --model small --speed 0 --ticks minute.csv --from file:" + file.string(), folder);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::vector<Row> told = rows_of(folder / "minute.csv");
  ASSERT_EQ(told.size(), offline.size());
  for (std::size_t i = 0; i < told.size(); ++i) {
    ASSERT_EQ(told[i].at("t_us"), offline[i].first);
    ASSERT_EQ(told[i].at("events"), offline[i].second);
  }
}

TEST(DetectCommand, ReportsAClockOf31BitsThatStartedAgain) {
  // The camera's clock of 31 bits begins again within the stream; there is one connection, so it is named and that is the end.
  constexpr std::int64_t end = std::int64_t{1} << 31;
  events::Event event;
  event.t = camera_time(100);
  const test::ScriptedServer server([&](test::ScriptedServer::Socket& client) {
    test::send_all(client, stream_then(test::packet(0, test::event_payload({event})), end - 500'000));
    test::until_closed(client);
  });
  const auto result =
      run_tactile("detect --json --model small --reconnect 0.2 --from " + server.address().text(), trained().folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("its time went back by 2147.48"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("trying to open it again"), std::string::npos) << result.err;
  EXPECT_GT(nlohmann::json::parse(result.out).at("ticks").at("told").get<int>(), 0);
}

TEST(DetectCommand, DoesNotCountMaskedPixels) {
  const fs::path folder = trained().folder.path();
  const test::TemporaryFolder own;
  const events::RecordingReader recording(folder / "data/fan/02/events.aedat4");
  const events::SensorSize sensor = *events::event_stream(recording).size;
  std::string mask = "x,y\n";  // the left half
  for (int y = 0; y < sensor.height; ++y) {
    for (int x = 0; x < sensor.width / 2; ++x) mask += std::to_string(x) + "," + std::to_string(y) + "\n";
  }
  write_whole(own / "mask.csv", mask);
  const auto events_with = [&](const std::string& options) {
    const auto result = run_tactile("detect --quiet --json --model small --from file:data/fan/02 --speed 0 --ticks '" +
                                        (own / "ticks.csv").string() + "'" + options,
                                    folder);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(nlohmann::json::parse(result.out).at("rendering").contains("mask"), !options.empty());
    std::uint64_t events = 0;
    for (const Row& row : rows_of(own / "ticks.csv")) events += std::stoull(row.at("events"));
    return events;
  };
  const std::uint64_t all = events_with(""), masked = events_with(" --mask '" + (own / "mask.csv").string() + "'");
  EXPECT_GT(masked, 0U);
  EXPECT_LT(masked, all);
}

TEST(DetectCommand, ReportsWhatIsWrong) {
  const fs::path folder = trained().folder.path();
  const auto expect_error = [&](const std::string& options, const std::string& words) {
    const auto result = run_tactile("detect --model small " + options, folder);
    EXPECT_NE(result.exit_code, 0) << options;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
  };
  expect_error("--from file:data/fan/02 --bit 64", "--bit: --robot is missing");
  expect_error("--from file:data/fan/02 --slip-bit 64", "--slip-bit: --robot is missing");
  expect_error("--from file:data/fan/02 --latch", "--latch: --robot is missing; expected --robot HOST");
  expect_error("--from file:data/fan/02 --clear-ms 5", "--clear-ms: --robot is missing");
  expect_error("--from file:data/fan/02 --latch --clear-ms 5 --robot 127.0.0.1", "expected one of the two");
  expect_error("--from file:data/fan/02 --tick-us 3000", "expected a tick such as 2500 or 4000");
  expect_error("--from file:data/fan/02 --tick-us 41000", "expected 40000 at most");
  expect_error("--from sim:cup", "'cup' is no object that can be simulated; expected one of 3d-printed-object");
  expect_error("--from file:data/fan/02 --object fan", "--object: --record is missing; expected --record, too");
  expect_error("--from file:data/fan/02 --robot 127.0.0.1", "no bit is given");
  expect_error("--from file:data/fan/02 --robot 127.0.0.1 --bit 63", "64 to 127");
  expect_error("--from file:data/fan/02 --robot 127.0.0.1 --bit 70 --slip-bit 70", "is given twice");
  expect_error("--from file:data/fan/02 --udp nowhere", "expected HOST:PORT");
  expect_error("--from file:data/fan/02 --confirm 1/2", "more than half");
  expect_error("--from file:nothing", "nothing");
  expect_error("--from sim:fan", "expected the heatmaps of 32 x 24 cells that models/small was trained on");
  expect_error("--from file:data/fan/02 --speed 0 --ticks no/such/place.csv", "cannot be written");

  fs::copy(trained().bundle.folder, folder / "models/old", fs::copy_options::recursive);
  nlohmann::json model = read_json(folder / "models/old/model.json");
  EXPECT_GT(model.at("gate").at("limit_events").get<int>(), 0);
  EXPECT_FALSE(model.at("gate").at("ratios").empty());
  model.at("gate").erase("ratios");
  model.at("gate").erase("intervals");
  write_json(folder / "models/old/model.json", model);
  const auto by_events = run_tactile("detect --quiet --json --model old --gate --from file:data/fan/02 --speed 0", folder);
  ASSERT_EQ(by_events.exit_code, 0) << by_events.err;
  const auto gate = nlohmann::json::parse(by_events.out).at("gate");
  EXPECT_EQ(gate.at("limit_events"), model.at("gate").at("limit_events"));
  EXPECT_TRUE(gate.at("limit_ratio").is_null());
  const auto by_misses = run_tactile("detect --model old --gate --gate-miss 0.01 --from file:data/fan/02 --speed 0", folder);
  EXPECT_EQ(by_misses.exit_code, 1);
  EXPECT_NE(by_misses.err.find("has no ratios"), std::string::npos) << by_misses.err;
  model.erase("gate");
  write_json(folder / "models/old/model.json", model);
  const auto old = run_tactile("detect --model old --gate --from file:data/fan/02 --speed 0", folder);
  EXPECT_EQ(old.exit_code, 1);
  EXPECT_NE(old.err.find("run 'tactile train --force' again"), std::string::npos) << old.err;
  EXPECT_EQ(run_tactile("detect --model old --from file:data/fan/02 --speed 0", folder).exit_code, 0);
  const auto evaluated = run_tactile("eval --model old --gate", folder);
  EXPECT_NE(evaluated.err.find("run 'tactile train --force' again"), std::string::npos) << evaluated.err;
  fs::remove_all(folder / "models/old");
}

}  // namespace
}  // namespace tactile::detect
