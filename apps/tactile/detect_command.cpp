#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "camera_time.hpp"
#include "chosen_model.hpp"
#include "command.hpp"
#include "commands.hpp"
#include "detect_page.hpp"
#include "detect_plot.hpp"
#include "detect_report.hpp"
#include "field_options.hpp"
#include "live_line.hpp"
#include "model_arguments.hpp"
#include "option_checks.hpp"
#include "page_port.hpp"
#include "rendering_arguments.hpp"
#include "robot_arguments.hpp"
#include "source_arguments.hpp"
#include "tactile/core/error.hpp"
#include "tactile/detect/detection_session.hpp"
#include "tactile/heatmaps/run_heatmaps.hpp"
#include "tactile/model/bundle/temperature.hpp"
#include "tactile/model/training/open_classifier.hpp"
#include "tactile/pictures/gnuplot.hpp"
#include "tick_reader.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

struct DetectArguments {
  std::string model, models = "models";
  std::string from;
  capture::CameraSourceOptions source;
  double reconnect_s = 10, duration_s = 0;
  model::EngineKind engine = model::EngineKind::fast;
  model::Precision precision = model::Precision::fp32;
  DecisionArguments decision{.thresholds = text_of(model::TwoThresholds{})};
  std::int64_t slack_us = 2000;
  std::optional<std::int64_t> tick_us;
  std::string ticks, plot, udp, mask, page;
  RobotArguments robot;
  bool no_real_time = false, no_rehearsal = false, awake = false, camera_time = false, verbose = false;
  bool record = false;
  std::string out = "data", object = "unnamed", run;
};

/// Checks a recording before the first verdict, as `eval` does. @throws Error  if it seems to have too many ticks
void check_tick_count(const DetectArguments& args, const heatmaps::HeatmapOptions& rendering) {
  if (!args.from.starts_with("file:") || args.duration_s > 0) return;
  const fs::path path = args.from.substr(5);
  if (!fs::exists(path)) return;  // opening the source reports it
  const fs::path file = fs::is_directory(path) ? recording_in(path) : path;
  const events::RecordingReader reader(file);
  const std::string why =
      why_too_many(heatmaps::listed_ticks(reader, events::event_stream(reader, args.source.stream).id, rendering));
  if (!why.empty()) throw Error(file.string() + ": " + why);
}

model::Classifier opened(const DetectArguments& args, const model::ModelBundle& bundle) {
  if (args.engine == model::EngineKind::libtorch && args.precision != model::Precision::fp32) {
    throw Error(fmt::format("--precision {}: libtorch supports only fp32; expected --engine fast", name_of(args.precision)));
  }
  return model::open_classifier(bundle.folder, 1, args.engine, {.precision = args.precision});
}

/// The run folder that a file source plays, if it has labels or truth.
std::optional<RunFolder> played_run(const std::string& source) {
  if (!source.starts_with("file:")) return std::nullopt;
  const fs::path path = source.substr(5);
  const fs::path folder = fs::is_directory(path) ? path : path.parent_path();
  const bool is_run = fs::exists(folder / "labels.json") || fs::exists(folder / "truth.json");
  if (!is_run || (!fs::is_directory(path) && path.filename() != "events.aedat4")) return std::nullopt;
  return run_folder_at(folder);
}

/// The tick that --tick-us asks for. @throws Error  unless the model's history is a whole number of it
microseconds tick_within(microseconds history, std::int64_t tick_us, const std::string& model) {
  if (tick_us <= history.count() && history.count() % tick_us == 0) return microseconds{tick_us};
  const auto divides = [&history](std::int64_t us) { return history.count() % us == 0; };
  std::int64_t below = std::min(tick_us, history.count()), above = below;
  while (!divides(below)) --below;
  while (!divides(above)) ++above;
  throw Error(fmt::format(
      "--tick-us {}: the history t_h of {} is {} us, which is not a whole number of such ticks; expected {}", tick_us, model,
      history.count(), below == above ? fmt::format("{} at most", below) : fmt::format("a tick such as {} or {}", below, above)));
}

/// @throws Error  unless `udp` is HOST:PORT
transport::NetworkAddress udp_address(const std::string& udp) {
  try {
    return transport::network_address("tcp://" + udp);
  } catch (const Error&) {
    throw Error("--udp '" + udp + "': is no address; expected HOST:PORT with a port from 1 to 65535");
  }
}

/// All but the network and the messages.
detect::DetectionOptions session_options(const DetectArguments& args, const model::ModelBundle& bundle,
                                         const model::ModelDescription& model) {
  detect::DetectionOptions options;
  options.source_options = args.source;
  options.robot = robot_options(args.robot);
  if (!args.udp.empty()) options.udp = udp_address(args.udp);
  options.scene = model.scene;
  heatmaps::HeatmapOptions& rendering = options.detector.rendering;
  rendering = model.settings.rendering;
  if (!args.mask.empty()) rendering.mask = events::read_mask(args.mask);
  check(rendering);
  if (args.tick_us) rendering.tick = tick_within(rendering.history, *args.tick_us, bundle.name());
  options.detector.decision = decision_of(args.decision, model.settings.kind);
  options.detector.temperature = model::read_temperature(bundle, model).value;
  options.slack = microseconds{args.slack_us};
  options.rehearses = !args.no_rehearsal;
  options.reconnect = std::chrono::milliseconds{std::llround(1000 * args.reconnect_s)};
  if (args.duration_s > 0) options.duration = microseconds{std::llround(1e6 * args.duration_s)};
  options.real_time = !args.no_real_time;
  options.awake = args.awake;
  if (args.record) options.record = {.data = args.out, .object = args.object, .run = args.run};
  return options;
}

/// @return  a sentence that names the picture; empty without --plot or ticks
std::string draw(const DetectArguments& args, const detect::DetectionSummary& summary, const std::string& model,
                 const std::vector<detect::ReportedTick>& ticks) {
  if (args.plot.empty() || ticks.empty()) return {};
  std::optional<RunFolder> run = played_run(args.from);
  if (summary.recorded && fs::exists(summary.recorded->run.truth())) run = summary.recorded->run;
  draw_ticks(ticks, summary.detector.rendering,
             fmt::format("{}{}, predicted by {}", args.from, summary.simulated ? " (simulated)" : "", model), run, args.plot);
  const bool restarted = ticks.front().beginning != ticks.back().beginning;
  return fmt::format("\nDrawn in {}{}\n", args.plot,
                     restarted ? ": the ticks since the last restart of the stream; --ticks FILE.csv writes all" : "");
}

void detect(DetectArguments args, const CommonArguments& common) {
  if (!args.plot.empty()) pictures::check_is_picture(args.plot);
  const ChosenModel chosen = live_model(args.model, args.models);
  const model::ModelBundle& bundle = chosen.bundle;
  const model::ModelDescription model = model::read_description(bundle);
  LiveLine line(!common.quiet);
  detect::DetectionOptions options = session_options(args, bundle, model);
  options.inform = [&line](const std::string& text) { line.inform(text); };
  std::optional<DetectPage> page;  // outlives the session, whose source shows it events
  if (args.from.empty()) args.from = default_source("detect");
  if (!args.page.empty())
    page.emplace(page_port("--page", args.page),
                 DetectPageLabels{.source = args.from, .model = bundle.name(), .recorded = args.record ? args.out : ""});
  if (page) options.see_events = [&page](std::span<const events::Event> seen) { page->see(seen); };
  options.warn = [&line, &page](const std::string& text) {
    line.warn(text);
    if (page) page->warn(text);
  };
  line.inform("detecting with " + bundle.folder.string() + (chosen.why.empty() ? "" : ", " + chosen.why));
  if (!model.scene && !model.own)
    line.inform(bundle.name() +
                " does not know the scenes of its training runs, so the scene is not watched; 'tactile train --force' adds them");
  check_tick_count(args, options.detector.rendering);
  options.source = args.from;

  const model::Classifier classifier = opened(args, bundle);
  const heatmaps::HeatmapOptions rendering = options.detector.rendering;
  detect::DetectionSession session(std::move(options), [&](events::SensorSize sensor) {
    auto on_events = classifier.on_events(sensor, rendering);
    if (page) line.inform("page at " + page->open(sensor, rendering));
    return on_events;
  });
  TickReader reader({.csv = args.ticks, .keeps = !args.plot.empty(), .camera_time = args.camera_time, .prints = !common.json},
                    line);
  detect::DetectionSummary summary = session.run(page ? page->shown(reader.output()) : reader.output());
  line.clear();
  if (page) page->end(summary);
  summary.ticks_left_out += reader.not_kept();
  const DetectModel used{.name = bundle.name(),
                         .engine = std::string(name_of(classifier.engine())),
                         .precision = std::string(name_of(args.precision))};
  const std::string drawn = draw(args, summary, used.name, reader.kept());
  print_result(common, json_of(summary, used), (common.json ? "" : "\n") + text_of(summary, used, args.verbose) + drawn);
  if (summary.failure) std::rethrow_exception(summary.failure);
  if (!args.plot.empty() && reader.kept().empty())
    throw Error(args.plot + ": there is no tick to draw; expected a stream longer than the history");
}

void add_model_options(Command& command, DetectArguments& args) {
  command.add_option("--model", args.model, live_model_help);
  command.add_option("--models", args.models, "Folder of models").type_name("DIR").show_default();
  command
      .add_option(
          "--from", args.from,
          "Event source: tcp://HOST:PORT, unix:PATH, file:PATH, sim[:OBJECT] or camera[:SERIAL]. Default: the only camera, "
          "else tcp://127.0.0.1:7777")
      .type_name("SOURCE");
  add_confirm_option(command, args.decision);
  add_thresholds_option(command, args.decision);
  add_mask_option(command, args.mask).default_text("the model's");
  add_engine_option(command, args.engine);
  add_word(command, "--precision", args.precision, model::precision_names, "Precision of the fast engine's largest layer");
  command.add_option("--tick-us", args.tick_us, "Time between two verdicts [us]; t_h must be a multiple of it")
      .check(in_range(std::int64_t{1}, std::int64_t{1'000'000}))
      .default_text("the model's");
  command.add_option("--slack-us", args.slack_us, "Wait for late events: a tick closes this long after its end [us]")
      .check(in_range(std::int64_t{0}, std::int64_t{10'000'000}))
      .show_default();
  command.add_option("--duration", args.duration_s, "Stop after this time [s]").check(in_range(1e-3, 1e9)).type_name("S");
  command.add_option("--reconnect", args.reconnect_s, "If the connection breaks, try to reconnect for this long [s]")
      .check(in_range(0.0, 1e9))
      .type_name("S")
      .show_default();
}

void add_output_options(Command& command, DetectArguments& args) {
  command.add_option("--udp", args.udp, "Send a record at each tick to this address, HOST:PORT").type_name("ADDRESS");
  add_camera_time_option(command, args.camera_time);
  command.add_option("--ticks", args.ticks, "Write every tick to this CSV file").type_name("FILE.csv");
  add_page_option(command, "--page", args.page, "Show verdicts on a local page while it runs, at this port; 0 takes a free port");
  command.add_option("--plot", args.plot, "Draw probabilities, events and truth over time").type_name("FILE.png|FILE.svg");
  const Option record = command.add_flag("--record", args.record, "Also record the run, as 'record' does");
  command.add_option("--out", args.out, "With --record: folder of runs").type_name("DATA").needs(record).show_default();
  command.add_option("--object", args.object, "With --record: name of the object").needs(record).show_default();
  command.add_option("--run", args.run, "With --record: number of the run; default: the next free number")
      .type_name("NN")
      .needs(record);
}

void add_source_options(Command& command, DetectArguments& args) {
  command.add_option("--speed", args.source.speed, "Speed of files and the simulator: 1 is real time, 0 is as fast as possible")
      .check(in_range(0.0, 1e6))
      .show_default();
  command.add_option("--seed", args.source.seed, "Seed of the simulator").check(is_seed()).show_default();
  command.add_option("--stream", args.source.stream, "Event stream to use, if a file has several").type_name("ID|SOURCE");
  command.add_option("--readout-mode", args.source.readout_mode, "Read-out mode of the camera, such as variable-5000")
      .type_name("MODE");
}

void add_real_time_options(Command& command, DetectArguments& args) {
  command.add_flag("--verbose", args.verbose, "Print the time of each part of a tick, with its histogram");
  command.add_flag("--no-real-time", args.no_real_time,
                   "Do not use real-time priority and locked memory; default: used for live sources, where permitted");
  command.add_flag("--no-rehearsal", args.no_rehearsal,
                   "Do not run the network once before each tick; this saves processor time, but verdicts come later");
  command.add_flag("--awake", args.awake,
                   "Keep processor cores awake, where permitted; verdicts come sooner, but power use rises");
}

}  // namespace

void add_detect_command(CLI::App& app) {
  auto args = std::make_shared<DetectArguments>();
  Command command = add_command(
      app, "detect", "Detect press and slip live, every tick, and report them to a robot",
      [args](const CommonArguments& common) { detect(*args, common); }, CtrlC::is_the_end);
  add_model_options(command, *args);
  add_robot_options(command, args->robot);
  add_output_options(command, *args);
  add_source_options(command, *args);
  add_real_time_options(command, *args);
}

}  // namespace tactile::cli
