#include "tactile/capture/run_recorder.hpp"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <system_error>
#include <utility>

#include "tactile/capture/camera_streams.hpp"
#include "tactile/capture/packet_queue.hpp"
#include "tactile/capture/receiver.hpp"
#include "tactile/capture/recorded_stream.hpp"
#include "tactile/capture/run_writer.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/host_clock.hpp"
#include "tactile/core/run_files.hpp"
#include "tactile/core/version.hpp"
#include "tactile/events/packet_checksums.hpp"
#include "tactile/events/simulated_recording.hpp"

namespace tactile::capture {
namespace fs = std::filesystem;
namespace {

constexpr std::chrono::seconds straggler_patience{1};  // for the other streams after the events have ended

/// A run between `begin` and `end`.
struct OpenRun {
  RunRequest request;
  RunWriter writer;
  HostTime begun{};                    ///< once every source was ready
  std::optional<HostTime> film_ended;  ///< during the run
};

/// Contents of a recording.
struct HeldElements {
  std::uint64_t events = 0, imu_samples = 0, triggers = 0, frames = 0;
  std::optional<CameraTime> first, last, first_event, last_event;

  std::uint64_t others() const { return imu_samples + triggers + frames; }
};

HeldElements held_elements(const std::vector<events::WrittenStream>& written, const std::vector<events::Stream>& streams) {
  HeldElements held;
  for (std::size_t i = 0; i < written.size(); ++i) {
    const events::WrittenStream& stream = written[i];
    if (stream.elements == 0) continue;
    const events::StreamType type = streams[i].type;
    const bool of_events = type == events::StreamType::events;
    (of_events                              ? held.events
     : type == events::StreamType::imu      ? held.imu_samples
     : type == events::StreamType::triggers ? held.triggers
                                            : held.frames) += stream.elements;
    if (of_events) {
      held.first_event = std::min(held.first_event.value_or(stream.first), stream.first);
      held.last_event = std::max(held.last_event.value_or(stream.last), stream.last);
    }
    held.first = std::min(held.first.value_or(stream.first), stream.first);
    held.last = std::max(held.last.value_or(stream.last), stream.last);
  }
  return held;
}

std::uint64_t size_of(const fs::path& file) {
  std::error_code none;
  const std::uintmax_t size = fs::file_size(file, none);
  return none ? 0 : size;
}

nlohmann::json us_or_null(const std::optional<HostTime>& t) { return t ? nlohmann::json(us_of(*t)) : nlohmann::json(); }

/// Runs `step`. An exception becomes an error of the run, which is then not complete.
template <class Step>
void attempt(RunSummary& summary, const Step& step) {
  try {
    step();
  } catch (const std::exception& e) {
    summary.complete = false;
    summary.errors.emplace_back(e.what());
  }
}

}  // namespace

struct RunRecorder::State {
  RunRecorderOptions options;
  std::vector<RecordedStream> streams;
  std::vector<events::Stream> declared;
  bool is_simulated = false;
  PacketQueue queue;
  std::unique_ptr<robot::RobotMonitor> robot;
  std::shared_ptr<video::VideoCapture> video;
  std::vector<std::unique_ptr<Receiver>> receivers;
  std::vector<std::optional<HostTime>> reported_ends;  ///< of each source, the end that was logged
  std::unique_ptr<OpenRun> open;

  explicit State(RunRecorderOptions given) : options(std::move(given)), queue(options.queue_bytes) {}

  bool none_is_live() const {
    return std::none_of(receivers.begin(), receivers.end(), [](const auto& r) { return r->live(); });
  }
  std::function<void(const CameraPacket&)> sight_of(std::size_t source_index) const;
  std::string source_error() const;
  bool has_events(std::size_t source_index) const;
  bool sources_ended() const;
  void report_ended_sources();
  RunDrops drops(const RunWriter::Written& written) const;
  bool film_is_over() const { return video && !video->state().running; }

  std::unique_ptr<OpenRun> make_run(const RunRequest& request);
  RunInfo info(const RunRequest& request, HostTime begun) const;
  void close_files(const RunWriter::Written& written, RunSummary& summary) const;
  void count(const RunWriter::Written& written, RunSummary& summary) const;
  RunInfo final_info(const RunSummary& summary, HostTime ended, const nlohmann::json& files) const;
};

/// What is called with each packet of a source; empty: nothing.
std::function<void(const CameraPacket&)> RunRecorder::State::sight_of(std::size_t source_index) const {
  const RecordedStream& first = streams.front();  // events come first
  // The IMU of the same camera, which may be another source; else of any.
  const auto find_imu = [&](bool of_same_camera) {
    return std::find_if(streams.begin(), streams.end(), [&](const RecordedStream& stream) {
      return stream.stream.type == events::StreamType::imu && (!of_same_camera || stream.stream.source == first.stream.source);
    });
  };
  auto felt = find_imu(true);
  if (felt == streams.end()) felt = find_imu(false);
  std::optional<std::int32_t> events, imu;  // their ids in the source
  if (options.see_events && first.source_index == source_index) events = first.source_stream;
  if (options.see_imu && felt != streams.end() && felt->source_index == source_index) imu = felt->source_stream;
  if (!events && !imu) return {};
  return [this, events, imu](const CameraPacket& packet) {
    if (events == packet.stream_id && !packet.events.empty()) options.see_events(packet.events);
    if (imu == packet.stream_id && !packet.imu.empty()) options.see_imu(packet.imu);
  };
}

/// The first source that was lost.
std::string RunRecorder::State::source_error() const {
  for (const auto& receiver : receivers) {
    if (const std::string error = receiver->error(); !error.empty()) return "source gone: " + error;
  }
  return {};
}

bool RunRecorder::State::has_events(std::size_t source_index) const {
  return std::any_of(streams.begin(), streams.end(), [&](const RecordedStream& stream) {
    return stream.source_index == source_index && stream.stream.type == events::StreamType::events;
  });
}

/// Reports with a delay, because all sources may end at nearly the same time.
void RunRecorder::State::report_ended_sources() {
  if (!options.log || none_is_live()) return;
  bool events_go_on = false;
  for (std::size_t i = 0; i < receivers.size(); ++i) events_go_on = events_go_on || (has_events(i) && !receivers[i]->ended_at());
  if (!events_go_on) return;
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    const std::optional<HostTime> ended_at = receivers[i]->ended_at();
    if (!ended_at || ended_at == reported_ends[i] || host_now() - *ended_at < straggler_patience) continue;
    reported_ends[i] = ended_at;
    options.log(receivers[i]->name() + ": has ended, and the run continues without it");
  }
}

/// Whether all sources have ended, or the events have, and the others had time to end, too.
bool RunRecorder::State::sources_ended() const {
  bool all = true, events = true, time_is_up = true;
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    const auto ended_at = receivers[i]->ended_at();
    all = all && ended_at;
    if (!has_events(i)) continue;
    events = events && ended_at;
    time_is_up = time_is_up && ended_at && host_now() - *ended_at >= straggler_patience;
  }
  return all || (events && time_is_up && !none_is_live());
}

RunDrops RunRecorder::State::drops(const RunWriter::Written& written) const {
  RunDrops drops = written.drops;
  for (const auto& receiver : receivers) receiver->add_drops(drops);
  return drops;
}

/// Creates the run's recording, still empty.
std::unique_ptr<OpenRun> RunRecorder::State::make_run(const RunRequest& request) {
  const bool by_camera_time = none_is_live();
  const RunWriterOptions writer_options{.compression = options.compression,
                                        .sync_period = options.sync_period,
                                        .pairs_clocks = !by_camera_time,
                                        .duration = by_camera_time ? request.duration : std::nullopt};
  return std::unique_ptr<OpenRun>(new OpenRun{
      .request = request, .writer = {request.run.events(), streams, queue, writer_options}, .begun = {}, .film_ended = {}});
}

/// run.json at the beginning of a run.
RunInfo RunRecorder::State::info(const RunRequest& request, HostTime begun) const {
  nlohmann::json sources = nlohmann::json::array();
  nlohmann::json camera;
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    nlohmann::json of_source = receivers[i]->camera();
    if (streams.front().source_index == i) camera = of_source;
    sources.push_back({{"source", receivers[i]->name()}, {"camera", std::move(of_source)}, {"ended", nullptr}});
  }
  const events::SensorSize size = *declared.front().size;
  return {.object = request.run.object,
          .run = request.run.run,
          .session = request.session,
          .simulated = is_simulated,
          .complete = false,
          .width = size.width,
          .height = size.height,
          .extra = {{"camera", camera},
                    {"sources", sources},
                    {"software", {{"name", "tactile"}, {"version", version()}, {"revision", revision()}}},
                    {"settings", request.settings},
                    {"host_time_us", {{"begin", us_of(begun)}, {"end", nullptr}}}}};
}

RunRecorder::RunRecorder(std::vector<std::unique_ptr<CameraSource>> sources, std::unique_ptr<robot::RobotMonitor> robot,
                         std::unique_ptr<video::VideoCapture> video, RunRecorderOptions options)
    : state_(std::make_unique<State>(std::move(options))) {
  State& state = *state_;
  state.streams = recorded_streams(sources);
  for (const RecordedStream& stream : state.streams) state.declared.push_back(stream.stream);
  state.is_simulated = events::is_simulated(state.declared) ||
                       std::any_of(sources.begin(), sources.end(), [](const auto& source) { return source->simulated(); });
  state.robot = std::move(robot);
  state.video = std::move(video);
  for (std::size_t i = 0; i < sources.size(); ++i) {
    auto see = state.sight_of(i);
    state.receivers.push_back(std::make_unique<Receiver>(std::move(sources[i]), i, state.queue, std::move(see)));
  }
  state.reported_ends.resize(state.receivers.size());
}

RunRecorder::~RunRecorder() {
  try {
    if (state_->open) end("stopped");
  } catch (const std::exception&) {
    // A destructor cannot report an error. The recording is readable nevertheless.
  }
}

const std::vector<events::Stream>& RunRecorder::streams() const { return state_->declared; }
bool RunRecorder::simulated() const { return state_->is_simulated; }
std::vector<SourceState> RunRecorder::sources() const {
  std::vector<SourceState> all;
  for (const auto& receiver : state_->receivers)
    all.push_back({.name = receiver->name(),
                   .packets = receiver->packets(),
                   .has_ended = receiver->ended_at().has_value(),
                   .error = receiver->error()});
  return all;
}
const robot::RobotMonitor* RunRecorder::robot() const { return state_->robot.get(); }
std::shared_ptr<const video::VideoCapture> RunRecorder::video() const { return state_->video; }
void RunRecorder::discard() {
  for (const auto& receiver : state_->receivers) receiver->discard();
}

std::string RunRecorder::gone() const {
  const State& state = *state_;
  if (std::string error = state.source_error(); !error.empty()) return error;
  const bool again =
      std::any_of(state.receivers.begin(), state.receivers.end(), [](const auto& receiver) { return receiver->begins_again(); });
  return !again && state.sources_ended() ? "source ended" : "";
}

void RunRecorder::begin(const RunRequest& request) {
  State& state = *state_;
  if (state.open) throw Error(request.run.name() + ": a run is being recorded already; expected it to end first");
  std::error_code failed;
  if (!fs::is_empty(request.run.folder, failed) || failed) {
    throw Error(request.run.folder.string() + ": is not an empty folder; expected a new folder for this run");
  }
  state.queue.open();
  bool robot_logs = false, video_films = false;
  try {
    state.open = state.make_run(request);
    write_run_info(request.run, state.info(request, host_now()));
    if (state.robot) state.robot->start_log(request.run.robot());
    robot_logs = true;
    if (state.video) state.video->start_film(request.run.video(), request.run.video_times());
    video_films = true;
    state.open->writer.start();
    for (const auto& receiver : state.receivers) receiver->begin(request.run);
    // A source may take long to get ready, before the run. Therefore run.json has this time instead of the one above.
    state.open->begun = host_now();
  } catch (...) {
    for (const auto& receiver : state.receivers) receiver->pause();
    state.open.reset();
    try {
      if (state.robot && robot_logs) state.robot->stop_log();
      if (state.video && video_films) state.video->stop_film();
    } catch (const Error&) {
      // The files are removed.
    }
    std::error_code ignored;
    fs::remove_all(request.run.folder, ignored);
    throw;
  }
}

RunState RunRecorder::state() const {
  State& state = *state_;
  if (!state.open) return {};
  OpenRun& run = *state.open;
  state.report_ended_sources();
  const RunWriter::Written written = run.writer.written();
  RunState now{.elapsed = host_now() - run.begun,
               .events = written.events,
               .others = written.others,
               .bytes = size_of(run.request.run.events()),
               .queue_bytes = state.queue.waiting_bytes(),
               .drops = state.drops(written),
               .clock = written.clock,
               .lateness = written.lateness,
               .robot = {},
               .video = {},
               .ended = written.error};
  if (state.robot) now.robot = state.robot->state();
  if (state.video) now.video = state.video->state();
  if (!run.film_ended && state.film_is_over()) run.film_ended = host_now();
  if (now.ended.empty()) now.ended = state.source_error();
  const bool over =
      state.none_is_live() ? written.reached_duration : run.request.duration && now.elapsed >= *run.request.duration;
  if (now.ended.empty() && over) now.ended = "duration";
  if (now.ended.empty() && state.sources_ended()) now.ended = "source ended";
  return now;
}

RunSummary RunRecorder::end(const std::string& why) {
  State& state = *state_;
  if (!state.open) throw Error("run: none is being recorded; expected a run that has begun");
  OpenRun& run = *state.open;
  RunSummary summary;
  summary.run = run.request.run;
  summary.session = run.request.session;
  summary.simulated = state.is_simulated;
  summary.complete = true;  // until something fails

  for (const auto& receiver : state.receivers) receiver->pause();
  const HostTime ended = host_now();
  summary.elapsed = ended - run.begun;
  if (!run.film_ended && state.film_is_over()) run.film_ended = ended;
  run.writer.stop();
  const RunWriter::Written written = run.writer.written();
  state.close_files(written, summary);
  state.count(written, summary);

  nlohmann::json files = nlohmann::json::object();
  const fs::path checksums = events::checksums_beside(run.request.run.events());
  attempt(summary, [&] {
    std::vector<fs::path> made;
    for (const fs::directory_entry& entry : fs::directory_iterator(run.request.run.folder)) {
      if (!entry.is_regular_file() || entry.path() == run.request.run.info() || entry.path() == checksums) continue;
      made.push_back(entry.path());
      summary.bytes += size_of(entry.path());
    }
    files = files_json(made);
  });
  summary.ended = summary.errors.empty() ? why : summary.errors.front();
  // A replay may end before its last packets are written, and with them the duration.
  if (summary.errors.empty() && written.reached_duration) summary.ended = "duration";
  const RunInfo info = state.final_info(summary, ended, files);
  attempt(summary, [&] {
    write_run_info(run.request.run, info);
    // Now run.json on the disk has the hash of the recording.
    std::error_code stays;
    if (!files.empty()) fs::remove(checksums, stays);
  });
  state.open.reset();
  return summary;
}

/// Ends the recording, the robot's log, the film, and the files of the sources.
void RunRecorder::State::close_files(const RunWriter::Written& written, RunSummary& summary) const {
  if (!written.error.empty()) {
    summary.complete = false;
    summary.errors.push_back(written.error);
  }
  try {
    open->writer.close();
  } catch (const std::exception& e) {
    summary.complete = false;
    if (written.error.empty()) summary.errors.emplace_back(e.what());  // otherwise it is the same error
  }
  if (const std::string gone = source_error(); !gone.empty()) summary.errors.push_back(gone);
  if (robot) {
    attempt(summary, [&] { robot->stop_log(); });
    summary.robot = robot->state();
  }
  if (video) {
    attempt(summary, [&] { video->stop_film(); });
    summary.video = video->state();
  }
  for (const auto& receiver : receivers) attempt(summary, [&] { receiver->end(open->request.run, !robot, !video); });
}

/// Counts what the closed recording contains and lacks.
void RunRecorder::State::count(const RunWriter::Written& written, RunSummary& summary) const {
  const HeldElements held = held_elements(open->writer.file().written(), declared);
  summary.events = held.events;
  summary.others = held.others();
  summary.imu_samples = held.imu_samples;
  summary.triggers = held.triggers;
  summary.frames = held.frames;
  summary.drops = drops(written);
  // If writing failed, elements may have waited for the rest of their packet.
  summary.drops.unwritten.events += written.events - held.events;
  summary.drops.unwritten.others += written.others - held.others();
  if (held.first) summary.span = between(*held.first, *held.last);
  if (held.first_event) summary.events_span = between(*held.first_event, *held.last_event);
}

/// run.json at the end of a run.
RunInfo RunRecorder::State::final_info(const RunSummary& summary, HostTime ended, const nlohmann::json& files) const {
  RunInfo info = this->info(open->request, open->begun);
  info.complete = summary.complete;
  nlohmann::json& extra = info.extra;
  extra["host_time_us"]["end"] = us_of(ended);
  extra["dropped"] = json_of(summary.drops);
  extra["dropped"]["robot_gaps"] = summary.robot ? summary.robot->gaps : 0;
  extra["dropped"]["robot_packages"] = summary.robot ? summary.robot->missing : 0;
  extra["dropped"]["frames"] = summary.video ? summary.video->dropped : 0;
  if (summary.robot) {
    extra["robot"] = {
        {"controller", summary.robot->controller}, {"rows", summary.robot->rows}, {"reconnects", summary.robot->reconnects}};
  }
  if (summary.video) extra["video"] = {{"frames", summary.video->frames}, {"ended", us_or_null(open->film_ended)}};
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    const std::optional<HostTime> source_ended = receivers[i]->ended_at();
    if (source_ended && *source_ended < ended) extra["sources"][i]["ended"] = us_of(*source_ended);
  }
  extra["files"] = files;
  extra["ended"] = summary.ended;
  nlohmann::json& pairs = extra["host_from_camera"] = nlohmann::json::array();
  for (const ClockPair<CameraClock>& pair : open->writer.pairs().pairs()) pairs.push_back({us_of(pair.device), us_of(pair.host)});
  return info;
}

}  // namespace tactile::capture
