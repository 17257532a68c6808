#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "events/made_recording.hpp"
#include "support/comes_true.hpp"
#include "support/events_in_file.hpp"
#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/running_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/transport/dv/dv_stream_client.hpp"

namespace tactile::test {
namespace {

using namespace std::chrono_literals;
using Received = transport::DvStreamClient::Received;

const std::string recording = std::string(test::data_folder) + "/aedat4/dv-lz4.aedat4";

/// As a shell takes them.
std::string words(std::initializer_list<std::string> arguments) {
  std::string text;
  for (const std::string& argument : arguments) text += "'" + argument + "' ";
  return text;
}

transport::NetworkAddress events_address(const RunningCommand& serving) {
  const std::string line = serving.logged_after("serving events of ");
  return transport::network_address(line.substr(line.rfind(" on ") + 4));
}

/// What comes until the server ends the stream.
struct Heard {
  std::vector<events::Event> events;
  std::vector<std::vector<events::Event>> packets;
  std::size_t imu = 0, triggers = 0;
};

Heard hear(transport::DvStreamClient& client) {
  Heard heard;
  for (;;) {
    const Received received = client.receive(long_enough);
    if (received != Received::packet) {
      EXPECT_EQ(received, Received::closed);
      return heard;
    }
    heard.events.insert(heard.events.end(), client.events().begin(), client.events().end());
    if (!client.events().empty()) heard.packets.emplace_back(client.events().begin(), client.events().end());
    heard.imu += client.imu().size();
    heard.triggers += client.triggers().size();
  }
}

std::optional<std::string> attribute(const events::Stream& stream, const std::string& key) {
  const auto found = std::find_if(stream.info.begin(), stream.info.end(), [&](const auto& pair) { return pair.first == key; });
  return found == stream.info.end() ? std::nullopt : std::optional(found->second);
}

TEST(ServeCommand, WaitsForAClientAndPlaysItTheWhole) {
  RunningCommand serving(words({"serve", recording, "--port", "0", "--speed", "0", "--json"}));
  const transport::NetworkAddress address = events_address(serving);
  EXPECT_EQ(address.host, "127.0.0.1");
  transport::DvStreamClient client(address, long_enough);
  EXPECT_EQ(client.stream().source, "DVXplorer_DXM00042");
  EXPECT_EQ(client.stream().size, (events::SensorSize{160, 120}));
  EXPECT_FALSE(attribute(client.stream(), "simulated"));
  const Heard heard = hear(client);
  EXPECT_EQ(heard.events, events_in_file(recording));
  const CommandResult result = serving.wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["events"], heard.events.size());
  EXPECT_EQ(json["packets"], heard.packets.size());
  EXPECT_EQ(json["clients"], 1);
  EXPECT_EQ(json["dropped_clients"], 0);
  EXPECT_EQ(json["interrupted"], false);
  EXPECT_EQ(json["streams"][0]["address"], address.text());
  EXPECT_NE(result.err.find(" joined"), std::string::npos) << result.err;
}

TEST(ServeCommand, CutsPacketsByTheirSpan) {
  for (const std::int64_t span : {200, 1000, 5000}) {
    RunningCommand serving(words({"serve", recording, "--port", "0", "--speed", "0", "--packet-us", std::to_string(span)}));
    transport::DvStreamClient client(events_address(serving), long_enough);
    const Heard heard = hear(client);
    for (const auto& packet : heard.packets) EXPECT_LT(us_of(packet.back().t) - us_of(packet.front().t), span);
    EXPECT_EQ(heard.events, events_in_file(recording));
    EXPECT_EQ(serving.wait().exit_code, 0);
  }
}

TEST(ServeCommand, ServesEveryCompression) {
  for (const std::string compression : {"none", "lz4", "lz4-high", "zstd", "zstd-high"}) {
    RunningCommand serving(words({"serve", recording, "--port", "0", "--speed", "0", "--compression", compression}));
    transport::DvStreamClient client(events_address(serving), long_enough);
    EXPECT_EQ(name_of(client.compression()), compression);
    EXPECT_EQ(hear(client).events, events_in_file(recording));
    EXPECT_EQ(serving.wait().exit_code, 0);
  }
}

TEST(ServeCommand, ServesImuAndTriggersOfTheCameraOnPortsOfTheirOwn) {
  RunningCommand serving(words({"serve", recording, "--port", "0", "--imu-port", "0", "--triggers-port", "0", "--speed", "0"}));
  const auto address_of = [&](const std::string& type) {
    const std::string line = serving.logged_after("serving " + type + " of ");
    return transport::network_address(line.substr(line.rfind(" on ") + 4));
  };
  transport::DvStreamClient events(address_of("events"), long_enough), imu(address_of("imu"), long_enough),
      triggers(address_of("triggers"), long_enough);
  EXPECT_EQ(imu.stream().type, events::StreamType::imu);
  EXPECT_EQ(triggers.stream().type, events::StreamType::triggers);
  EXPECT_EQ(hear(events).events.size(), 6000U);
  EXPECT_EQ(hear(imu).imu, 50U);
  EXPECT_EQ(hear(triggers).triggers, 6U);
  EXPECT_EQ(serving.wait().exit_code, 0);
}

TEST(ServeCommand, EndsWith0OnTerminationAndOnCtrlC) {
  for (const int signal : {SIGTERM, SIGINT}) {
    RunningCommand serving(words({"serve", "sim:fan", "--port", "0", "--json"}));
    transport::DvStreamClient client(events_address(serving), long_enough);
    EXPECT_EQ(attribute(client.stream(), "simulated"), "true");
    EXPECT_EQ(attribute(client.stream(), "readoutMode"), "variable");
    ASSERT_EQ(client.receive(long_enough), Received::packet);
    serving.signal(signal);
    hear(client);
    const CommandResult result = serving.wait();
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const auto json = nlohmann::json::parse(result.out);
    EXPECT_EQ(json["interrupted"], true);
    EXPECT_EQ(json["simulated"], true);
    EXPECT_GT(json["events"], 0);
  }
}

TEST(ServeCommand, EndsWith0WhileItWaitsForAClient) {
  RunningCommand serving(words({"serve", recording, "--port", "0", "--json"}));
  events_address(serving);
  serving.signal(SIGTERM);
  const CommandResult result = serving.wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out)["events"], 0);
}

TEST(ServeCommand, TakesNoLessTimeThanTheRecordingOverTheSpeed) {
  const TemporaryFolder folder;
  write_plain_recording(folder / "slow.aedat4", steady_events(500, 1'000'000, 1000, {640, 480}), {640, 480});  // 499 ms
  for (const double speed : {1.0, 2.0}) {
    const CommandResult result =
        run_tactile("serve slow.aedat4 --port 0 --no-wait --json --speed " + std::to_string(speed), folder.path());
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_GE(nlohmann::json::parse(result.out)["duration_s"].get<double>(), 0.499 / speed);
  }
}

TEST(ServeCommand, RepeatsWithTimesThatContinue) {
  RunningCommand serving(words({"serve", recording, "--port", "0", "--speed", "0", "--loop"}));
  transport::DvStreamClient client(events_address(serving), long_enough);
  const std::vector<events::Event> once = events_in_file(recording);
  std::vector<events::Event> heard;
  while (heard.size() < 4 * once.size()) {
    ASSERT_EQ(client.receive(long_enough), Received::packet);
    heard.insert(heard.end(), client.events().begin(), client.events().end());
  }
  EXPECT_TRUE(
      std::is_sorted(heard.begin(), heard.end(), [](const events::Event& a, const events::Event& b) { return a.t < b.t; }));
  EXPECT_TRUE(std::equal(once.begin(), once.end(), heard.begin()));
  const std::int64_t shift = us_of(heard[once.size()].t) - us_of(once.front().t);
  EXPECT_GT(shift, us_of(once.back().t) - us_of(once.front().t));
  for (std::size_t i = 0; i < once.size(); ++i) {
    events::Event later = once[i];
    later.t += microseconds{shift};
    ASSERT_EQ(heard[once.size() + i], later);
  }
  serving.signal(SIGTERM);
  EXPECT_EQ(serving.wait().exit_code, 0);
}

TEST(ServeCommand, DropsNoClientThatIsSlowerThanTheDisk) {
  const TemporaryFolder folder;
  const std::vector<events::Event> part = steady_events(100'000, 0, 1, {640, 480});
  constexpr std::size_t parts = 60;  // 96 MB, half as much again as a client's queue
  {
    events::RecordingWriter writer(folder / "large.aedat4", {events::event_stream_declaration({640, 480}, "DVXplorer_DXM00001")});
    std::vector<events::Event> events = part;
    for (std::size_t i = 0; i < parts; ++i) {
      writer.write_events(0, events);
      for (events::Event& event : events) event.t += microseconds{100'000};
    }
    writer.close();
  }
  RunningCommand serving(words({"serve", "large.aedat4", "--port", "0", "--speed", "0", "--json"}), folder.path());
  transport::DvStreamClient client(events_address(serving), long_enough);
  std::this_thread::sleep_for(500ms);  // the server runs far ahead
  std::size_t heard = 0;
  while (client.receive(long_enough) == Received::packet) heard += client.events().size();
  EXPECT_EQ(heard, parts * part.size());
  const CommandResult result = serving.wait();
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(result.out)["dropped_clients"], 0);
}

TEST(ServeCommand, ServesAUnixSocketAndRemovesItAtTheEnd) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder / "events.socket";
  RunningCommand serving(words({"serve", recording, "--loop", "--unix", path.string()}));
  transport::DvStreamClient client(events_address(serving), long_enough);
  EXPECT_EQ(client.address().path, path);
  EXPECT_EQ(run_tactile("serve '" + recording + "' --unix '" + path.string() + "'").exit_code, 1);
  serving.signal(SIGTERM);
  EXPECT_EQ(serving.wait().exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(ServeCommand, ReportsThatARunIsSimulated) {
  const TemporaryFolder folder;
  const RunFolder run{folder / "fan/01", "fan", "01"};
  std::filesystem::create_directories(run.folder);
  std::filesystem::copy_file(recording, run.events());
  RunInfo info{.object = "fan", .run = "01", .session = {}, .simulated = true, .complete = true, .width = 160, .height = 120};
  info.extra["camera"] = {{"readout_mode", "variable-5000"}};
  write_run_info(run, info);
  RunningCommand serving(words({"serve", "fan/01", "--port", "0", "--speed", "0"}), folder.path());
  transport::DvStreamClient client(events_address(serving), long_enough);
  EXPECT_EQ(attribute(client.stream(), "simulated"), "true");
  EXPECT_EQ(attribute(client.stream(), "readoutMode"), "variable-5000");
  hear(client);
  const CommandResult result = serving.wait();
  EXPECT_NE(result.out.find("simulated"), std::string::npos) << result.out;
}

TEST(ServeCommand, ServesTheStreamThatIsChosen) {
  const TemporaryFolder folder;
  const auto file = folder / "two.aedat4";
  events::Stream left = events::event_stream_declaration({640, 480}, "LEFT"),
                 right = events::event_stream_declaration({640, 480}, "RIGHT");
  right.id = 1;
  {
    events::RecordingWriter writer(file, {left, right});
    writer.write_events(0, steady_events(10, 0, 1, {640, 480}));
    writer.write_events(1, steady_events(20, 0, 1, {640, 480}));
    writer.close();
  }
  for (const std::string choice : {"1", "RIGHT"}) {
    RunningCommand serving(words({"serve", file.string(), "--port", "0", "--speed", "0", "--stream", choice}));
    transport::DvStreamClient client(events_address(serving), long_enough);
    EXPECT_EQ(client.stream().source, "RIGHT");
    EXPECT_EQ(hear(client).events.size(), 20U);
    EXPECT_EQ(serving.wait().exit_code, 0);
  }
  const CommandResult unchosen = run_tactile("serve '" + file.string() + "' --port 0");
  EXPECT_EQ(unchosen.exit_code, 1);
  EXPECT_NE(unchosen.err.find("2 event streams"), std::string::npos) << unchosen.err;
}

TEST(ServeCommand, ReportsWhatARecordingLacks) {
  const TemporaryFolder folder;
  std::filesystem::copy_file(recording, folder / "cut.aedat4");
  std::filesystem::resize_file(folder / "cut.aedat4", 40'000);
  const CommandResult result = run_tactile("serve cut.aedat4 --port 0 --no-wait --speed 0", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("cut.aedat4: "), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("after the last whole packet are lost"), std::string::npos) << result.err;
}

TEST(ServeCommand, RefusesWhatItCannotServeInOneLine) {
  const auto refused = [](const std::string& arguments, const std::string& part) {
    const CommandResult result = run_tactile("serve " + arguments);
    EXPECT_EQ(result.exit_code, 1) << arguments;
    EXPECT_NE(result.err.find(part), std::string::npos) << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  };
  refused("no-such-file.aedat4", "no-such-file.aedat4");
  refused("sim:no-such-object", "no-such-object");
  refused("'" + recording + "' --host 192.0.2.1 --port 0", "192.0.2.1");
  refused("'" + std::string(test::data_folder) + "/aedat4/dv-events-only.aedat4' --port 0 --imu-port 0", "--imu-port");
  EXPECT_GE(run_tactile("serve sim --port 70000").exit_code, 100);
  EXPECT_GE(run_tactile("serve sim --port 0 --unix here").exit_code, 100);
  EXPECT_GE(run_tactile("serve sim --speed -1").exit_code, 100);
  EXPECT_GE(run_tactile("serve sim --packet-us 0").exit_code, 100);
}

}  // namespace
}  // namespace tactile::test
