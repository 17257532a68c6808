#include "tactile/capture/run_recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <future>
#include <mutex>
#include <system_error>
#include <thread>
#include <tuple>
#include <utility>

#include "tactile/capture/clock_pairs.hpp"
#include "tactile/capture/packet_queue.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/host_clock.hpp"
#include "tactile/core/run_files.hpp"
#include "tactile/core/version.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/event_checks.hpp"
#include "tactile/events/packet_compression.hpp"
#include "tactile/events/packet_contents.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile {
namespace fs = std::filesystem;
namespace {

using Steady = std::chrono::steady_clock;

constexpr std::chrono::milliseconds source_patience{50};  ///< within it a source's thread sees what it is asked to do
constexpr std::chrono::seconds straggler_patience{1};     ///< for the other streams once the events have ended
constexpr std::uint64_t kept_in_memory = std::uint64_t{512}
                                         << 20;  ///< of the recording, by the system: whole runs of a usual length [B]

/// One stream of the recording, and where it comes from.
struct FileStream {
  Stream stream;
  std::size_t source_index = 0;
  std::int32_t source_stream = 0;
  bool begun = false;  ///< in the present run
  CameraTime newest{};
};

int rank_of(StreamType type) {
  constexpr std::array ranks{StreamType::events, StreamType::imu, StreamType::triggers, StreamType::frames};
  return static_cast<int>(std::find(ranks.begin(), ranks.end(), type) - ranks.begin());
}

/// The streams of all sources under ids of their own, what a recording must declare filled in.
std::vector<FileStream> streams_of(const std::vector<std::unique_ptr<CameraSource>>& sources) {
  std::vector<FileStream> all;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    for (const Stream& stream : sources[i]->streams()) {
      if (stream.type == StreamType::other) continue;
      const auto twice = std::find_if(all.begin(), all.end(), [&](const FileStream& other) {
        return other.source_index != i && other.stream.type == stream.type && other.stream.source == stream.source;
      });
      if (twice != all.end()) {
        throw Error(fmt::format("{}: has the {} of the camera '{}', which {} has too; expected each stream once",
                                sources[i]->name(), name_of(stream.type), stream.source, sources[twice->source_index]->name()));
      }
      all.push_back({.stream = stream, .source_index = i, .source_stream = stream.id, .begun = false, .newest = {}});
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const FileStream& a, const FileStream& b) { return rank_of(a.stream.type) < rank_of(b.stream.type); });
  if (all.empty() || all.front().stream.type != StreamType::events || !all.front().stream.size) {
    throw Error(fmt::format("{}: brings no events of a sensor of known size; expected a source that does",
                            sources.empty() ? "no source" : sources.front()->name()));
  }
  const Stream& events = all.front().stream;
  for (std::size_t i = 0; i < all.size(); ++i) {
    Stream& stream = all[i].stream;
    stream.id = static_cast<std::int32_t>(i);
    stream.type_identifier.clear();
    if (stream.name.empty()) stream.name = name_of(stream.type);
    if (stream.source.empty()) stream.source = events.source.empty() ? "camera" : events.source;
    if (stream.type == StreamType::frames && !stream.size) stream.size = events.size;
  }
  return all;
}

bool is_sound(const Frame& frame) {
  const std::size_t pixel = bytes_per_pixel(frame.format);
  if (pixel == 0 || frame.width < 0 || frame.height < 0) return false;
  const std::size_t size = pixel * static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.height);
  return frame.pixels.size() == size && size <= packet_limit - 4096;
}

/// Leaves out what is earlier than what came before it; returns how many.
template <class Element>
std::uint64_t leave_out_steps_back(std::vector<Element>& elements, CameraTime newest) {
  return static_cast<std::uint64_t>(std::erase_if(elements, [&](const Element& e) {
    if (e.t < newest) return true;
    newest = e.t;
    return false;
  }));
}

template <class Element>
void cut_at(std::vector<Element>& elements, CameraTime limit) {
  elements.erase(std::partition_point(elements.begin(), elements.end(), [&](const Element& e) { return e.t < limit; }),
                 elements.end());
}

nlohmann::json json_of(const LostElements& lost) {
  return {{"packets", lost.packets}, {"events", lost.events}, {"others", lost.others}};
}

/// What a recording holds.
struct HeldElements {
  std::uint64_t events = 0, imu_samples = 0, triggers = 0, frames = 0;
  std::optional<CameraTime> first, last, first_event, last_event;

  std::uint64_t others() const { return imu_samples + triggers + frames; }
};

HeldElements held_elements(const std::vector<WrittenStream>& written, const std::vector<Stream>& streams) {
  HeldElements held;
  for (std::size_t i = 0; i < written.size(); ++i) {
    const WrittenStream& stream = written[i];
    if (stream.elements == 0) continue;
    const StreamType type = streams[i].type;
    const bool of_events = type == StreamType::events;
    (of_events                      ? held.events
     : type == StreamType::imu      ? held.imu_samples
     : type == StreamType::triggers ? held.triggers
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

/// A source and the thread that receives from it, which does all that is asked of the source.
class Receiver {
 public:
  /// What comes while a run is open goes to `queue`.
  Receiver(std::unique_ptr<CameraSource> camera, std::size_t index, PacketQueue& queue)
      : source(std::move(camera)), index_(index), live_(source->live()), queue_(queue), thread_([this] { receive_all(); }) {}
  ~Receiver() {
    {
      const std::scoped_lock lock(guard_);
      stops_ = true;
    }
    wake_.notify_all();
    thread_.join();
  }
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

  /// Does `task` on the source's thread, between two packets. @throws what it throws
  void ask(std::function<void()> task) {
    std::packaged_task<void()> asked(std::move(task));
    std::future<void> done = asked.get_future();
    {
      const std::scoped_lock lock(guard_);
      task_ = std::move(asked);
      has_task_ = true;
    }
    wake_.notify_all();
    done.get();
  }

  void begin(const RunFolder& run) {
    ask([&] {
      source->begin_run(run);
      const std::scoped_lock lock(guard_);
      if (error_.empty() && source->begins_again()) ended_at_.reset();
      queue_full_ = {};
      drops_at_begin_ = drops_now_ = source->drops();
      hands_over_ = true;
    });
  }
  void pause() {
    discards_ = true;
    hands_over_ = false;
  }
  void discard() {
    ask([this] { discards_ = true; });
  }
  nlohmann::json camera() {
    nlohmann::json camera;
    ask([&] { camera = source->camera(); });
    return camera;
  }

  bool live() const { return live_; }
  std::optional<HostTime> ended_at() const {
    const std::scoped_lock lock(guard_);
    return ended_at_;
  }
  std::string error() const {  ///< why it is gone
    const std::scoped_lock lock(guard_);
    return error_;
  }
  void add_drops(RunDrops& drops) const {
    const std::scoped_lock lock(guard_);
    drops.queue_full += queue_full_;
    const LostElements back_in_time = drops_now_.back_in_time - drops_at_begin_.back_in_time;
    drops.back_in_time += back_in_time;
    drops.source += drops_now_.total() - drops_at_begin_.total() - back_in_time;
  }

  const std::unique_ptr<CameraSource> source;
  std::optional<HostTime> told_end;  ///< which of its ends was logged; the recorder's, not this thread's

 private:
  /// Before it is asked for anything a source keeps what it has; between two runs only one that can.
  bool rests() const { return !hands_over_ && !(live_ && discards_); }
  void receive_all();
  bool do_what_is_asked();
  void hand_over(PacketQueue::Packet& packet);
  void note_end(const std::string& error) {
    const std::scoped_lock lock(guard_);
    ended_at_ = host_now();
    error_ = error;
  }
  void note_drops() {
    const SourceDrops drops = source->drops();
    if (drops == drops_now_) return;  // only this thread changes it
    const std::scoped_lock lock(guard_);
    drops_now_ = drops;
  }

  std::size_t index_;
  bool live_;
  PacketQueue& queue_;
  std::atomic<bool> hands_over_{false}, discards_{false};
  mutable std::mutex guard_;
  std::condition_variable wake_;
  std::packaged_task<void()> task_;
  bool has_task_ = false, stops_ = false;
  std::optional<HostTime> ended_at_;
  std::string error_;
  LostElements queue_full_;
  SourceDrops drops_at_begin_, drops_now_;
  std::thread thread_;
};

/// False once the thread shall end. Without anything to receive it waits to be asked.
bool Receiver::do_what_is_asked() {
  std::unique_lock lock(guard_);
  if (ended_at_ || rests()) wake_.wait(lock, [this] { return stops_ || has_task_; });
  if (has_task_) {
    std::packaged_task<void()> task = std::move(task_);
    has_task_ = false;
    lock.unlock();
    task();
    lock.lock();
  }
  return !stops_;
}

void Receiver::receive_all() {
  PacketQueue::Packet packet = queue_.take();
  while (do_what_is_asked()) {
    if (ended_at() || rests()) continue;
    CameraPacket& elements = packet.front().elements;
    elements.clear();
    const bool of_run = hands_over_;  // what is lost until a run's end is the run's, although that may come while we wait
    try {
      switch (source->receive(elements, source_patience)) {
        case CameraSource::Received::packet:
          if (hands_over_) hand_over(packet);
          break;
        case CameraSource::Received::nothing:
          break;
        case CameraSource::Received::ended:
          note_end("");
          break;
      }
    } catch (const std::exception& e) {
      note_end(e.what());
    }
    if (of_run) note_drops();
  }
}

void Receiver::hand_over(PacketQueue::Packet& packet) {
  packet.front().source_index = index_;
  packet.front().arrived = host_now();
  const LostElements count = count_of(packet.front().elements);
  const bool taken = queue_.push(packet, !live_);
  if (taken) packet = queue_.take();
  if (taken || !hands_over_) return;
  const std::scoped_lock lock(guard_);
  queue_full_ += count;
}

/// A run between `begin` and `end`.
struct OpenRun {
  OpenRun(const RunRequest& asked, std::vector<FileStream> to_write, const std::vector<Stream>& declared,
          const RunRecorderOptions& options, PacketQueue& packets)
      : request(asked),
        streams(std::move(to_write)),
        queue(packets),
        period(options.sync_period),
        writer(request.run.events(), declared, {.compression = options.compression}) {}
  ~OpenRun() { stop(); }
  OpenRun(const OpenRun&) = delete;
  OpenRun& operator=(const OpenRun&) = delete;

  /// What the writing thread has done so far.
  struct Written {
    std::uint64_t events = 0, others = 0;  ///< handed to the file
    RunDrops drops;                        ///< those that it found
    std::optional<CameraTime> first;       ///< of the first packet, which a duration counts from
    bool reached_duration = false;
    std::string error;  ///< why the file cannot be written any more
  };

  void start() {
    writing = std::thread([this] { write_all(); });
    syncing = std::thread([this] { sync_all(); });
  }
  void stop();  ///< once what the queue still holds is written
  Written written() const {
    const std::scoped_lock lock(guard);
    return so_far;
  }

  void write_all();
  void write_packet(QueuedPacket& packet);
  void leave_out_misfits(FileStream& stream, CameraPacket& packet, RunDrops& drops) const;
  bool cut_to_duration(CameraPacket& packet, const std::optional<CameraTime>& first) const;
  void fail(const std::string& error) {
    const std::scoped_lock lock(guard);
    if (so_far.error.empty()) so_far.error = error;
  }
  void sync_all();

  RunRequest request;
  std::vector<FileStream> streams;
  PacketQueue& queue;
  std::chrono::milliseconds period;
  RecordingWriter writer;
  bool by_camera_time = false;  ///< whose clock the duration is measured by
  HostTime begun{};
  Steady::time_point begun_steady = Steady::now();
  std::optional<HostTime> film_ended;  ///< while the run went on
  ClockPairs pairs;                    ///< the writing thread's until that has ended
  mutable std::mutex guard;
  Written so_far;
  std::condition_variable sync_wanted;
  bool wants_sync = false, ends = false;
  std::thread writing, syncing;
};

void OpenRun::stop() {
  queue.close();
  if (writing.joinable()) writing.join();
  {
    const std::scoped_lock lock(guard);
    ends = true;
  }
  sync_wanted.notify_all();
  if (syncing.joinable()) syncing.join();
}

void OpenRun::write_all() {
  Steady::time_point next_sync = Steady::now() + period;
  bool failed = false;
  PacketQueue::Packet packet;
  const auto attempt = [&](const auto& step) {
    try {
      step();
    } catch (const std::exception& e) {
      failed = true;
      fail(e.what());
    }
  };
  while (queue.pop(packet, source_patience)) {
    if (!packet.empty()) {
      if (!failed) attempt([&] { write_packet(packet.front()); });
      if (failed) {
        const std::scoped_lock lock(guard);
        so_far.drops.unwritten += count_of(packet.front().elements);
      }
      queue.give_back(std::move(packet));
      packet.clear();
    }
    if (Steady::now() < next_sync || failed) continue;
    next_sync = Steady::now() + period;
    attempt([&] { writer.write_waiting(); });
    {
      const std::scoped_lock lock(guard);
      wants_sync = true;
    }
    sync_wanted.notify_all();
  }
}

/// Apart from the writing, for it may take as long as the disk pleases.
void OpenRun::sync_all() {
  std::unique_lock lock(guard);
  for (;;) {
    sync_wanted.wait(lock, [this] { return wants_sync || ends; });
    if (ends) return;
    wants_sync = false;
    lock.unlock();
    try {
      sync_to_disk(request.run.events());
      // The pages of a long recording are used again for what follows: new ones cost more, and others need the memory too.
      release_memory_of(request.run.events(), kept_in_memory);
    } catch (const std::exception& e) {
      fail(e.what());
    }
    lock.lock();
  }
}

void OpenRun::leave_out_misfits(FileStream& stream, CameraPacket& packet, RunDrops& drops) const {
  const CameraTime newest = stream.begun ? stream.newest : CameraTime::min();
  switch (stream.stream.type) {
    case StreamType::events: {
      const SensorSize size = *stream.stream.size;
      const EventsCheck check = check_events(packet.events, size);
      const bool goes_on = packet.events.empty() || packet.events.front().t >= newest;
      if (check.inside && check.ascending && goes_on) break;
      drops.outside.events +=
          static_cast<std::uint64_t>(std::erase_if(packet.events, [size](const Event& e) { return is_outside(e, size); }));
      drops.back_in_time.events += leave_out_steps_back(packet.events, newest);
      break;
    }
    case StreamType::imu:
      drops.back_in_time.others += leave_out_steps_back(packet.imu, newest);
      break;
    case StreamType::triggers:
      drops.back_in_time.others += leave_out_steps_back(packet.triggers, newest);
      break;
    default:
      if (!packet.frame) break;
      if (!is_sound(*packet.frame)) {
        ++drops.outside.others;
        packet.frame.reset();
      } else if (packet.frame->t < newest) {
        ++drops.back_in_time.others;
        packet.frame.reset();
      }
      break;
  }
}

/// Leaves out what comes after the run's duration; true if that is over.
bool OpenRun::cut_to_duration(CameraPacket& packet, const std::optional<CameraTime>& first) const {
  if (!by_camera_time || !request.duration || !first) return false;
  const CameraTime limit = after(*first, *request.duration);
  const LostElements before_cut = count_of(packet);
  cut_at(packet.events, limit);
  cut_at(packet.imu, limit);
  cut_at(packet.triggers, limit);
  if (packet.frame && packet.frame->t >= limit) packet.frame.reset();
  const LostElements left = count_of(packet);
  return left.events < before_cut.events || left.others < before_cut.others;
}

void OpenRun::write_packet(QueuedPacket& queued) {
  CameraPacket& packet = queued.elements;
  const auto found = std::find_if(streams.begin(), streams.end(), [&](const FileStream& s) {
    return s.source_index == queued.source_index && s.source_stream == packet.stream_id;
  });
  if (found == streams.end()) {
    const std::scoped_lock lock(guard);
    so_far.drops.outside += count_of(packet);
    return;
  }
  const LostElements came = count_of(packet);
  RunDrops drops;
  leave_out_misfits(*found, packet, drops);
  std::optional<CameraTime> first = so_far.first;  // only this thread changes it
  CameraTime packet_first{}, packet_last{};
  const auto span_of = [&](const auto& elements) {
    if (elements.empty()) return false;
    packet_first = elements.front().t;
    packet_last = elements.back().t;
    return true;
  };
  const auto find_span = [&] {
    switch (found->stream.type) {
      case StreamType::events:
        return span_of(packet.events);
      case StreamType::imu:
        return span_of(packet.imu);
      case StreamType::triggers:
        return span_of(packet.triggers);
      default:
        if (packet.frame) packet_first = packet_last = packet.frame->t;
        return packet.frame.has_value();
    }
  };
  bool any = find_span();
  if (any && !first) first = packet_first;
  const bool reached_duration = cut_to_duration(packet, first);
  any = find_span();
  {
    const std::scoped_lock lock(guard);
    if (!any && !reached_duration) {
      if (drops.back_in_time.events + drops.back_in_time.others > 0) {
        ++drops.back_in_time.packets;
      } else if (came.events + came.others > 0) {
        ++drops.outside.packets;
      }
    }
    so_far.drops.back_in_time += drops.back_in_time;
    so_far.drops.outside += drops.outside;
    so_far.first = first;
  }

  if (any) {
    switch (found->stream.type) {
      case StreamType::events:
        writer.write_events(found->stream.id, packet.events);
        break;
      case StreamType::imu:
        writer.write_imu(found->stream.id, packet.imu);
        break;
      case StreamType::triggers:
        writer.write_triggers(found->stream.id, packet.triggers);
        break;
      default:
        writer.write_frame(found->stream.id, *packet.frame);
        break;
    }
    found->begun = true;
    found->newest = packet_last;
    if (!by_camera_time && found->stream.source == streams.front().stream.source) pairs.add(packet_last, queued.arrived);
  }

  const LostElements left = count_of(packet);
  const std::scoped_lock lock(guard);
  so_far.events += left.events;
  so_far.others += left.others;
  so_far.reached_duration = so_far.reached_duration || reached_duration;
}

}  // namespace

LostElements RunDrops::total() const {
  LostElements sum;
  for (const LostElements& part : {queue_full, back_in_time, outside, unwritten, source}) sum += part;
  return sum;
}

nlohmann::json json_of(const RunDrops& drops) {
  const LostElements total = drops.total();
  return {{"packets", total.packets},
          {"events", total.events},
          {"others", total.others},
          {"by_reason",
           {{"queue_full", json_of(drops.queue_full)},
            {"back_in_time", json_of(drops.back_in_time)},
            {"outside", json_of(drops.outside)},
            {"unwritten", json_of(drops.unwritten)},
            {"source", json_of(drops.source)}}}};
}

struct RunRecorder::State {
  RunRecorderOptions options;
  std::vector<FileStream> file_streams;
  std::vector<Stream> declared;
  bool is_simulated = false;
  PacketQueue queue;
  std::unique_ptr<RobotMonitor> robot;
  std::unique_ptr<VideoCapture> video;
  std::vector<std::unique_ptr<Receiver>> receivers;
  std::unique_ptr<OpenRun> open;

  explicit State(const RunRecorderOptions& given) : options(given), queue(options.queue_bytes) {}

  bool none_is_live() const {
    return std::none_of(receivers.begin(), receivers.end(), [](const auto& r) { return r->live(); });
  }
  std::string source_error() const;
  bool has_events(std::size_t source_index) const;
  bool sources_ended() const;
  void tell_of_ended_sources() const;
  RunDrops drops(const OpenRun::Written& written) const;
  RunInfo info(bool complete) const;
};

/// The first of the sources that are gone.
std::string RunRecorder::State::source_error() const {
  for (const auto& receiver : receivers) {
    if (const std::string error = receiver->error(); !error.empty()) return "source gone: " + error;
  }
  return {};
}

bool RunRecorder::State::has_events(std::size_t source_index) const {
  return std::any_of(file_streams.begin(), file_streams.end(), [&](const FileStream& stream) {
    return stream.source_index == source_index && stream.stream.type == StreamType::events;
  });
}

/// Not at once, for where all end at the same time one is the first to do so.
void RunRecorder::State::tell_of_ended_sources() const {
  if (!options.log || none_is_live()) return;
  bool events_go_on = false;
  for (std::size_t i = 0; i < receivers.size(); ++i) events_go_on = events_go_on || (has_events(i) && !receivers[i]->ended_at());
  if (!events_go_on) return;
  for (const auto& receiver : receivers) {
    const std::optional<HostTime> ended_at = receiver->ended_at();
    if (!ended_at || ended_at == receiver->told_end || host_now() - *ended_at < straggler_patience) continue;
    receiver->told_end = ended_at;
    options.log(receiver->source->name() + ": has ended, and the run goes on without it");
  }
}

/// Whether nothing comes any more, or no events and the others have had their time to end too.
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

RunDrops RunRecorder::State::drops(const OpenRun::Written& written) const {
  RunDrops drops = written.drops;
  for (const auto& receiver : receivers) receiver->add_drops(drops);
  return drops;
}

RunInfo RunRecorder::State::info(bool complete) const {
  const OpenRun& run = *open;
  nlohmann::json sources = nlohmann::json::array();
  nlohmann::json camera;
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    nlohmann::json told = receivers[i]->camera();
    if (file_streams.front().source_index == i) camera = told;
    sources.push_back({{"source", receivers[i]->source->name()}, {"camera", std::move(told)}, {"ended", nullptr}});
  }
  const SensorSize size = *declared.front().size;
  return {.object = run.request.run.object,
          .run = run.request.run.run,
          .session = run.request.session,
          .simulated = is_simulated,
          .complete = complete,
          .width = size.width,
          .height = size.height,
          .extra = {{"camera", camera},
                    {"sources", sources},
                    {"software", {{"name", "tactile"}, {"version", version()}, {"revision", revision()}}},
                    {"settings", run.request.settings},
                    {"host_time_us", {{"begin", us_of(run.begun)}, {"end", nullptr}}}}};
}

RunRecorder::RunRecorder(std::vector<std::unique_ptr<CameraSource>> sources, std::unique_ptr<RobotMonitor> robot,
                         std::unique_ptr<VideoCapture> video, RunRecorderOptions options)
    : state_(std::make_unique<State>(options)) {
  state_->file_streams = streams_of(sources);
  const auto says_simulated = [](const Stream& stream) {
    return std::find(stream.info.begin(), stream.info.end(), std::pair<std::string, std::string>("simulated", "true")) !=
           stream.info.end();
  };
  for (const FileStream& stream : state_->file_streams) {
    state_->declared.push_back(stream.stream);
    state_->is_simulated = state_->is_simulated || says_simulated(stream.stream);
  }
  for (const auto& source : sources) state_->is_simulated = state_->is_simulated || source->simulated();
  state_->robot = std::move(robot);
  state_->video = std::move(video);
  for (std::size_t i = 0; i < sources.size(); ++i)
    state_->receivers.push_back(std::make_unique<Receiver>(std::move(sources[i]), i, state_->queue));
}

RunRecorder::~RunRecorder() {
  try {
    if (state_->open) end("stopped");
  } catch (const std::exception&) {
    // A destructor has nobody to tell; what was recorded is readable all the same.
  }
}

const std::vector<Stream>& RunRecorder::streams() const { return state_->declared; }
bool RunRecorder::simulated() const { return state_->is_simulated; }
const RobotMonitor* RunRecorder::robot() const { return state_->robot.get(); }
void RunRecorder::discard() {
  for (const auto& receiver : state_->receivers) receiver->discard();
}

std::string RunRecorder::gone() const {
  const State& state = *state_;
  if (std::string error = state.source_error(); !error.empty()) return error;
  const bool again = std::any_of(state.receivers.begin(), state.receivers.end(),
                                 [](const auto& receiver) { return receiver->source->begins_again(); });
  return !again && state.sources_ended() ? "source ended" : "";
}

void RunRecorder::begin(const RunRequest& request) {
  State& state = *state_;
  if (state.open) throw Error(request.run.name() + ": a run is being recorded already; expected it to end first");
  std::error_code failed;
  if (!fs::is_empty(request.run.folder, failed) || failed) {
    throw Error(request.run.folder.string() + ": is no empty folder; expected one that was made for this run");
  }
  state.queue.open();
  bool robot_logs = false, video_films = false;
  try {
    state.open = std::make_unique<OpenRun>(request, state.file_streams, state.declared, state.options, state.queue);
    OpenRun& run = *state.open;
    run.by_camera_time = state.none_is_live();
    run.begun = host_now();
    run.begun_steady = Steady::now();
    write_run_info(request.run, state.info(false));
    if (state.robot) state.robot->start_log(request.run.robot());
    robot_logs = true;
    if (state.video) state.video->start_film(request.run.video(), request.run.video_times());
    video_films = true;
    run.start();
    for (const auto& receiver : state.receivers) receiver->begin(request.run);
    // A source may take its time to get ready, and that is not the run's.
    run.begun = host_now();
    run.begun_steady = Steady::now();
  } catch (...) {
    for (const auto& receiver : state.receivers) receiver->pause();
    state.open.reset();
    try {
      if (state.robot && robot_logs) state.robot->stop_log();
      if (state.video && video_films) state.video->stop_film();
    } catch (const Error&) {
      // They are removed at once.
    }
    std::error_code ignored;
    fs::remove_all(request.run.folder, ignored);
    throw;
  }
}

RunState RunRecorder::state() const {
  const State& state = *state_;
  if (!state.open) return {};
  OpenRun& run = *state.open;
  state.tell_of_ended_sources();
  const OpenRun::Written written = run.written();
  RunState now{.elapsed = std::chrono::duration_cast<microseconds>(Steady::now() - run.begun_steady),
               .events = written.events,
               .others = written.others,
               .bytes = size_of(run.request.run.events()),
               .queue_bytes = state.queue.waiting_bytes(),
               .drops = state.drops(written),
               .robot = {},
               .video = {},
               .ended = written.error};
  if (state.robot) now.robot = state.robot->state();
  if (state.video) now.video = state.video->state();
  if (now.video && !now.video->running && !run.film_ended) run.film_ended = host_now();
  if (now.ended.empty()) now.ended = state.source_error();
  const bool over = run.by_camera_time ? written.reached_duration : run.request.duration && now.elapsed >= *run.request.duration;
  if (now.ended.empty() && over) now.ended = "duration";
  if (now.ended.empty() && state.sources_ended()) now.ended = "source ended";
  return now;
}

RunSummary RunRecorder::end(const std::string& why) {
  State& state = *state_;
  if (!state.open) throw Error("run: none is being recorded; expected one that was begun");
  OpenRun& run = *state.open;
  RunSummary summary;
  summary.run = run.request.run;
  summary.session = run.request.session;
  summary.simulated = state.is_simulated;
  bool whole = true;
  const auto attempt = [&](const auto& step) {
    try {
      step();
    } catch (const std::exception& e) {
      whole = false;
      summary.errors.emplace_back(e.what());
    }
  };

  for (const auto& receiver : state.receivers) receiver->pause();
  const HostTime ended = host_now();
  summary.elapsed = std::chrono::duration_cast<microseconds>(Steady::now() - run.begun_steady);
  if (state.video && !state.video->state().running && !run.film_ended) run.film_ended = ended;
  run.stop();
  const OpenRun::Written written = run.written();
  if (!written.error.empty()) {
    whole = false;
    summary.errors.push_back(written.error);
  }
  try {
    run.writer.close();
  } catch (const std::exception& e) {
    if (written.error.empty()) summary.errors.emplace_back(e.what());  // else it is the same again
    whole = false;
  }
  if (const std::string gone = state.source_error(); !gone.empty()) summary.errors.push_back(gone);
  if (state.robot) {
    attempt([&] { state.robot->stop_log(); });
    summary.robot = state.robot->state();
  }
  if (state.video) {
    attempt([&] { state.video->stop_film(); });
    summary.video = state.video->state();
  }
  for (const auto& receiver : state.receivers) {
    attempt([&] { receiver->ask([&] { receiver->source->end_run(run.request.run, !state.robot, !state.video); }); });
  }

  const HeldElements held = held_elements(run.writer.written(), state.declared);
  summary.events = held.events;
  summary.others = held.others();
  summary.imu_samples = held.imu_samples;
  summary.triggers = held.triggers;
  summary.frames = held.frames;
  summary.drops = state.drops(written);
  // Where writing failed, what was handed to the file may still have waited for the rest of its packet.
  summary.drops.unwritten.events += written.events - held.events;
  summary.drops.unwritten.others += written.others - held.others();
  if (held.first) summary.span = between(*held.first, *held.last);
  if (held.first_event) summary.events_span = between(*held.first_event, *held.last_event);
  nlohmann::json files = nlohmann::json::object();
  attempt([&] {
    std::vector<fs::path> made;
    for (const fs::directory_entry& entry : fs::directory_iterator(run.request.run.folder)) {
      if (!entry.is_regular_file() || entry.path() == run.request.run.info()) continue;
      made.push_back(entry.path());
      summary.bytes += size_of(entry.path());
    }
    files = files_json(made);
  });
  summary.ended = summary.errors.empty() ? why : summary.errors.front();
  // A replay may have ended before its last packets were written, and the duration with them.
  if (summary.errors.empty() && run.by_camera_time && written.reached_duration) summary.ended = "duration";

  RunInfo info = state.info(whole);
  info.extra["host_time_us"]["end"] = us_of(ended);
  info.extra["dropped"] = json_of(summary.drops);
  info.extra["dropped"]["robot_gaps"] = summary.robot ? summary.robot->gaps : 0;
  info.extra["dropped"]["robot_packages"] = summary.robot ? summary.robot->missing : 0;
  info.extra["dropped"]["frames"] = summary.video ? summary.video->dropped : 0;
  if (summary.robot) {
    info.extra["robot"] = {
        {"controller", summary.robot->controller}, {"rows", summary.robot->rows}, {"reconnects", summary.robot->reconnects}};
  }
  const auto us_or_null = [](const std::optional<HostTime>& t) { return t ? nlohmann::json(us_of(*t)) : nlohmann::json(); };
  if (summary.video) info.extra["video"] = {{"frames", summary.video->frames}, {"ended", us_or_null(run.film_ended)}};
  for (std::size_t i = 0; i < state.receivers.size(); ++i) {
    const std::optional<HostTime> source_ended = state.receivers[i]->ended_at();
    if (source_ended && *source_ended < ended) info.extra["sources"][i]["ended"] = us_of(*source_ended);
  }
  info.extra["files"] = files;
  info.extra["ended"] = summary.ended;
  nlohmann::json& pairs = info.extra["host_from_camera"] = nlohmann::json::array();
  for (const ClockPair& pair : run.pairs.pairs()) pairs.push_back({us_of(pair.camera), us_of(pair.host)});
  attempt([&] { write_run_info(run.request.run, info); });
  summary.complete = whole;
  state.open.reset();
  return summary;
}

}  // namespace tactile
