#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "detect/detect_command.hpp"
#include "robot/fake_controller.hpp"
#include "support/comes_true.hpp"
#include "support/events_in_file.hpp"
#include "support/held_port.hpp"
#include "support/run_command.hpp"
#include "support/running_command.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/recording_writer.hpp"
#include "transport/scripted_server.hpp"

namespace tactile::detect {
namespace {

namespace fs = std::filesystem;
using test::comes_true;
using test::FakeController;
using test::rows_of;
using test::run_tactile;
using test::RunningCommand;
using test::trained;

using Row = test::TickRow;

/// A datagram socket on loopback.
struct Listener {
  int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
  std::uint16_t port = 0;

  Listener() {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof address;
    EXPECT_EQ(::bind(socket, reinterpret_cast<sockaddr*>(&address), length), 0);
    ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &length);
    port = ntohs(address.sin_port);
    const int bytes = 8 << 20;
    ::setsockopt(socket, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
  }
  ~Listener() { ::close(socket); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
};

TEST(DetectCommand, SetsTheRobotsBitsAndClearsThemInTheEnd) {
  const FakeController controller;
  const auto result = run_tactile(
      "detect --json --quiet --model small --from file:data/fan/02 --speed 1 --bit 64 --press-bit 65 --slip-bit 66 "
      "--confirmed-bit 67 --robot 127.0.0.1:" +
          std::to_string(controller.port()),
      trained().folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_GE(json.at("robot").at("raised").get<int>(), 2);
  EXPECT_GE(json.at("robot").at("event_to_write_us").at("count").get<int>(), 1);
  EXPECT_EQ(json.at("robot").at("controller"), "5.11.6.1071234");
  EXPECT_TRUE(comes_true([&] { return controller.writes() >= 4; }));
  for (const char* bit : {"64", "65", "66", "67"})
    EXPECT_TRUE(comes_true([&] { return controller.input(std::string("input_bit_register_") + bit) == false; })) << bit;
}

TEST(DetectCommand, WritesBitsThatFollowTheDecision) {
  const fs::path folder = trained().folder.path();
  const FakeController controller;
  const auto result = run_tactile(
      "detect --json --quiet --model small --from file:data/fan/02 --speed 1 --ticks decided.csv --press-bit 65 "
      "--slip-bit 66 --robot 127.0.0.1:" +
          std::to_string(controller.port()),
      folder);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::vector<Row> ticks = rows_of(folder / "decided.csv");
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
      std::any_of(ticks.begin(), ticks.end(), [](const Row& row) { return row.at("verdict") != row.at("predicted"); });
  EXPECT_TRUE(differs) << "the thresholds change no tick";
  const auto confirmed =
      std::count_if(ticks.begin(), ticks.end(), [](const Row& row) { return row.at("slip_confirmed") == "1"; });
  EXPECT_GT(confirmed, 0);
  EXPECT_TRUE(std::all_of(ticks.begin(), ticks.end(),
                          [](const Row& row) { return row.at("slip_confirmed") == "0" || row.at("verdict") == "slip"; }));
  EXPECT_GE(json.at("episodes").at("confirmed_slip").get<int>(), 1);
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
  const std::vector<Row> reported = rows_of(trained().folder.path() / "udp.csv");
  std::size_t got = 0;
  for (std::array<char, 100> bytes{}; ::recv(listener.socket, bytes.data(), bytes.size(), MSG_DONTWAIT) == 64; ++got) {
    std::uint64_t number = 0;
    std::int64_t t = 0;
    std::memcpy(&number, bytes.data() + 8, sizeof number);
    std::memcpy(&t, bytes.data() + 16, sizeof t);
    ASSERT_LT(number, reported.size());
    EXPECT_EQ(std::to_string(t), reported[number].at("t_us"));
    EXPECT_EQ(reported[number].at("verdict"), bytes[60] == 0 ? "none" : bytes[60] == 1 ? "press" : "slip");
  }
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("udp").at("sent").get<std::size_t>() + json.at("udp").at("failed").get<std::size_t>(), reported.size());
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
  const auto result = run_tactile("detect --model small --from file:data/fan/02 --speed 0 --plot drawn.svg", folder);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("Drawn in drawn.svg"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("no deadline"), std::string::npos) << result.out;
  EXPECT_EQ(result.out.find("a tick late"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("slip  at "), std::string::npos) << result.out;
  const std::string svg = read_text(folder / "drawn.svg");
  EXPECT_NE(svg.find("labelled"), std::string::npos);
  EXPECT_NE(svg.find("first right verdict"), std::string::npos);
  EXPECT_NE(svg.find("time since the first event [s]"), std::string::npos);
}

TEST(DetectCommand, PrintsSecondsSinceTheFirstEventOrCameraTime) {
  const fs::path folder = trained().folder.path();
  const std::string command = "detect --model small --from file:data/fan/02 --speed 0";
  const double first_s = 1e-6 * static_cast<double>(us_of(test::events_in_file(folder / "data/fan/02/events.aedat4").front().t));
  ASSERT_GT(first_s, 1) << "otherwise both would look alike";
  const auto begins_of = [&](const std::string& options) {
    std::vector<double> begins;
    const std::string text = run_tactile(command + options, folder).out;
    for (std::size_t at = text.find(" at "); at != std::string::npos; at = text.find(" at ", at + 1)) {
      if (text.find(" s, probability", at) == text.find(" s", at)) begins.push_back(std::stod(text.substr(at + 4)));
    }
    return begins;
  };
  const std::vector<double> since_first = begins_of(""), camera = begins_of(" --camera-time");
  ASSERT_FALSE(since_first.empty());
  ASSERT_EQ(since_first.size(), camera.size());
  for (std::size_t i = 0; i < camera.size(); ++i) EXPECT_NEAR(camera[i] - since_first[i], first_s, 1e-6) << i;
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
  EXPECT_GT(json.at("ticks").at("reported").get<int>(), 0);
}

}  // namespace
}  // namespace tactile::detect
