#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "detect/detect_command.hpp"
#include "evaluation/trained_model.hpp"
#include "robot/fake_controller.hpp"
#include "support/comes_true.hpp"
#include "support/error_of.hpp"
#include "support/events_in_file.hpp"
#include "support/held_port.hpp"
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
using test::run_tactile;
using test::RunningCommand;
using test::trained;

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
  EXPECT_GT(json.at("ticks").at("reported").get<int>(), 0);
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
  for (const auto& [kind, count] : json.at("faults").at("kinds").items())
    EXPECT_TRUE(kind == "stopped" || kind == "behind") << kind << "; expected only faults of a busy machine";
  EXPECT_GT(json.at("ticks").at("reported").get<int>(), 0);
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
  EXPECT_GT(nlohmann::json::parse(result.out).at("ticks").at("reported").get<int>(), 0);
}

}  // namespace
}  // namespace tactile::detect
