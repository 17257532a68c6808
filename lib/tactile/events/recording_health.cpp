#include "tactile/events/recording_health.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "tactile/core/error.hpp"
#include "tactile/core/ticks.hpp"
#include "tactile/events/packet_checksums.hpp"
#include "tactile/events/recording_header.hpp"
#include "tactile/events/stream_time.hpp"

namespace tactile::events {
namespace {

std::string counted(std::uint64_t n, const std::string& thing, const std::string& things) {
  return fmt::format("{} {}", n, n == 1 ? thing : things);
}

std::string name_of(const Stream& stream) {
  return fmt::format("stream {} ({})", stream.id, stream.name.empty() ? name_of(stream.type) : stream.name);
}

bool overlap(const Gap& a, const Gap& b) { return a.begin < b.end && b.begin < a.end; }

/// Marks the gaps in which the inertial sensor is silent too. Its silence is evidence only if it usually samples far more often
/// than the limit.
void compare_gaps_with_imu(std::vector<StreamHealth>& streams, microseconds limit) {
  for (StreamHealth& events : streams) {
    if (!events.events) continue;
    for (const StreamHealth& imu : streams) {
      if (imu.stream.type != StreamType::imu || imu.stream.source != events.stream.source) continue;
      const double awake_s = std::chrono::duration<double>(imu.stamps.duration() - imu.stamps.silent).count();
      if (static_cast<double>(imu.stamps.elements) * std::chrono::duration<double>(limit).count() < 10 * awake_s) continue;
      for (Gap& gap : events.stamps.longest_gaps) {
        gap.imu_silent |= std::any_of(imu.stamps.longest_gaps.begin(), imu.stamps.longest_gaps.end(),
                                      [&](const Gap& other) { return overlap(gap, other); });
      }
    }
  }
}

void judge_packets(RecordingHealth& health) {
  const RecordingProblems& problems = health.problems;
  auto& reasons = health.reasons;
  auto& notes = health.notes;
  if (problems.truncated_bytes > 0)
    reasons.push_back(
        fmt::format("truncated: {} after the last whole packet", counted(problems.truncated_bytes, "byte", "bytes")));
  if (problems.skipped_bytes > 0)
    reasons.push_back(fmt::format("damaged: {} between the packets; what they contained is lost",
                                  counted(problems.skipped_bytes, "byte", "bytes")));
  if (problems.resized_packets > 0) {
    reasons.push_back(counted(problems.resized_packets, "packet had", "packets had") +
                      " a wrong size in the header; corrected while reading");
  }
  if (!problems.table.empty()) reasons.push_back("the data table cannot be used: " + problems.table);
  if (problems.missing_packets > 0) {
    reasons.push_back(fmt::format("the data table lists {} ({}) that are not there",
                                  counted(problems.missing_packets, "packet", "packets"),
                                  counted(problems.missing_elements, "element", "elements")));
  }
  if (problems.broken_packets > 0)
    reasons.push_back(counted(problems.broken_packets, "packet does", "packets do") + " not decode");
  if (problems.mismatched_packets > 0) {
    reasons.push_back(counted(problems.mismatched_packets, "packet holds", "packets hold") + " another type than the stream's");
  }
  if (problems.undeclared_packets > 0) {
    reasons.push_back(counted(problems.undeclared_packets, "packet belongs", "packets belong") +
                      " to a stream that the header does not declare");
  }
  if (problems.out_of_range_events > 0) {
    reasons.push_back(counted(problems.out_of_range_events, "event lies", "events lie") +
                      " outside the sensor or of no valid polarity; dropped while reading");
  }
  if (health.index == PacketIndex::scan && problems.table.empty() && problems.truncated_bytes + problems.skipped_bytes == 0) {
    notes.emplace_back("never closed: no data table, but every packet is whole; 'tactile repair' adds the table");
  }
  if (problems.header_not_patched) {
    notes.emplace_back("never closed: the data table is sound, but the header lacks its position; 'tactile repair' writes it");
  }
  if (problems.empty_packets > 0) notes.push_back(counted(problems.empty_packets, "packet is", "packets are") + " empty");
  if (problems.unwrapped_packets > 0) {
    notes.push_back(counted(problems.unwrapped_packets, "packet was", "packets were") +
                    " 2^32 us too early; corrected while reading");
  }
}

void count(ChecksumHealth& checked, PacketCheck check, const ChecksumHealth::Packet& packet, std::size_t listed) {
  ++(check == PacketCheck::whole ? checked.whole : check == PacketCheck::damaged ? checked.damaged : checked.not_covered);
  if (check == PacketCheck::damaged && checked.first_damaged.size() < listed) checked.first_damaged.push_back(packet);
}

std::string text_of(const ChecksumHealth::Packet& packet, std::optional<CameraTime> begin) {
  const PacketRecord& record = packet.record;
  const std::string place = fmt::format("packet {} of stream {} at byte {}", packet.index, record.stream_id,
                                        record.payload_offset - packet_header_size);
  if (record.elements == 0 || !begin) return place;
  return place + fmt::format(", at {:.6f} s", std::chrono::duration<double>(between(*begin, record.first)).count());
}

void judge_checksums(RecordingHealth& health) {
  if (!health.checksums) return;
  const ChecksumHealth& checksums = *health.checksums;
  if (checksums.header_damaged) health.reasons.emplace_back("the header has a wrong checksum");
  if (checksums.damaged > 0) {
    std::string list;
    constexpr std::size_t shown = 3;
    for (std::size_t i = 0; i < std::min(shown, checksums.first_damaged.size()); ++i)
      list += (i == 0 ? "" : "; ") + text_of(checksums.first_damaged[i], health.first());
    health.reasons.push_back(fmt::format("{} a wrong checksum: {}{}", counted(checksums.damaged, "packet has", "packets have"),
                                         list, checksums.damaged > shown ? " ..." : ""));
  }
  if (checksums.not_covered > 0) {
    health.notes.push_back(counted(checksums.not_covered, "packet has", "packets have") +
                           " no checksum, so damage in them cannot be detected");
  }
}

void judge_stream(const StreamHealth& stream, const HealthOptions& options, RecordingHealth& health) {
  const std::string name = name_of(stream.stream);
  const StampHealth& stamps = stream.stamps;
  if (stamps.steps_back_in_packets + stamps.steps_back_between_packets > 0) {
    health.reasons.push_back(fmt::format("{}: time steps back {} inside packets and {} from one packet to the next", name,
                                         counted(stamps.steps_back_in_packets, "time", "times"),
                                         counted(stamps.steps_back_between_packets, "time", "times")));
  }
  if (!stream.events) return;
  if (stamps.elements == 0) health.reasons.push_back(name + ": no events");
  if (!stream.stream.size) {
    health.reasons.push_back(name + ": no sensor size declared");
  } else if (!stream.events->pixels_counted) {
    health.reasons.push_back(fmt::format("{}: {}x{} is not a valid sensor size, so hot pixels cannot be found", name,
                                         stream.stream.size->width, stream.stream.size->height));
  }
  const auto lost =
      std::count_if(stamps.longest_gaps.begin(), stamps.longest_gaps.end(), [](const Gap& gap) { return gap.imu_silent; });
  if (lost > 0) {
    health.reasons.push_back(fmt::format("{}: {} with neither events nor IMU samples: data is missing", name,
                                         counted(static_cast<std::uint64_t>(lost), "period", "periods")));
  }
  if (stamps.gaps > static_cast<std::uint64_t>(lost)) {
    health.notes.push_back(fmt::format("{}: {} longer than {} us; normal if the scene is quiet", name,
                                       counted(stamps.gaps, "silence", "silences"), options.gap.count()));
  }
  if (stream.events->hot_pixels > 0) {
    health.notes.push_back(
        fmt::format("{}: {} with {:.1f} % of the events", name, counted(stream.events->hot_pixels, "hot pixel", "hot pixels"),
                    100.0 * static_cast<double>(stream.events->hot_events) / static_cast<double>(stamps.elements)));
  }
}

void judge(RecordingHealth& health, const HealthOptions& options, std::uint64_t misdescribed) {
  compare_gaps_with_imu(health.streams, options.gap);
  judge_packets(health);
  judge_checksums(health);
  if (misdescribed > 0) {
    health.reasons.push_back("the data table disagrees with the elements of " + counted(misdescribed, "packet", "packets") +
                             "; a cut by time may miss some");
  }
  if (std::none_of(health.streams.begin(), health.streams.end(),
                   [](const StreamHealth& stream) { return stream.events.has_value(); })) {
    health.reasons.emplace_back("no event stream declared");
  }
  for (const StreamHealth& stream : health.streams) judge_stream(stream, options, health);
}

/// The meters of one stream.
struct Examination {
  Examination(const Stream& stream, const HealthOptions& options) : stamps(options.gap, options.listed) {
    health.stream = stream;
    if (stream.type == StreamType::events) events.emplace(stream.size, options);
  }

  StreamHealth health;
  StampMeter stamps;
  std::optional<EventMeter> events;
};

/// Whether the data table agrees with the elements of a packet. It describes what is stored, so it cannot be compared with
/// elements that were dropped, corrected or not decoded.
template <class Element>
bool table_agrees(const RecordingReader& recording, const PacketRecord& packet, std::span<const Element> elements) {
  if (recording.index() != PacketIndex::table || elements.empty() || recording.was_corrected(packet)) return true;
  const auto [first, last] = time_extent_of(elements);
  // Some writers store the earliest and the latest time, others the times of the first and the last element.
  return packet.elements == static_cast<std::int64_t>(elements.size()) &&
         (packet.first == first || packet.first == elements.front().t) &&
         (packet.last == last || packet.last == elements.back().t);
}

/// Reads a packet into the meters of its stream. @return  whether the data table agrees with it
bool examine_packet(RecordingReader& recording, const PacketRecord& packet, Examination& examination) {
  ++examination.health.packets;
  examination.health.bytes += (recording.index() == PacketIndex::pieces ? 0 : packet_header_size) + packet.payload_size;
  examination.stamps.begin_packet();
  const auto add = [&]<class Element>(std::span<const Element> elements) {
    for (const Element& element : elements) examination.stamps.add(element.t);
    return table_agrees(recording, packet, elements);
  };
  switch (examination.health.stream.type) {
    case StreamType::events: {
      const std::span<const Event> events = recording.read_events(packet);
      examination.events->add_packet(events);
      return table_agrees(recording, packet, events);
    }
    case StreamType::imu:
      return add(std::span<const ImuSample>(recording.read_imu(packet)));
    case StreamType::triggers:
      return add(std::span<const Trigger>(recording.read_triggers(packet)));
    case StreamType::frames: {
      const std::optional<Frame> frame = recording.read_frame(packet);
      return !frame || add(std::span<const Frame>(&*frame, 1));
    }
    case StreamType::other:
      break;
  }
  return true;
}

}  // namespace

std::optional<double> StampHealth::rate_hz() const {
  if (duration() <= microseconds{}) return std::nullopt;
  return static_cast<double>(elements) / std::chrono::duration<double>(duration()).count();
}

void StampMeter::note_gap(CameraTime begin, CameraTime end) {
  ++stamps_.gaps;
  stamps_.silent = microseconds{saturating_add(stamps_.silent.count(), between(begin, end).count())};
  auto& gaps = stamps_.longest_gaps;
  const Gap gap{begin, end};
  const auto place =
      std::upper_bound(gaps.begin(), gaps.end(), gap, [](const Gap& a, const Gap& b) { return a.length() > b.length(); });
  if (static_cast<std::size_t>(place - gaps.begin()) >= listed_) return;
  gaps.insert(place, gap);
  if (gaps.size() > listed_) gaps.pop_back();
}

StampHealth StampMeter::health() const {
  StampHealth health = stamps_;
  std::sort(health.longest_gaps.begin(), health.longest_gaps.end(), [](const Gap& a, const Gap& b) { return a.begin < b.begin; });
  return health;
}

EventMeter::EventMeter(std::optional<SensorSize> size, const HealthOptions& options)
    : options_(options), stamps_(options.gap, options.listed), readout_(size, ReadoutMeter::Extent::beginning) {
  const bool is_valid = size && size->width > 0 && size->height > 0 && std::int64_t{size->width} * size->height <= most_pixels;
  if (!is_valid) return;
  size_ = *size;
  counts_.resize(static_cast<std::size_t>(size_.width) * static_cast<std::size_t>(size_.height));
}

void EventMeter::add_packet(std::span<const Event> events) {
  stamps_.begin_packet();
  readout_.add(events);
  for (const Event& event : events) {
    if (!any_ || event.t < tick_begin_ || event.t >= tick_end_) {
      tick_begin_ = last_tick_until(event.t, options_.tick);
      tick_end_ = after(tick_begin_, options_.tick);
      tick_events_ = 0;
    }
    any_ = true;
    peak_tick_events_ = std::max(peak_tick_events_, ++tick_events_);
    stamps_.add(event.t);
    on_ += event.on;
    if (event.x >= 0 && event.y >= 0 && event.x < size_.width && event.y < size_.height) {
      std::uint32_t& count =
          counts_[static_cast<std::size_t>(event.y) * static_cast<std::size_t>(size_.width) + static_cast<std::size_t>(event.x)];
      if (count < std::numeric_limits<std::uint32_t>::max()) ++count;
    }
  }
}

EventHealth EventMeter::health() const {
  EventHealth health;
  health.on = on_;
  health.peak_tick_events = peak_tick_events_;
  health.peak_rate_hz = static_cast<double>(peak_tick_events_) / std::chrono::duration<double>(options_.tick).count();
  health.readout = readout_.readout();
  health.pixels_counted = !counts_.empty();
  if (health.pixels_counted) find_hot_pixels(health);
  return health;
}

void EventMeter::find_hot_pixels(EventHealth& health) const {
  const double seconds = std::chrono::duration<double>(stamps_.health().duration()).count();
  HotPixels hot = events::find_hot_pixels(counts_, size_, seconds, options_.hot);
  health.pixels_fired = hot.fired;
  health.hot_pixels = hot.pixels.size();
  for (const HotPixel& pixel : hot.pixels) health.hot_events += pixel.events;
  hot.pixels.resize(std::min(hot.pixels.size(), options_.listed));
  health.hottest = std::move(hot.pixels);
}

std::uint64_t RecordingHealth::packets() const {
  return std::accumulate(streams.begin(), streams.end(), std::uint64_t{0},
                         [](std::uint64_t sum, const StreamHealth& stream) { return sum + stream.packets; });
}

std::optional<CameraTime> RecordingHealth::first() const {
  std::optional<CameraTime> first;
  for (const StreamHealth& stream : streams) {
    if (stream.stamps.elements > 0) first = std::min(first.value_or(CameraTime::max()), stream.stamps.first);
  }
  return first;
}

std::optional<CameraTime> RecordingHealth::last() const {
  std::optional<CameraTime> last;
  for (const StreamHealth& stream : streams) {
    if (stream.stamps.elements > 0) last = std::max(last.value_or(CameraTime::min()), stream.stamps.last);
  }
  return last;
}

microseconds RecordingHealth::duration() const { return first() ? between(*first(), *last()) : microseconds{}; }

RecordingHealth examine_recording(const std::filesystem::path& file, const HealthOptions& options,
                                  const ProgressCallback& progress) {
  RecordingReader recording(file, options.threads);
  std::optional<std::int32_t> chosen;
  if (!options.stream.empty()) chosen = event_stream(recording, options.stream).id;
  std::vector<Examination> examinations;
  for (const Stream& stream : recording.streams()) {
    if (stream.type == StreamType::events && chosen && stream.id != *chosen) continue;
    examinations.emplace_back(stream, options);
  }

  std::optional<PacketChecksums> checksums;
  if (options.checksums) checksums.emplace(recording);
  RecordingHealth health;
  if (checksums && checksums->used()) health.checksums.emplace().header_damaged = checksums->header_damaged();
  std::uint64_t misdescribed = 0;  // packets with which the table disagrees
  std::size_t index = 0;
  for (const PacketRecord& packet : recording.packets()) {
    report_progress(progress, packet.payload_offset, recording.file_size(), file.filename().string());
    if (health.checksums)
      count(*health.checksums, checksums->check(packet, recording.read_stored(packet)), {index, packet}, options.listed);
    ++index;
    const auto found = std::find_if(examinations.begin(), examinations.end(),
                                    [&](const Examination& e) { return e.health.stream.id == packet.stream_id; });
    if (found != examinations.end() && !examine_packet(recording, packet, *found)) ++misdescribed;
  }

  health.file = file;
  health.file_size = recording.file_size();
  health.encoding = recording.encoding();
  health.compression = recording.compression();
  health.index = recording.index();
  health.problems = recording.problems();
  for (Examination& examination : examinations) {
    health.streams.push_back(std::move(examination.health));
    StreamHealth& stream = health.streams.back();
    stream.stamps = examination.events ? examination.events->stamps() : examination.stamps.health();
    if (examination.events) stream.events = examination.events->health();
  }
  judge(health, options, misdescribed);
  return health;
}

}  // namespace tactile::events
