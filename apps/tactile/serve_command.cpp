#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "interruption.hpp"
#include "live_line.hpp"
#include "option_checks.hpp"
#include "quantity_text.hpp"
#include "tactile/capture/camera_broadcast.hpp"
#include "tactile/capture/camera_source.hpp"
#include "tactile/capture/camera_streams.hpp"
#include "tactile/capture/looped_source.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/simulated_recording.hpp"
#include "tactile/transport/dv/dv_stream_server.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

using SteadyClock = std::chrono::steady_clock;

/// At full speed, a client that accepts no bytes for this long is not waited for any more.
constexpr std::chrono::milliseconds longest_stall = 10s;

/// Between the first client and the first packet.
constexpr std::chrono::milliseconds settling = 500ms;

struct ServeArguments {
  std::string source;
  std::string host = "127.0.0.1";
  std::uint16_t port = 7777;
  std::optional<std::uint16_t> imu_port, triggers_port;
  std::string unix_path;
  double speed = 1;
  bool loop = false, no_wait = false;
  std::string compression = "none";
  std::int64_t packet_us = 1000;
  std::string stream;
  std::uint64_t seed = 1;
};

bool is_simulator(const std::string& text) { return text == "sim" || text.starts_with("sim:"); }

std::unique_ptr<capture::CameraSource> open_source(const ServeArguments& args) {
  capture::CameraSourceOptions options;
  options.speed = args.speed;
  options.seed = args.seed;
  options.packet_span = microseconds{args.packet_us};
  if (is_simulator(args.source)) {
    if (!args.stream.empty()) throw Error("--stream: the simulator has one stream; expected --stream only for a recording");
    return capture::open_camera_source(args.source, options);
  }
  if (!std::filesystem::exists(args.source)) {
    throw Error(args.source + ": no such file or run; expected a recording, a run's folder, or sim[:OBJECT]");
  }
  options.stream = args.stream;
  const auto open = [text = "file:" + args.source, options] { return capture::open_camera_source(text, options); };
  if (args.loop) return capture::looped_source(open, microseconds{args.packet_us});
  return open();
}

/// The camera's stream of this type, as the server declares it. @throws Error  if there is none
events::Stream stream_to_serve(const ServeArguments& args, const capture::CameraSource& source, events::StreamType type,
                               const std::string& option) {
  const auto streams = source.streams();
  const auto found = std::find_if(streams.begin(), streams.end(), [&](const events::Stream& s) { return s.type == type; });
  if (found == streams.end()) {
    throw Error(fmt::format("{}: its camera has no stream of {} for {}; expected a recording with one", args.source,
                            name_of(type), option));
  }
  events::Stream stream = *found;
  if (source.simulated()) capture::set_info(stream, events::simulated_attribute, "true");
  const nlohmann::json camera = source.camera();
  if (const auto mode = camera.find("readout_mode"); mode != camera.end() && mode->is_string()) {
    capture::set_info(stream, capture::readout_mode_attribute, mode->get<std::string>());
  }
  return stream;
}

struct Served {
  events::Stream stream;
  std::unique_ptr<transport::DvStreamServer> server;
};

std::vector<Served> start_servers(const ServeArguments& args, const capture::CameraSource& source, LiveLine& line) {
  transport::DvStreamServerOptions options;
  options.compression = events::compression_named(args.compression);
  const auto tcp = [&](std::uint16_t port) {
    return transport::NetworkAddress{.kind = transport::NetworkAddress::Kind::tcp, .host = args.host, .port = port, .path = {}};
  };
  std::vector<Served> served;
  const auto add = [&](events::StreamType type, const std::string& option, const transport::NetworkAddress& address) {
    Served& one = served.emplace_back();
    one.stream = stream_to_serve(args, source, type, option);
    options.log = [&line, name = std::string(name_of(type))](const std::string& text) { line.inform(name + ": " + text); };
    one.server = std::make_unique<transport::DvStreamServer>(address, one.stream, options);
  };
  add(events::StreamType::events, "--port",
      args.unix_path.empty() ? tcp(args.port) : transport::network_address("unix:" + args.unix_path));
  if (args.imu_port) add(events::StreamType::imu, "--imu-port", tcp(*args.imu_port));
  if (args.triggers_port) add(events::StreamType::triggers, "--triggers-port", tcp(*args.triggers_port));
  return served;
}

struct ClientCounts {
  std::uint64_t now = 0, joined = 0, dropped = 0;
};

ClientCounts clients_of(const std::vector<Served>& served) {
  ClientCounts counts;
  for (const Served& one : served) {
    counts.now += one.server->clients();
    counts.joined += one.server->joined_clients();
    counts.dropped += one.server->dropped_clients();
  }
  return counts;
}

/// Draws the rates of the last second, four times per second.
class ServeLine {
 public:
  explicit ServeLine(LiveLine& line) : line_(line) {}

  void draw(const capture::BroadcastCounts& counts, const std::vector<Served>& served) {
    if (!line_.draws()) return;
    const SteadyClock::time_point now = SteadyClock::now();
    if (now - drawn_ < 250ms) return;
    const double passed = std::chrono::duration<double>(now - drawn_).count();
    const ClientCounts clients = clients_of(served);
    line_.draw(fmt::format("{}  events {}  {}{}", clock_text(std::chrono::duration<double>(now - begun_).count()),
                           rate_text(static_cast<double>(counts.events - events_) / passed), counted(clients.now, "client"),
                           clients.dropped > 0 ? fmt::format("  {} dropped", clients.dropped) : ""));
    drawn_ = now;
    events_ = counts.events;
  }

 private:
  LiveLine& line_;
  SteadyClock::time_point begun_ = SteadyClock::now(), drawn_ = begun_;
  std::uint64_t events_ = 0;
};

/// Waits until each server has a client that stays for a moment. A client that only checks for a stream leaves soon. A client
/// that records receives the whole stream.
void wait_for_clients(const std::vector<Served>& served, LiveLine& line) {
  const auto all_have = [&] {
    return std::all_of(served.begin(), served.end(), [](const Served& one) { return one.server->clients() > 0; });
  };
  line.draw(served.size() > 1 ? "waiting for a client of each stream" : "waiting for a client");
  SteadyClock::time_point ready = SteadyClock::now() + settling;
  while (!interrupted() && SteadyClock::now() < ready) {
    if (!all_have()) ready = SteadyClock::now() + settling;
    std::this_thread::sleep_for(10ms);
  }
  line.clear();
}

void play(const ServeArguments& args, capture::CameraSource& source, capture::CameraBroadcast& broadcast,
          const std::vector<Served>& served, LiveLine& line) {
  ServeLine live(line);
  capture::CameraPacket packet;
  while (!interrupted()) {
    const capture::CameraSource::Received received = source.receive(packet, 50ms);
    if (received == capture::CameraSource::Received::ended) return;
    if (received == capture::CameraSource::Received::packet) {
      broadcast.send(packet);
      if (args.speed == 0) {
        for (const Served& one : served) one.server->wait_for_room(longest_stall, interrupted);
      }
    }
    live.draw(broadcast.counts(), served);
  }
}

void serve(const ServeArguments& args, const CommonArguments& common) {
  LiveLine line(!common.quiet);
  const std::unique_ptr<capture::CameraSource> source = open_source(args);
  if (const std::string remark = source->remark(); !remark.empty()) line.warn(args.source + ": " + remark);
  capture::CameraBroadcast broadcast({.packet_span = microseconds{args.packet_us}});
  const std::vector<Served> served = start_servers(args, *source, line);
  nlohmann::json streams = nlohmann::json::array();
  for (const Served& one : served) {
    broadcast.add(one.stream.id, *one.server);
    const std::string address = one.server->address().text();
    // fmt::print would throw if no program reads stderr.
    std::fputs(fmt::format("serving {} of {} on {}\n", name_of(one.stream.type), args.source, address).c_str(), stderr);
    streams.push_back({{"type", name_of(one.stream.type)}, {"address", address}});
  }
  std::fflush(stderr);
  if (!args.no_wait && !is_simulator(args.source)) wait_for_clients(served, line);

  const SteadyClock::time_point begun = SteadyClock::now();
  play(args, *source, broadcast, served, line);
  const std::chrono::duration<double> duration = SteadyClock::now() - begun;
  const bool was_interrupted = interrupted();
  for (const Served& one : served) one.server->drain(was_interrupted ? 1s : longest_stall);
  // When the connection closes, the vendor's reader discards the packets that its user has not read yet.
  if (!was_interrupted && clients_of(served).now > 0) std::this_thread::sleep_for(settling);
  line.clear();

  const capture::BroadcastCounts& counts = broadcast.counts();
  const ClientCounts clients = clients_of(served);
  const capture::SourceDrops drops = source->drops();
  const nlohmann::json json = {
      {"source", args.source},           {"simulated", source->simulated()},  {"streams", streams},
      {"events", counts.events},         {"imu_samples", counts.imu_samples}, {"triggers", counts.triggers},
      {"packets", counts.packets},       {"clients", clients.joined},         {"dropped_clients", clients.dropped},
      {"broken_packets", drops.packets}, {"unsound_events", drops.events},    {"unsound_others", drops.others},
      {"duration_s", duration.count()},  {"interrupted", was_interrupted}};
  std::string played = counted(counts.events, "event");
  if (counts.imu_samples > 0) played += ", " + counted(counts.imu_samples, "IMU sample");
  if (counts.triggers > 0) played += ", " + counted(counts.triggers, "trigger");
  std::vector<std::pair<std::string, std::string>> lines{
      {"played", fmt::format("{} in {}", played, counted(counts.packets, "packet"))},
      {"lasted", duration_text(microseconds{static_cast<std::int64_t>(1e6 * duration.count())})},
      {"clients", fmt::format("{}, {} dropped", clients.joined, clients.dropped)}};
  if (drops.packets + drops.events + drops.others > 0) {
    std::string lost = counted(drops.packets, "unreadable packet") + ", " + counted(drops.events, "impossible event");
    if (drops.others > 0)
      lost +=
          ", " + counted(drops.others, "impossible IMU sample, trigger or frame", "impossible IMU samples, triggers and frames");
    lines.emplace_back("lost", lost);
  }
  print_result(common, json, fmt::format("{}{}\n", args.source, source->simulated() ? " (simulated)" : "") + text_list(lines));
}

}  // namespace

void add_serve_command(CLI::App& app) {
  auto args = std::make_shared<ServeArguments>();
  Command command = add_command(
      app, "serve", "Play a recording or the simulator as a DV-compatible stream",
      [args](const CommonArguments& common) { serve(*args, common); }, CtrlC::is_the_end);
  command.add_option("source", args->source, "Recording, run folder, or simulator: FILE, RUN or sim[:OBJECT]")
      .type_name("SOURCE")
      .required();
  const Check is_port = in_range<std::uint16_t>(0, 65535);
  const Option port = command.add_option("--port", args->port, "Port of the event stream; 0 takes a free port")
                          .check(is_port)
                          .type_name("N")
                          .show_default();
  command.add_option("--host", args->host, "Address to listen on; 0.0.0.0 allows other machines")
      .type_name("HOST")
      .show_default();
  command.add_option("--unix", args->unix_path, "Serve the events on a new unix socket instead").type_name("PATH").excludes(port);
  command.add_option("--imu-port", args->imu_port, "Also serve the camera's IMU samples on this port")
      .check(is_port)
      .type_name("N");
  command.add_option("--triggers-port", args->triggers_port, "Also serve the camera's triggers on this port")
      .check(is_port)
      .type_name("N");
  command.add_option("--speed", args->speed, "Speed: 1 is real time, 0 is as fast as the clients read")
      .check(in_range(0.0, 1e6))
      .show_default();
  command.add_flag("--loop", args->loop, "Repeat the recording without end; timestamps continue");
  command.add_flag("--no-wait", args->no_wait, "Start at once; default: wait for a client of each stream");
  command.add_option("--compression", args->compression, "Compression of the packets")
      .check(one_of({"none", "lz4", "lz4-high", "zstd", "zstd-high"}))
      .show_default();
  command.add_option("--packet-us", args->packet_us, "Longest time span of a packet [us]")
      .check(in_range(1, 1'000'000))
      .type_name("N")
      .show_default();
  command.add_option("--stream", args->stream, "Event stream to use, if a recording has several").type_name("ID|SOURCE");
  command.add_option("--seed", args->seed, "Seed of the simulator").check(is_seed()).show_default();
}

}  // namespace tactile::cli
