#include "tactile/capture/run_writer.hpp"

#include <algorithm>
#include <exception>
#include <utility>

#include "tactile/core/host_clock.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/event_checks.hpp"
#include "tactile/events/packet_checksums.hpp"
#include "tactile/events/packet_compression.hpp"
#include "tactile/events/packet_contents.hpp"

namespace tactile::capture {
namespace {

using Steady = std::chrono::steady_clock;

constexpr std::chrono::milliseconds patience{50};  // so that waiting elements are written in time
constexpr std::uint64_t kept_in_memory = std::uint64_t{512}
                                         << 20;  // of the file, by the system: whole runs of a usual length [B]

std::vector<events::Stream> declared(const std::vector<RecordedStream>& streams) {
  std::vector<events::Stream> all;
  all.reserve(streams.size());
  for (const RecordedStream& stream : streams) all.push_back(stream.stream);
  return all;
}

/// First and last time of a packet.
struct TimeSpan {
  CameraTime first, last;
};

template <class Element>
std::optional<TimeSpan> span_of(const std::vector<Element>& elements) {
  if (elements.empty()) return std::nullopt;
  return TimeSpan{elements.front().t, elements.back().t};
}

/// First and last time of the elements of the stream's type; nothing if there are none.
std::optional<TimeSpan> span_of(const CameraPacket& packet, events::StreamType type) {
  switch (type) {
    case events::StreamType::events:
      return span_of(packet.events);
    case events::StreamType::imu:
      return span_of(packet.imu);
    case events::StreamType::triggers:
      return span_of(packet.triggers);
    default:
      return packet.frame ? std::optional(TimeSpan{packet.frame->t, packet.frame->t}) : std::nullopt;
  }
}

bool is_sound(const events::Frame& frame) {
  const std::size_t pixel = events::bytes_per_pixel(frame.format);
  if (pixel == 0 || frame.width < 0 || frame.height < 0) return false;
  const std::size_t size = pixel * static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.height);
  return frame.pixels.size() == size && size <= events::packet_limit - 4096;
}

/// Removes elements that are earlier than previous ones. @return  how many
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

}  // namespace

RunWriter::RunWriter(const std::filesystem::path& file, std::vector<RecordedStream> streams, PacketQueue& queue,
                     const RunWriterOptions& options)
    : path_(file),
      streams_(std::move(streams)),
      options_(options),
      queue_(queue),
      file_(file, declared(streams_), {.compression = options.compression, .checksums = true}),
      newest_(streams_.size()) {}

RunWriter::~RunWriter() { stop(); }

void RunWriter::start() {
  writing_ = std::thread([this] { write_all(); });
  syncing_ = std::thread([this] { sync_all(); });
}

RunWriter::Written RunWriter::written() const {
  const std::scoped_lock lock(guard_);
  Written written = so_far_;
  written.lateness = lateness_.most(host_now());
  return written;
}

void RunWriter::stop() {
  queue_.close();
  if (writing_.joinable()) writing_.join();
  {
    const std::scoped_lock lock(guard_);
    ends_ = true;
  }
  sync_wanted_.notify_all();
  if (syncing_.joinable()) syncing_.join();
}

void RunWriter::fail(const std::string& error) {
  const std::scoped_lock lock(guard_);
  if (so_far_.error.empty()) so_far_.error = error;
}

void RunWriter::write_all() {
  Steady::time_point next_sync = Steady::now() + options_.sync_period;
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
  while (queue_.pop(packet, patience)) {
    if (!packet.empty()) {
      if (!failed) attempt([&] { write_packet(packet.front()); });
      if (failed) {
        const std::scoped_lock lock(guard_);
        so_far_.drops.unwritten += count_of(packet.front().elements);
      }
      queue_.give_back(std::move(packet));
      packet.clear();
    }
    if (Steady::now() < next_sync || failed) continue;
    next_sync = Steady::now() + options_.sync_period;
    attempt([&] { file_.write_waiting(); });
    {
      const std::scoped_lock lock(guard_);
      wants_sync_ = true;
    }
    sync_wanted_.notify_all();
  }
}

void RunWriter::write_packet(QueuedPacket& queued) {
  CameraPacket& packet = queued.elements;
  const auto found = std::find_if(streams_.begin(), streams_.end(), [&](const RecordedStream& s) {
    return s.source_index == queued.source_index && s.source_stream == packet.stream_id;
  });
  if (found == streams_.end()) {
    const std::scoped_lock lock(guard_);
    so_far_.drops.outside += count_of(packet);
    return;
  }
  const events::Stream& stream = found->stream;
  const LostElements came = count_of(packet);
  RunDrops drops;
  leave_out_misfits(stream, packet, drops);
  std::optional<CameraTime> first = so_far_.first;  // changed by this thread only
  std::optional<TimeSpan> span = span_of(packet, stream.type);
  if (span && !first) first = span->first;
  const bool reached_duration = cut_to_duration(packet, first);
  span = span_of(packet, stream.type);
  {
    const std::scoped_lock lock(guard_);
    if (!span && !reached_duration) {
      if (drops.back_in_time.events + drops.back_in_time.others > 0) {
        ++drops.back_in_time.packets;
      } else if (came.events + came.others > 0) {
        ++drops.outside.packets;
      }
    }
    so_far_.drops.back_in_time += drops.back_in_time;
    so_far_.drops.outside += drops.outside;
    so_far_.first = first;
  }

  if (span) {
    switch (stream.type) {
      case events::StreamType::events:
        file_.write_events(stream.id, packet.events);
        break;
      case events::StreamType::imu:
        file_.write_imu(stream.id, packet.imu);
        break;
      case events::StreamType::triggers:
        file_.write_triggers(stream.id, packet.triggers);
        break;
      default:
        file_.write_frame(stream.id, *packet.frame);
        break;
    }
    newest_[static_cast<std::size_t>(stream.id)] = span->last;
    if (options_.pairs_clocks && stream.source == streams_.front().stream.source) note_arrival({span->last, queued.arrived});
  }

  const LostElements left = count_of(packet);
  const std::scoped_lock lock(guard_);
  so_far_.events += left.events;
  so_far_.others += left.others;
  so_far_.reached_duration = so_far_.reached_duration || reached_duration;
}

void RunWriter::note_arrival(const ClockPair<CameraClock>& pair) {
  pairs_.add(pair);
  const std::optional<ClockOffset> clock = pairs_.offset();
  const microseconds difference{saturating_subtract(us_of(pair.host), us_of(pair.device))};
  const std::scoped_lock lock(guard_);
  lateness_.add(pair.host, microseconds{saturating_subtract(difference.count(), clock->offset.count())});
  so_far_.clock = clock;
}

void RunWriter::leave_out_misfits(const events::Stream& stream, CameraPacket& packet, RunDrops& drops) const {
  const CameraTime newest = newest_[static_cast<std::size_t>(stream.id)].value_or(CameraTime::min());
  switch (stream.type) {
    case events::StreamType::events: {
      const events::SensorSize size = *stream.size;
      const events::EventsCheck check = events::check_events(packet.events, size);
      const bool goes_on = packet.events.empty() || packet.events.front().t >= newest;
      if (check.inside && check.ascending && goes_on) break;
      drops.outside.events += static_cast<std::uint64_t>(
          std::erase_if(packet.events, [size](const events::Event& e) { return events::is_outside(e, size); }));
      drops.back_in_time.events += leave_out_steps_back(packet.events, newest);
      break;
    }
    case events::StreamType::imu:
      drops.back_in_time.others += leave_out_steps_back(packet.imu, newest);
      break;
    case events::StreamType::triggers:
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

/// Removes elements after the run's duration. @return  whether it is over
bool RunWriter::cut_to_duration(CameraPacket& packet, const std::optional<CameraTime>& first) const {
  if (!options_.duration || !first) return false;
  const CameraTime limit = after(*first, *options_.duration);
  const LostElements before_cut = count_of(packet);
  cut_at(packet.events, limit);
  cut_at(packet.imu, limit);
  cut_at(packet.triggers, limit);
  if (packet.frame && packet.frame->t >= limit) packet.frame.reset();
  const LostElements left = count_of(packet);
  return left.events < before_cut.events || left.others < before_cut.others;
}

void RunWriter::sync_all() {
  std::unique_lock lock(guard_);
  for (;;) {
    sync_wanted_.wait(lock, [this] { return wants_sync_ || ends_; });
    if (ends_) return;
    wants_sync_ = false;
    lock.unlock();
    try {
      sync_to_disk(path_);
      const std::filesystem::path checksums = events::checksums_beside(path_);
      if (std::filesystem::exists(checksums)) sync_to_disk(checksums);
      // Releases the pages of a long recording for reuse: new pages cost more, and other programs need the memory, too.
      release_memory_of(path_, kept_in_memory);
    } catch (const std::exception& e) {
      fail(e.what());
    }
    lock.lock();
  }
}

}  // namespace tactile::capture
