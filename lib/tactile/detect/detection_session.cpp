#include "tactile/detect/detection_session.hpp"

#include <fmt/core.h>
#include <sys/resource.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <thread>
#include <utility>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/host_clock.hpp"
#include "tactile/detect/event_feed.hpp"
#include "tactile/detect/fault_log.hpp"
#include "tactile/detect/real_time.hpp"
#include "tactile/detect/tick_log.hpp"
#include "tactile/detect/udp_records.hpp"

namespace tactile::detect {
namespace {

constexpr std::size_t waiting_bytes = std::size_t{64} << 20;  // of packets before the detector
constexpr std::size_t waiting_ticks = 16'384;                 // reported, and not yet with the caller
constexpr int detector_priority = 20, feed_priority = 21, robot_priority = 22;
constexpr std::chrono::milliseconds between_reads{10};
constexpr std::chrono::milliseconds between_live_reads{50};  // soon enough for a person; to wake up costs processor time

std::unique_ptr<capture::CameraSource> opened(const DetectionOptions& options) {
  std::unique_ptr<capture::CameraSource> source = capture::open_camera_source(options.source, options.source_options);
  if (const std::string remark = source->remark(); !remark.empty()) options.warn(fmt::format("{}: {}", options.source, remark));
  return source;
}

/// The model runs once, so that its memory is allocated before there are events.
std::unique_ptr<model::EventClassifier> opened(const OpenModel& open, events::SensorSize sensor) {
  std::unique_ptr<model::EventClassifier> model = open(sensor);
  model->prepare();
  model->classify();
  return model;
}

LiveDetectorOptions detector_options(const DetectionOptions& options, bool plays, std::optional<SceneWatch>& scene) {
  LiveDetectorOptions live;
  live.clock = {.tick = options.detector.rendering.tick,
                .history = options.detector.rendering.history,
                .slack = options.slack,
                .by_events_alone = plays};
  if (plays && options.duration) live.play_for = *options.duration;
  live.rehearses = options.rehearses;
  live.scene = scene ? &*scene : nullptr;
  return live;
}

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

}  // namespace

struct DetectionSession::State {
  DetectionOptions options;
  FaultLog faults;
  DetectionSummary summary;
  std::unique_ptr<capture::CameraSource> source;  ///< until the feed has it
  const bool plays, real_time;
  RealTimeRefusals refusals;
  std::unique_ptr<UdpRecords> udp;
  std::unique_ptr<RobotReporter> robot;
  TickLog ticks;
  std::vector<ReportedTick> read;
  std::optional<SessionRecording> recording;
  capture::PacketQueue queue{waiting_bytes};
  std::optional<SceneWatch> scene;
  LiveDetector detector;
  std::atomic<bool> is_over{false}, stops{false};

  State(DetectionOptions given, const OpenModel& open);
  void report(const ReportedTick& tick);
  void report(const DetectionFault& fault);
  void raise_priority(int priority) { refusals.add(use_real_time_priority(priority)); }
  void record();
  std::optional<SceneWatch>& watch_scene();
  EventFeedOptions feed_options();
  void pass_ticks_to(const TickOutput& output);
  bool wait(const TickOutput& output, HostTime begun);
  std::string why_ended(const EventFeed& feed, bool was_interrupted) const;
  void sum_up(const EventFeed& feed);
};

DetectionSession::State::State(DetectionOptions given, const OpenModel& open)
    : options(std::move(given)),
      source(opened(options)),
      plays(source->is_replay() || options.source_options.speed != 1),
      real_time(!plays && options.real_time),
      ticks(waiting_ticks, plays),
      detector(
          {opened(open, *events_of(*source).size), options.detector}, detector_options(options, plays, watch_scene()),
          [this](const ReportedTick& tick) { report(tick); }, [this](const DetectionFault& fault) { report(fault); },
          [this] {
            if (robot) robot->forget();
          }) {
  if (options.udp) udp = std::make_unique<UdpRecords>(*options.udp);
  if (options.robot) {
    std::function<void()> prepare;
    if (real_time) prepare = [] { use_real_time_priority(robot_priority); };
    robot = std::make_unique<RobotReporter>(
        *options.robot, [this](const DetectionFault& fault) { report(fault); }, std::move(prepare));
  }
  summary.source = options.source;
  summary.simulated = source->simulated();
  summary.plays = plays;
  summary.detector = options.detector;
  summary.used_real_time = real_time;
}

void DetectionSession::State::report(const DetectionFault& fault) {
  if (!fault.text.empty()) options.warn(fault.text);
  faults.add(fault);
}

void DetectionSession::State::report(const ReportedTick& tick) {
  if (udp && !udp->send(tick) && udp->failed() == 1) {
    const transport::NetworkAddress& to = *options.udp;
    report({"udp",
            fmt::format("--udp {}: a record could not be sent ({}); expected a program that listens there",
                        to.text().substr(std::strlen("tcp://")), std::strerror(errno)),
            host_now()});
  }
  if (robot) robot->report(tick);
  ticks.add(tick);
}

/// Called before there is a detector.
std::optional<SceneWatch>& DetectionSession::State::watch_scene() {
  if (!options.scene) return scene;
  scene.emplace(SceneWatchOptions{.sensor = *events_of(*source).size,
                                  .mask = options.detector.rendering.mask,
                                  .training = *options.scene,
                                  .at_once = plays,
                                  .pause = plays ? microseconds{0} : SceneWatchOptions{}.pause},
                [this](const characterise::SceneChange& change) {
                  report({change.leaves ? "scene" : "scene again", "scene: " + change.text, host_now()});
                });
  return scene;
}

void DetectionSession::State::record() {
  const nlohmann::json settings = {
      {"from", {options.source}}, {"speed", options.source_options.speed}, {"seed", options.source_options.seed}};
  recording.emplace(*options.record, *source, plays, settings, options.warn);
  options.inform("recording " + recording->run().folder.string());
}

EventFeedOptions DetectionSession::State::feed_options() {
  EventFeedOptions feed;
  feed.waits = plays;
  // What looks at each packet, such as a recording, must not delay the thread that reports ticks.
  feed.receives_ahead = plays || recording || options.see_events || !source->reports_arrivals();
  feed.fault = [this](const DetectionFault& fault) { report(fault); };
  feed.wakes = [this](const capture::CameraPacket& packet) { return detector.awaits(packet.events); };
  if (source->can_reopen()) feed.open = [this] { return capture::open_camera_source(options.source, options.source_options); };
  feed.reconnect = options.reconnect;
  if (recording || options.see_events) {
    feed.see = [this, stream = events_of(*source).id, has_ended = false](const capture::CameraPacket& packet) mutable {
      if (options.see_events && packet.stream_id == stream && !packet.events.empty()) options.see_events(packet.events);
      if (!recording || recording->put(packet) || std::exchange(has_ended, true)) return;
      report({"recording", "the camera's clock started again: the recording ends here, verdicts continue", host_now()});
    };
  }
  if (real_time) feed.prepare = [this] { raise_priority(feed_priority); };
  return feed;
}

void DetectionSession::State::pass_ticks_to(const TickOutput& output) {
  ticks.take(read);
  for (const ReportedTick& tick : read) {
    const EpisodeChange change = summary.verdicts.add(tick);
    if (change.ended) output.episode_end(*change.ended);
    if (change.begins) output.episode(tick);
    if (change.confirmed) output.confirmed(*change.confirmed);
  }
  output.ticks(read);
}

/// Passes ticks to the output until the detector ends or is to be stopped. @return  whether the output interrupted
bool DetectionSession::State::wait(const TickOutput& output, HostTime begun) {
  while (!is_over) {
    pass_ticks_to(output);
    if (scene && !plays) scene->look();
    if (output.interrupted()) return true;
    if (!plays && options.duration && host_now() - begun >= *options.duration) {
      summary.ended = "duration";
      return false;
    }
    std::this_thread::sleep_for(plays ? between_reads : between_live_reads);
  }
  return false;
}

std::string DetectionSession::State::why_ended(const EventFeed& feed, bool was_interrupted) const {
  const std::string gone = feed.error();
  if (was_interrupted) return "interrupted";
  const VerdictCounts& counts = summary.verdicts;
  const bool has_played_enough =
      plays && options.duration && counts.first_tick &&
      between(*counts.first_tick, *counts.last_tick) + options.detector.rendering.tick >= *options.duration;
  if (has_played_enough && gone.empty()) return "duration";
  if (summary.failure) return message_of(summary.failure);
  if (!summary.ended.empty()) return summary.ended;
  const std::string ended = gone.empty() ? "source ended" : gone;
  const auto tried = feed.gave_up_after();
  return tried ? fmt::format("{}; gave up after {:.1f} s", ended, in_s(*tried)) : ended;
}

void DetectionSession::State::sum_up(const EventFeed& feed) {
  if (recording) {
    summary.recorded = recording->end(summary.ended);
    for (const std::string& error : summary.recorded->errors) options.warn(error);
  }
  if (scene) {
    scene->finish();
    summary.scene = scene->summary();
  }
  summary.counts = detector.counts();
  summary.deadlines = detector.deadlines();
  summary.proposed_slack = detector.late_events().proposed_slack();
  summary.longest_packet = detector.clock().longest_packet();
  summary.drops = feed.drops();
  summary.reopened = feed.reopened();
  summary.real_time_refused = refusals.all();
  summary.ticks_left_out = ticks.left_out();
  if (robot) summary.robot = robot->summary();
  if (udp) summary.udp = {udp->sent(), udp->failed()};
  robot.reset();
  summary.faults = faults.kinds();
  summary.first_faults = faults.first();
}

DetectionSession::DetectionSession(DetectionOptions options, const OpenModel& open)
    : state_(std::make_unique<State>(std::move(options), open)) {}
DetectionSession::~DetectionSession() = default;

DetectionSummary DetectionSession::run(const TickOutput& output) {
  State& state = *state_;
  DetectionSummary& summary = state.summary;
  if (state.options.record) state.record();
  if (state.real_time) state.refusals.add(lock_memory());
  std::optional<AwakeProcessors> awake;
  if (state.options.awake) summary.awake_refused = awake.emplace().refused();
  EventFeedOptions feed_options = state.feed_options();
  EventFeed feed(std::move(state.source), state.queue, std::move(feed_options));

  const HostTime begun = host_now();
  const double cpu_begun = cpu_seconds();
  std::exception_ptr detector_failure, output_failure;
  feed.start();
  std::thread working([&] {
    if (state.real_time) state.raise_priority(detector_priority);
    try {
      state.detector.run(feed, [&] { return state.stops.load(); });
    } catch (...) {
      detector_failure = std::current_exception();
    }
    state.is_over = true;
  });
  bool was_interrupted = false;
  try {
    was_interrupted = state.wait(output, begun);
  } catch (...) {
    output_failure = std::current_exception();
  }
  state.stops = true;
  state.ticks.close();
  summary.elapsed = host_now() - begun;
  summary.cpu_s = cpu_seconds() - cpu_begun;
  feed.stop();
  working.join();
  try {
    if (!output_failure) {
      state.pass_ticks_to(output);
      if (const auto last = summary.verdicts.end()) output.episode_end(*last);
      output.end();
    }
  } catch (...) {
    output_failure = std::current_exception();
  }
  summary.failure = output_failure ? output_failure : detector_failure;
  summary.ended = state.why_ended(feed, was_interrupted);
  if (detector_failure) summary.failure = detector_failure;
  if (!summary.failure && !feed.error().empty()) summary.failure = std::make_exception_ptr(Error(feed.error()));
  state.sum_up(feed);
  return std::move(summary);
}

}  // namespace tactile::detect
