#include <fmt/core.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <exception>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "detect_plot.hpp"
#include "detect_report.hpp"
#include "interruption.hpp"
#include "live_line.hpp"
#include "model_arguments.hpp"
#include "openmp_threads.hpp"
#include "option_checks.hpp"
#include "record_runs.hpp"
#include "robot_teller.hpp"
#include "source_arguments.hpp"
#include "tactile/capture/camera_source.hpp"
#include "tactile/capture/new_run.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/host_clock.hpp"
#include "tactile/detect/event_feed.hpp"
#include "tactile/detect/live_detector.hpp"
#include "tactile/detect/real_time.hpp"
#include "tactile/detect/recorded_copy.hpp"
#include "tactile/detect/tick_log.hpp"
#include "tactile/detect/udp_records.hpp"
#include "tactile/heatmaps/run_heatmaps.hpp"
#include "tactile/model/inference/lenet_engine.hpp"
#include "tactile/model/training/open_classifier.hpp"
#include "tactile/report/gnuplot.hpp"
#include "tick_reader.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t waiting_bytes = std::size_t{64} << 20;  // of packets ahead of the detector
constexpr std::size_t waiting_ticks = 16'384;                 // told, and not yet shown or written
constexpr int detector_priority = 20, feed_priority = 21, robot_priority = 22;
constexpr const char* clock_began_anew = "the camera's clock began anew";
constexpr std::chrono::milliseconds between_readings{10};
constexpr std::chrono::milliseconds between_live_readings{50};  // soon enough for a person, and rarely: to wake up costs

struct DetectArguments {
  std::string model, models = "models";
  std::string from;
  double speed = 1;
  std::uint64_t seed = 1;
  std::string stream, readout_mode;
  double reconnect_s = 10, duration_s = 0;
  std::string engine = "fast", precision = "fp32";
  std::string confirm = "1/1";
  bool gate = false;
  std::int64_t slack_us = 2000;
  std::optional<std::int64_t> tick_us;
  std::string ticks, plot, udp;
  RobotArguments robot;
  bool no_real_time = false, no_rehearsal = false, awake = false;
  bool record = false;
  std::string out = "data", object = "unnamed", run;
};

ModelBundle chosen_model(const DetectArguments& args) {
  if (!args.model.empty()) {
    const fs::path given(args.model);
    if (fs::exists(given)) return {given.filename().empty() ? given.parent_path() : given};
    return {fs::path(args.models) / given};
  }
  const auto is_single_run = [](const ModelDescription& model) { return model.settings.split.kind == SplitKind::single_run; };
  auto found = newest_bundle(args.models, is_single_run);
  if (!found) found = newest_bundle(args.models, [](const ModelDescription&) { return true; });
  if (!found) throw Error(args.models + ": no model; expected one, run 'tactile train' first");
  return *found;
}

/// As `eval` does, before anything is told. @throws Error  if the file seems to hold too many ticks
void check_ticks_of(const DetectArguments& args, const HeatmapOptions& rendering) {
  const fs::path path = args.from.substr(5);
  if (!fs::exists(path)) return;  // who opens it says so
  const fs::path file = fs::is_directory(path) ? recording_in(path) : path;
  const RecordingReader reader(file);
  const std::string why = why_too_many(listed_ticks(reader, event_stream(reader, args.stream).id, rendering));
  if (!why.empty()) throw Error(file.string() + ": " + why);
}

/// What runs the network, for one thread.
ClassifyHeatmap network_of(const DetectArguments& args, const ModelBundle& bundle, const ModelDescription& model) {
  const EngineKind kind = engine_named(args.engine);
  const Precision precision = precision_named(args.precision);
  if (kind == EngineKind::fast) {
    const auto engine = std::make_shared<LeNetEngine>(model.input, read_bundle_weights(bundle, model), model.settings.network,
                                                      EngineOptions{.precision = precision});
    return [engine](std::span<const std::uint8_t> heatmap) { return engine->classify(heatmap); };
  }
  if (precision != Precision::fp32) throw Error("--precision int8: libtorch runs fp32 alone; expected --engine fast");
  const auto classifier = std::make_shared<const Classifier>(open_classifier(bundle.folder, 1, kind));
  return [classifier](std::span<const std::uint8_t> heatmap) { return classifier->classify(heatmap, 1).front(); };
}

/// The run's folder that a file source plays, where it is one.
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
      "--tick-us {}: the history t_h of {} is {} us, no whole number of such ticks; expected {}", tick_us, model, history.count(),
      below == above ? fmt::format("{} at most", below) : fmt::format("a tick such as {} or {}", below, above)));
}

/// A fault from whatever thread finds it: said, counted, and the first ones kept.
class Faults {
 public:
  explicit Faults(LiveLine& line) : line_(line) {}

  void add(const DetectionFault& fault) {
    if (!fault.text.empty()) line_.warn(fault.text);
    const std::scoped_lock lock(guard_);
    ++kinds_[fault.kind];
    if (first_.size() < most_faults_told && !fault.text.empty()) first_.push_back(fault);
  }
  void tell(DetectSummary& summary) const {
    const std::scoped_lock lock(guard_);
    summary.faults = kinds_;
    summary.first_faults = first_;
  }

 private:
  LiveLine& line_;
  mutable std::mutex guard_;
  std::map<std::string, std::uint64_t> kinds_;
  std::vector<DetectionFault> first_;
};

std::string message_of(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const std::exception& e) {
    return e.what();
  }
}

double cpu_seconds() {
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

/// The run that is recorded at the same time.
struct Recording {
  std::shared_ptr<RecordedCopy> copy;
  std::unique_ptr<RunRecorder> recorder;
  RunFolder run;
};

/// Its sources are a copy of this one.
Recording begin_recording(const DetectArguments& args, CameraSource& source, bool plays, LiveLine& line) {
  /// A recorder owns its sources; this one is fed by someone else too.
  struct Shared final : CameraSource {
    explicit Shared(std::shared_ptr<RecordedCopy> shared) : copy(std::move(shared)) {}
    std::string name() const override { return copy->name(); }
    std::span<const Stream> streams() const override { return copy->streams(); }
    bool simulated() const override { return copy->simulated(); }
    bool live() const override { return copy->live(); }
    nlohmann::json camera() const override { return copy->camera(); }
    Received receive(CameraPacket& packet, std::chrono::microseconds patience) override {
      return copy->receive(packet, patience);
    }
    SourceDrops drops() const override { return copy->drops(); }
    void begin_run(const RunFolder& run) override { copy->begin_run(run); }
    void end_run(const RunFolder& run, bool wants_robot, bool wants_video) override {
      copy->end_run(run, wants_robot, wants_video);
    }
    std::shared_ptr<RecordedCopy> copy;
  };
  Recording recording;
  recording.copy = std::make_shared<RecordedCopy>(source, plays);
  std::vector<std::unique_ptr<CameraSource>> sources;
  sources.push_back(std::make_unique<Shared>(recording.copy));
  recording.recorder = std::make_unique<RunRecorder>(
      std::move(sources), nullptr, nullptr, RunRecorderOptions{.log = [&line](const std::string& text) { line.warn(text); }});
  recording.run = make_run_folder(args.out, args.object, args.run);
  recording.recorder->begin({.run = recording.run,
                             .session = fmt::format("detect-{}", us_of(host_now())),
                             .duration = {},
                             .settings = {{"from", {args.from}}, {"speed", args.speed}, {"seed", args.seed}}});
  line.inform("recording " + recording.run.folder.string());
  return recording;
}

void detect(DetectArguments args, const CommonArguments& common) {
  let_openmp_threads_sleep();
  std::signal(SIGXFSZ, SIG_IGN);  // a limit on a file's size is a full disk: said
  const RobotBitsAskedFor asked = bits_asked_for(args.robot);
  if (!args.plot.empty()) check_is_picture(args.plot);
  std::optional<NetworkAddress> udp_address;
  if (!args.udp.empty()) {
    try {
      udp_address = network_address("tcp://" + args.udp);
    } catch (const Error&) {
      throw Error("--udp '" + args.udp + "': is no address; expected HOST:PORT with a port from 1 to 65535");
    }
  }
  const ModelBundle bundle = chosen_model(args);
  const ModelDescription model = read_description(bundle);
  LiveLine line(!common.quiet);
  Faults faults(line);
  DetectSummary summary;
  summary.model = bundle.name();
  summary.engine = args.engine;
  summary.precision = args.precision;
  summary.rendering = model.settings.rendering;
  check(summary.rendering);
  if (args.tick_us) summary.rendering.tick = tick_within(summary.rendering.history, *args.tick_us, bundle.name());
  summary.confirmation = confirmation_in(args.confirm);
  if (args.gate) summary.gate = gate_limit(bundle, model);
  line.inform("detecting by " + bundle.folder.string());

  if (args.from.empty()) args.from = usual_source("detect");
  const bool is_file = args.from.starts_with("file:");
  if (is_file && args.duration_s == 0) check_ticks_of(args, summary.rendering);
  const bool plays = is_file || args.speed != 1;
  const bool real_time = !plays && !args.no_real_time;
  summary.source = args.from;
  summary.plays = plays;
  const CameraSourceOptions source_options{
      .speed = args.speed, .seed = args.seed, .readout_mode = args.readout_mode, .stream = args.stream};
  // Before there are events, which would wait for it; and run once, so that its memory is there.
  ClassifyHeatmap network = network_of(args, bundle, model);
  const auto cells = static_cast<std::size_t>(model.input.width) * static_cast<std::size_t>(model.input.height);
  network(std::vector<std::uint8_t>(cells, 255));
  std::unique_ptr<CameraSource> source = open_camera_source(args.from, source_options);
  if (const std::string remark = source->remark(); !remark.empty()) line.warn(fmt::format("{}: {}", args.from, remark));
  summary.simulated = source->simulated();
  const SensorSize sensor = *events_of(*source).size;

  LiveDetectorOptions options;
  options.clock = {.tick = summary.rendering.tick,
                   .history = summary.rendering.history,
                   .slack = microseconds{args.slack_us},
                   .by_events_alone = plays};
  const microseconds duration{std::llround(1e6 * args.duration_s)};
  if (plays && args.duration_s > 0) options.play_for = duration;
  options.rehearses = !args.no_rehearsal;
  TickDetector tick_detector(sensor, model.input, std::move(network),
                             {.rendering = summary.rendering, .confirmation = summary.confirmation, .gate = summary.gate});

  std::unique_ptr<UdpRecords> udp;
  if (udp_address) udp = std::make_unique<UdpRecords>(*udp_address);
  const TellFault tell_fault = [&faults](const DetectionFault& fault) { faults.add(fault); };
  std::unique_ptr<RobotTeller> robot;
  if (!args.robot.host.empty()) {
    std::function<void()> prepare;
    if (real_time) prepare = [] { go_ahead_of_others(robot_priority); };
    robot = std::make_unique<RobotTeller>(args.robot, asked, tell_fault, std::move(prepare));
  }

  TickLog log(waiting_ticks, plays);
  TickReader reader({.csv = args.ticks, .keeps = !args.plot.empty(), .prints = !common.json}, line, summary);
  std::atomic<bool> is_over{false}, stops{false};
  const auto tell = [&](const ToldTick& tick) {
    if (udp && !udp->send(tick) && udp->failed() == 1)
      faults.add({"udp",
                  fmt::format("--udp {}: a record could not be sent ({}); expected a program that listens there", args.udp,
                              std::strerror(errno)),
                  host_now()});
    if (robot) robot->tell(tick);
    log.add(tick);
  };
  const auto detector = std::make_unique<LiveDetector>(std::move(tick_detector), options, tell, tell_fault, [&robot] {
    if (robot) robot->forget();
  });

  std::optional<Recording> recording;
  if (args.record) recording = begin_recording(args, *source, plays, line);

  PacketQueue queue(waiting_bytes);
  EventFeedOptions feed_options;
  feed_options.waits = plays;
  // What is recorded at the same time is copied ahead of a tick, and not by who tells it.
  feed_options.receives_ahead = plays || recording || !source->tells_arrivals();
  feed_options.fault = tell_fault;
  feed_options.wakes = [&detector](const CameraPacket& packet) { return detector->awaits(packet.events); };
  if (args.from.starts_with("tcp:") || args.from.starts_with("unix:") || args.from.starts_with("camera"))
    feed_options.open = [&args, source_options] { return open_camera_source(args.from, source_options); };
  feed_options.reconnect = std::chrono::milliseconds{std::llround(1000 * args.reconnect_s)};
  if (recording) {
    feed_options.see = [&, told = false](const CameraPacket& packet) mutable {
      recording->copy->put(packet);
      if (recording->copy->ended_early() && !std::exchange(told, true))
        faults.add({"recording", std::string(clock_began_anew) + ": the recording ends here, verdicts go on", host_now()});
    };
  }
  std::vector<std::string> refused;
  std::mutex refusing;
  const auto hurry = [&](int priority) {
    const std::string why = go_ahead_of_others(priority);
    const std::scoped_lock lock(refusing);
    if (!why.empty() && std::find(refused.begin(), refused.end(), why) == refused.end()) refused.push_back(why);
  };
  if (real_time) {
    feed_options.prepare = [&hurry] { hurry(feed_priority); };
    if (const std::string why = lock_memory(); !why.empty()) refused.push_back(why);
  }
  std::optional<AwakeProcessors> awake;
  if (args.awake) summary.may_sleep = awake.emplace().refused();
  summary.asked_for_real_time = real_time;
  EventFeed feed(std::move(source), queue, std::move(feed_options));

  const HostTime begun = host_now();
  const double cpu_begun = cpu_seconds();
  std::exception_ptr failure;
  feed.start();
  std::thread working([&] {
    if (real_time) hurry(detector_priority);
    try {
      detector->run(feed, [&] { return stops.load(); });
    } catch (...) {
      failure = std::current_exception();
    }
    is_over = true;
  });
  bool was_interrupted = false;
  std::exception_ptr cannot_write;
  while (!is_over) {
    try {
      reader.read(log);
    } catch (...) {
      cannot_write = std::current_exception();
      break;
    }
    was_interrupted = interrupted();
    const bool time_is_up = !plays && args.duration_s > 0 && host_now() - begun >= duration;
    if (time_is_up) summary.ended = "duration";
    if (was_interrupted || time_is_up) break;
    std::this_thread::sleep_for(plays ? between_readings : between_live_readings);
  }
  stops = true;
  log.close();
  summary.elapsed = host_now() - begun;
  summary.cpu_s = cpu_seconds() - cpu_begun;
  feed.stop();
  working.join();
  try {
    if (!cannot_write) reader.read(log), reader.end();
  } catch (...) {
    cannot_write = std::current_exception();
  }
  line.clear();

  const std::string gone = feed.error();
  const bool by_duration = plays && args.duration_s > 0 && summary.first_tick && !was_interrupted && gone.empty() &&
                           summary.last_tick && between(*summary.first_tick, *summary.last_tick) + options.clock.tick >= duration;
  if (failure) summary.ended = message_of(failure);
  if (cannot_write) summary.ended = message_of(cannot_write);
  if (was_interrupted) summary.ended = "interrupted";
  if (by_duration) summary.ended = "duration";
  if (summary.ended.empty()) {
    summary.ended = gone.empty() ? "source ended" : gone;
    if (const auto tried = feed.gave_up_after())
      summary.ended += fmt::format("; gave up after {:.1f} s", 1e-6 * static_cast<double>(tried->count()));
  }
  if (recording) {
    recording->copy->end();
    // What waits between us and the recorder is still to come to it.
    for (int i = 0; i < 6'000 && recording->recorder->state().ended.empty(); ++i) std::this_thread::sleep_for(10ms);
    summary.recorded = recording->recorder->end(recording->copy->ended_early() ? clock_began_anew : summary.ended);
    for (const std::string& error : summary.recorded->errors) line.warn(error);
  }
  summary.counts = detector->counts();
  summary.deadlines = detector->deadlines();
  summary.longest_packet = detector->clock().longest_packet();
  summary.drops = feed.drops();
  summary.reopened = feed.reopened();
  summary.real_time = refused;
  summary.ticks_left_out = log.left_out() + reader.not_kept();
  if (robot) summary.robot = robot->summary();
  if (udp) summary.udp = {udp->sent(), udp->failed()};
  robot.reset();
  faults.tell(summary);

  std::string drawn;
  if (!args.plot.empty() && !reader.kept().empty()) {
    std::optional<RunFolder> run = played_run(args.from);
    if (recording && fs::exists(recording->run.truth())) run = recording->run;
    draw_told_ticks(reader.kept(), summary.rendering,
                    fmt::format("{}{} as {} sees it", args.from, summary.simulated ? " (simulated)" : "", summary.model), run,
                    args.plot);
    const bool began_anew = reader.kept().front().beginning != reader.kept().back().beginning;
    drawn = fmt::format("\nDrawn in {}{}\n", args.plot,
                        began_anew ? ": the ticks since the stream last began anew; --ticks FILE.csv writes all" : "");
  }
  print_result(common, json_of(summary), (common.json ? "" : "\n") + text_of(summary) + drawn);
  if (failure) std::rethrow_exception(failure);
  if (cannot_write) std::rethrow_exception(cannot_write);
  if (!gone.empty()) throw Error(gone);
  if (!args.plot.empty() && reader.kept().empty())
    throw Error(args.plot + ": there is no tick to draw; expected a stream longer than the history");
}

}  // namespace

void add_detect_command(CLI::App& app) {
  auto args = std::make_shared<DetectArguments>();
  Command command = add_command(
      app, "detect", "Detect press and slip live, every tick, and report them to a robot",
      [args](const CommonArguments& common) { detect(*args, common); }, CtrlC::is_the_end);
  command.add_option("--model", args->model, "Model: a folder, or a name in --models; default: the newest single-run model");
  command.add_option("--models", args->models, "Folder of models").show_default();
  command.add_option("--from", args->from, "Event source: tcp://HOST:PORT, unix:PATH, file:PATH, sim[:OBJECT] or camera[:SERIAL]")
      .type_name("SOURCE");
  command
      .add_option("--confirm", args->confirm,
                  "k/n: report a class only if it was predicted in at least k of the last n ticks; k > n/2")
      .check(is_confirmation())
      .show_default();
  command.add_flag("--gate", args->gate,
                   "Report none without running the network while there are fewer events than the model's limit");
  add_engine_option(command, args->engine);
  command.add_option("--precision", args->precision, "Precision of the fast engine's largest layer")
      .check(one_of({"fp32", "int8"}))
      .show_default();
  command.add_option("--tick-us", args->tick_us, "Time between two verdicts [us]; t_h must be a whole number of them")
      .check(in_range(std::int64_t{1}, std::int64_t{1'000'000}))
      .default_text("the model's");
  command.add_option("--slack-us", args->slack_us, "Wait for late events: a tick closes this long after its end [us]")
      .check(in_range(std::int64_t{0}, std::int64_t{10'000'000}))
      .show_default();
  command.add_option("--duration", args->duration_s, "Stop after this time [s]").check(in_range(1e-3, 1e9)).type_name("S");
  command.add_option("--reconnect", args->reconnect_s, "Try to reconnect for this long after a connection broke [s]")
      .check(in_range(0.0, 1e9))
      .type_name("S")
      .show_default();
  command.add_option("--robot", args->robot.host, "UR controller to report to").type_name("HOST[:PORT]");
  const Check is_bit = in_range(64, 127);
  command.add_option("--bit", args->robot.bit, "Input bit register to set at press and at slip").check(is_bit).type_name("N");
  command.add_option("--press-bit", args->robot.press_bit, "Input bit register to set at press only")
      .check(is_bit)
      .type_name("N");
  command.add_option("--slip-bit", args->robot.slip_bit, "Input bit register to set at slip only").check(is_bit).type_name("N");
  const Option latch = command.add_flag("--latch", args->robot.latch, "Keep a bit high until the end once it is set");
  command.add_option("--clear-ms", args->robot.clear_ms, "Clear a bit this long after the last tick that set it [ms]")
      .check(in_range(0.0, 1e6))
      .excludes(latch)
      .default_text("0");
  command.add_option("--udp", args->udp, "Send a record to HOST:PORT at each tick").type_name("ADDRESS");
  command.add_option("--ticks", args->ticks, "Write every tick to this CSV file").type_name("FILE.csv");
  command.add_option("--plot", args->plot, "Draw probabilities, events and truth over time").type_name("FILE.png|FILE.svg");
  const Option record = command.add_flag("--record", args->record, "Also record the run, as 'record' does");
  command.add_option("--out", args->out, "With --record: folder of runs").needs(record).show_default();
  command.add_option("--object", args->object, "With --record: name of the object").needs(record).show_default();
  command.add_option("--run", args->run, "With --record: number of the run; default: the next free number").needs(record);
  command.add_option("--speed", args->speed, "Speed of files and the simulator: 1 is real time, 0 is as fast as possible")
      .check(in_range(0.0, 1e6))
      .show_default();
  command.add_option("--seed", args->seed, "Seed of the simulator").check(is_seed()).show_default();
  command.add_option("--stream", args->stream, "Event stream to use, if a file has several").type_name("ID|SOURCE");
  command.add_option("--readout-mode", args->readout_mode, "Read-out mode of the camera, such as variable-5000")
      .type_name("MODE");
  command.add_flag("--no-real-time", args->no_real_time,
                   "Do not use real-time priority and locked memory (default for live sources, where permitted)");
  command.add_flag("--no-rehearsal", args->no_rehearsal,
                   "Do not run the network once before each tick; this saves processor time, but verdicts come later");
  command.add_flag("--awake", args->awake,
                   "Keep processor cores awake, where permitted; verdicts come sooner, but power use rises");
}

}  // namespace tactile
