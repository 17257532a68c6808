#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdlib>
#include <future>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "interruption.hpp"
#include "live_line.hpp"
#include "option_checks.hpp"
#include "page_port.hpp"
#include "record_preview.hpp"
#include "record_runs.hpp"
#include "source_arguments.hpp"
#include "tactile/capture/camera_source.hpp"
#include "tactile/capture/find_sources.hpp"
#include "tactile/capture/readout_mode.hpp"
#include "tactile/capture/run_recorder.hpp"
#include "tactile/capture/session_plan.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/transport/network_address.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

struct RecordArguments {
  std::vector<std::string> from;
  std::string robot, video;
  double duration_s = 0;
  std::string object = "unnamed", run;
  std::string out;  ///< empty: `usual_folder`
  std::string session;
  std::string start_on, stop_on;
  double speed = 1;
  std::uint64_t seed = 1;
  std::string stream;
  std::string readout_mode;
  std::string compression = "lz4";
  std::size_t queue_mb = 256;
  bool list = false;
  std::string preview;
};

void list_sources(const CommonArguments& common) {
  nlohmann::json cameras = nlohmann::json::array(), videos = nlohmann::json::array();
  std::vector<std::pair<std::string, std::string>> lines;
  const auto add = [&](nlohmann::json& json, const std::vector<capture::FoundSource>& found, const std::string& option) {
    for (const capture::FoundSource& source : found) {
      json.push_back({{"text", source.text}, {"description", source.description}});
      lines.emplace_back(source.text.empty() ? "-" : option + " " + source.text, source.description);
    }
  };
  add(cameras, capture::find_camera_sources(), "--from");
  add(videos, capture::find_video_devices(), "--video");
  if (cameras.empty()) lines.emplace_back("-", "no camera, and no stream at " + capture::SourcePlaces{}.stream);
  if (videos.empty()) lines.emplace_back("-", "no video device");
  print_result(common, {{"sources", cameras}, {"videos", videos}}, text_list(lines));
}

std::unique_ptr<robot::RobotMonitor> open_robot(const RecordArguments& args, const capture::SessionPlan& plan, LiveLine& line) {
  if (args.robot.empty()) {
    if (plan.start_on || plan.stop_on) throw Error("record: --start-on and --stop-on need a robot; expected --robot HOST");
    return nullptr;
  }
  const transport::NetworkAddress address = robot_address(args.robot);
  robot::RobotMonitorOptions options;
  options.host = address.host;
  options.port = address.port;
  for (const auto& bit : {plan.start_on, plan.stop_on}) {
    if (bit) options.required_fields.push_back(bit->field);
  }
  options.log = [&line](const std::string& text) { line.warn(text); };
  return std::make_unique<robot::RobotMonitor>(std::move(options));
}

std::unique_ptr<video::VideoCapture> open_video(const RecordArguments& args, LiveLine& line) {
  if (args.video.empty()) return nullptr;
  video::VideoCaptureOptions options;
  options.source = args.video;
  options.speed = args.speed;
  options.log = [&line](const std::string& text) { line.warn(text); };
  return std::make_unique<video::VideoCapture>(std::move(options));
}

/// Nothing after Ctrl-C.
std::unique_ptr<capture::RunRecorder> open_recorder(const RecordArguments& args, const capture::SessionPlan& plan, LiveLine& line,
                                                    RecordPreview* preview) try {
  // The cameras are opened last, because recording begins with their first data.
  std::unique_ptr<robot::RobotMonitor> robot = open_robot(args, plan, line);
  if (interrupted()) return nullptr;
  std::unique_ptr<video::VideoCapture> video = open_video(args, line);
  std::vector<std::unique_ptr<capture::CameraSource>> sources;
  const capture::CameraSourceOptions options{
      .speed = args.speed, .seed = args.seed, .readout_mode = args.readout_mode, .stream = args.stream};
  for (const std::string& text : args.from) {
    if (interrupted()) return nullptr;
    sources.push_back(capture::open_camera_source(text, options));
    if (const std::string remark = sources.back()->remark(); !remark.empty()) line.warn(fmt::format("{}: {}", text, remark));
  }
  capture::RunRecorderOptions recorder_options{.queue_bytes = args.queue_mb << 20,
                                               .compression = events::compression_named(args.compression),
                                               .log = [&line](const std::string& text) { line.warn(text); }};
  if (preview != nullptr) {
    recorder_options.see_events = [preview](std::span<const events::Event> seen) { preview->see(seen); };
    recorder_options.see_imu = [preview](std::span<const events::ImuSample> seen) { preview->see(seen); };
  }
  return std::make_unique<capture::RunRecorder>(std::move(sources), std::move(robot), std::move(video),
                                                std::move(recorder_options));
} catch (const Error&) {
  if (!interrupted()) throw;
  return nullptr;  // after Ctrl-C an error does not matter
}

/// Calls `give_up` and ends with 0 if Ctrl-C comes while a source is opened. Opening may take seconds and cannot be cancelled, so
/// its thread is left running. Nothing has been written by then.
template <class GiveUp>
std::unique_ptr<capture::RunRecorder> open_unless_interrupted(const RecordArguments& args, const capture::SessionPlan& plan,
                                                              LiveLine& line, RecordPreview* preview, const GiveUp& give_up) {
  using std::chrono::milliseconds;
  std::future<std::unique_ptr<capture::RunRecorder>> opened =
      std::async(std::launch::async, [&] { return open_recorder(args, plan, line, preview); });
  while (opened.wait_for(milliseconds(50)) != std::future_status::ready) {
    // A source that is just being opened, such as a camera, is closed in order.
    if (interrupted() && opened.wait_for(milliseconds(500)) != std::future_status::ready) {
      give_up();
      std::_Exit(0);
    }
  }
  return opened.get();
}

capture::RobotBit bit_of(const std::string& option, const std::string& text) {
  try {
    return capture::robot_bit(text);
  } catch (const Error& e) {
    throw Error(option + " " + e.what());
  }
}

capture::SessionPlan plan_of(const RecordArguments& args) {
  capture::SessionPlan plan;
  if (!args.session.empty()) {
    plan = capture::read_session_plan(args.session);
  } else {
    plan.objects.push_back({.name = args.object, .runs = 1});
  }
  if (args.duration_s > 0) plan.duration_s = args.duration_s;
  if (!args.start_on.empty()) plan.start_on = bit_of("--start-on", args.start_on);
  if (!args.stop_on.empty()) plan.stop_on = bit_of("--stop-on", args.stop_on);
  return plan;
}

nlohmann::json settings_json(const RecordArguments& args, const capture::SessionPlan& plan) {
  nlohmann::json json = {{"from", args.from},
                         {"compression", args.compression},
                         {"speed", args.speed},
                         {"seed", args.seed},
                         {"queue_mb", args.queue_mb}};
  const auto add = [&json](const char* key, const std::string& value) {
    if (!value.empty()) json[key] = value;
  };
  add("robot", args.robot);
  add("video", args.video);
  add("stream", args.stream);
  add("readout_mode", args.readout_mode);
  if (plan.duration_s) json["duration_s"] = *plan.duration_s;
  if (plan.start_on) json["start_on"] = plan.start_on->text();
  if (plan.stop_on) json["stop_on"] = plan.stop_on->text();
  return json;
}

/// The result of a run, or of all runs of a session.
void print_runs(const CommonArguments& common, const std::string& data, bool is_session, const RecordedRuns& recorded) {
  const auto& [runs, error] = recorded;
  std::string text;
  nlohmann::json all = nlohmann::json::array();
  for (const capture::RunSummary& run : runs) {
    text += (text.empty() ? "" : "\n") + cli::text_of(run);
    all.push_back(cli::json_of(run));
  }
  if (runs.empty()) text = "no run recorded\n";
  if (is_session) {
    print_result(common, {{"data", data}, {"runs", all}, {"error", error.empty() ? nlohmann::json() : nlohmann::json(error)}},
                 text);
  } else {
    print_result(common, runs.empty() ? nlohmann::json() : all.front(), text);
  }
}

/// Simulated runs have a folder of their own, so that they never lie among real ones.
std::string usual_folder(const std::vector<std::string>& from) {
  const auto is_simulator = [](const std::string& source) { return source == "sim" || source.starts_with("sim:"); };
  return !from.empty() && std::all_of(from.begin(), from.end(), is_simulator) ? "data-sim" : "data";
}

void record(RecordArguments args, const CommonArguments& common) {
  if (args.list) return list_sources(common);
  if (!args.readout_mode.empty()) capture::readout_mode(args.readout_mode);
  if (args.out.empty()) args.out = usual_folder(args.from);
  RunsToRecord wanted{
      .data = args.out, .plan = plan_of(args), .is_session = !args.session.empty(), .run = args.run, .settings = {}, .watch = {}};
  if (args.from.empty()) args.from.push_back(default_source("record"));
  wanted.settings = settings_json(args, wanted.plan);

  LiveLine line(!common.quiet);
  const auto print = [&](const RecordedRuns& recorded) { print_runs(common, args.out, wanted.is_session, recorded); };
  std::optional<RecordPreview> preview;  // outlives the recorder, whose sources show it events
  if (!args.preview.empty()) preview.emplace(page_port("--preview", args.preview), args.out);
  const std::unique_ptr<capture::RunRecorder> recorder =
      open_unless_interrupted(args, wanted.plan, line, preview ? &*preview : nullptr, [&] { print({}); });
  if (recorder && preview) {
    line.inform("preview at " + preview->open(*recorder));
    wanted.watch = [&preview](const RecordMoment& moment) { preview->show(moment); };
    wanted.choices = &preview->choices();
  }
  const RecordedRuns recorded = recorder ? record_runs(*recorder, wanted, line) : RecordedRuns{};
  if (recorder && preview) preview->end(*recorder, recorded);
  if (!recorded.runs.empty() || recorded.error.empty()) print(recorded);
  if (!recorded.error.empty()) throw Error(recorded.error);
}

}  // namespace

void add_record_command(CLI::App& app) {
  auto args = std::make_shared<RecordArguments>();
  Command command = add_command(
      app, "record", "Record a live camera, a robot and a video into a run folder",
      [args](const CommonArguments& common) { record(*args, common); }, CtrlC::is_the_end);
  const auto is_object = Check{[](std::string& text) { return why_not_an_object_name(text); }, ""};
  command
      .add_option(
          "--from", args->from,
          "Event source: tcp://HOST:PORT, unix:PATH, file:PATH, sim[:OBJECT] or camera[:SERIAL]; repeat for more streams. "
          "Default: the only camera, else tcp://127.0.0.1:7777")
      .type_name("SOURCE");
  command.add_option("--robot", args->robot, "UR controller to log").type_name("HOST[:PORT]");
  command.add_option("--video", args->video, "Video source").type_name("DEVICE|FILE|URL");
  command.add_option("--duration", args->duration_s, "Stop each run after this time [s]")
      .check(in_range(1e-3, 1e9))
      .type_name("S");
  const Option object =
      command.add_option("--object", args->object, "Name of the object").check(is_object).type_name("NAME").show_default();
  const Option run =
      command.add_option("--run", args->run, "Number of the run; default: the next free number").check(is_run()).type_name("NN");
  command.add_option("--out", args->out, "Folder of runs").type_name("DATA").default_text("data, or data-sim with --from sim");
  command.add_option("--session", args->session, "Record this list of objects and runs")
      .type_name("FILE.json")
      .check(is_existing_file())
      .excludes(object)
      .excludes(run);
  command.add_option("--start-on", args->start_on, "Robot bit that starts a run when it rises").type_name("FIELD[:BIT]");
  command.add_option("--stop-on", args->stop_on, "Robot bit that ends a run when it rises").type_name("FIELD[:BIT]");
  command.add_option("--speed", args->speed, "Speed of files and the simulator: 1 is real time, 0 is as fast as possible")
      .check(in_range(0.0, 1e6))
      .show_default();
  command.add_option("--seed", args->seed, "Seed of the simulator").check(is_seed()).show_default();
  command.add_option("--stream", args->stream, "Event stream to use, if a file has several").type_name("ID|SOURCE");
  command.add_option("--readout-mode", args->readout_mode, "Read-out mode of the camera, such as variable-5000")
      .type_name("MODE");
  command.add_option("--compression", args->compression, "Compression of the recording")
      .check(one_of({"none", "lz4", "lz4-high", "zstd", "zstd-high"}))
      .show_default();
  command.add_option("--queue-mb", args->queue_mb, "Memory for data that waits for the disk [MiB]")
      .check(in_range(std::size_t{1}, std::size_t{65536}))
      .show_default();
  add_page_option(command, "--preview", args->preview,
                  "Show the recording on a local page while it runs, at this port; 0 takes a free port");
  command.add_flag("--list", args->list, "List cameras, streams and video devices, then exit");
}

}  // namespace tactile::cli
