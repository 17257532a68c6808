#include "tactile/events/recording_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/events/event_checks.hpp"
#include "tactile/events/event_read_ahead.hpp"
#include "tactile/events/packet_compression.hpp"
#include "tactile/events/packet_contents.hpp"
#include "tactile/events/raw_pieces.hpp"
#include "tactile/events/recording_header.hpp"
#include "tactile/events/recording_index.hpp"
#include "tactile/events/stream_time.hpp"

namespace tactile::events {
namespace fs = std::filesystem;
namespace {

template <class Element>
bool is_ascending(std::span<const Element> elements) {
  bool falls = false;  // no branch: most packets are sound
  for (std::size_t i = 1; i < elements.size(); ++i) falls |= elements[i].t < elements[i - 1].t;
  return !falls;
}

void shift_time(CameraTime& t, std::int64_t shift) { t = after(t, microseconds{shift}); }
void shift_times(Event& event, std::int64_t shift) { shift_time(event.t, shift); }
void shift_times(ImuSample& sample, std::int64_t shift) { shift_time(sample.t, shift); }
void shift_times(Trigger& trigger, std::int64_t shift) { shift_time(trigger.t, shift); }
void shift_times(Frame& frame, std::int64_t shift) {
  for (CameraTime* t : {&frame.t, &frame.frame_start, &frame.frame_end, &frame.exposure_start, &frame.exposure_end}) {
    shift_time(*t, shift);
  }
}

/// What is known of one packet.
struct PacketNote {
  StreamTime before;       ///< of its stream, before this packet
  bool counted = false;    ///< its problems are in the counts
  bool unwrapped = false;  ///< its overflow is in the counts
  bool corrected = false;  ///< its elements differ from those that are stored
};

}  // namespace

struct RecordingReader::State {
  fs::path path;
  unsigned threads;
  RecordingFile file;
  std::optional<RawHeader> raw;
  std::unique_ptr<RawPieces> pieces;  ///< of a RAW file
  RecordingStart start;
  PacketIndex index = PacketIndex::scan;
  RecordingProblems problems;
  std::vector<PacketRecord> records;
  std::vector<PacketNote> notes;  ///< one per record
  std::map<std::int32_t, StreamTime> times;
  bool scanning = false;

  PacketBuffer content;
  EventPacketDecoder decoder;
  std::unique_ptr<EventReadAhead> ahead;  ///< exists once packets of events are read in sequence
  std::size_t ahead_until = 0;            ///< the first packet after those that it knows
  std::set<std::int32_t> streams_read;    ///< streams of events that were read from
  std::size_t next_events = 0;            ///< the next packet of those streams
  unsigned in_a_row = 0;                  ///< packets read in sequence

  State(fs::path recording, unsigned thread_count)
      : path(std::move(recording)),
        threads(thread_count),
        file(path),
        raw(raw_header_of(file)),
        start(raw ? RecordingStart{.header = {.streams = raw_streams(*raw)}, .data_begin = raw->data_begin} : read_start(file)),
        decoder(file, start.header.compression) {
    if (raw) {
      find_pieces();
      return;
    }
    PacketList list = find_packets(file, start);
    index = list.index;
    problems = std::move(list.problems);
    records = std::move(list.packets);
    notes.resize(records.size());
    index == PacketIndex::table ? follow_table_times() : scan();
  }

  SensorSize sensor_of(const PacketRecord& record) const;
  void find_pieces();
  void follow_table_times();
  void scan();

  std::size_t index_of(const PacketRecord& packet) const;
  std::size_t index_of(const PacketRecord& packet, StreamType type) const;
  bool is_whole(std::size_t i, Contents contents);
  template <class Decode>
  bool decode(std::size_t i, const Decode& decode_content);
  template <class Element>
  void correct_times(std::size_t i, std::span<Element> elements, bool ascending);
  template <class Element>
  void note_elements(std::size_t i, std::span<const Element> elements);

  void check_unchanged(std::size_t i, bool is_whole, std::span<const Event> events) const;
  std::optional<DecodedEvents> events_ahead(std::size_t i);
  std::span<Event> events(std::size_t i);
  std::vector<ImuSample> imu(std::size_t i);
  std::vector<Trigger> triggers(std::size_t i);
  std::optional<Frame> frame(std::size_t i);
};

SensorSize RecordingReader::State::sensor_of(const PacketRecord& record) const {
  return bounds_of(start.header.declared(record.stream_id)->size);
}

/// Reads a RAW file once. A stream of triggers is declared only if there are any.
void RecordingReader::State::find_pieces() {
  index = PacketIndex::pieces;
  pieces = open_raw_pieces(file, *raw);
  records = pieces->find(problems);
  notes.resize(records.size());
  const bool has_triggers = std::any_of(records.begin(), records.end(), [](const PacketRecord& record) {
    return record.stream_id == RawPieces::trigger_stream_id;
  });
  if (!has_triggers) start.header.streams.resize(1);
}

/// Corrects overflows in the times of a table.
void RecordingReader::State::follow_table_times() {
  for (std::size_t i = 0; i < records.size(); ++i) {
    PacketRecord& record = records[i];
    if (record.elements == 0) continue;
    StreamTime& time = times[record.stream_id];
    notes[i].before = time;
    time.advance_to(record.first);
    const std::int64_t shift_at_first = time.shift();
    time.advance_to(record.last);
    // If the shifts differ, one of the two times is an outlier. It stays as it is.
    const std::int64_t shift = time.shift() == shift_at_first ? shift_at_first : notes[i].before.shift();
    time.end_packet();
    shift_time(record.first, shift);
    shift_time(record.last, shift);
    if (shift != 0) {
      notes[i].unwrapped = true;
      ++problems.unwrapped_packets;
    }
  }
}

/// Completes the records: decodes every packet once.
void RecordingReader::State::scan() {
  scanning = true;
  for (const Stream& stream : start.header.streams) {
    if (stream.type == StreamType::events) streams_read.insert(stream.id);
  }
  for (std::size_t i = 0; i < records.size(); ++i) {
    switch (start.header.declared(records[i].stream_id)->type) {
      case StreamType::events:
        note_elements(i, std::span<const Event>(events(i)));
        break;
      case StreamType::imu:
        note_elements(i, std::span<const ImuSample>(imu(i)));
        break;
      case StreamType::triggers:
        note_elements(i, std::span<const Trigger>(triggers(i)));
        break;
      case StreamType::frames: {
        const std::optional<Frame> picture = frame(i);
        if (picture) note_elements(i, std::span<const Frame>(&*picture, 1));
        break;
      }
      case StreamType::other:
        break;
    }
  }
  scanning = false;
  streams_read.clear();
  ahead.reset();
  in_a_row = 0;
}

template <class Element>
void RecordingReader::State::note_elements(std::size_t i, std::span<const Element> elements) {
  if (elements.empty()) return;
  const auto [first, last] = time_extent_of(elements);
  records[i].elements = static_cast<std::int64_t>(elements.size());
  records[i].first = first;
  records[i].last = last;
}

std::size_t RecordingReader::State::index_of(const PacketRecord& packet) const {
  // A piece of a RAW file has a record for each of its streams.
  const auto place_of = [](const PacketRecord& a) { return std::pair(a.payload_offset, a.stream_id); };
  const auto is_before = [&](const PacketRecord& a, const PacketRecord& b) { return place_of(a) < place_of(b); };
  const auto found = std::lower_bound(records.begin(), records.end(), packet, is_before);
  if (found == records.end() || place_of(*found) != place_of(packet)) {
    throw Error(fmt::format("{}: has no packet at byte {}; expected one of its own", file.name(), packet.payload_offset));
  }
  return static_cast<std::size_t>(found - records.begin());
}

std::size_t RecordingReader::State::index_of(const PacketRecord& packet, StreamType type) const {
  const std::size_t i = index_of(packet);
  const Stream& stream = *start.header.declared(records[i].stream_id);
  if (stream.type == type) return i;
  throw Error(fmt::format("{}: stream {} holds {}; expected {}", file.name(), stream.id, name_of(stream.type), name_of(type)));
}

/// Counts a packet that is not whole, once. @throws Error  if it is lossy: the others would not be the whole recording
bool RecordingReader::State::is_whole(std::size_t i, Contents contents) {
  if (contents == Contents::lossy) throw Error(fmt::format("{}: {}", file.name(), lossy_contents));
  if (contents != Contents::whole && !std::exchange(notes[i].counted, true)) {
    ++(contents == Contents::broken ? problems.broken_packets : problems.mismatched_packets);
  }
  return contents == Contents::whole;
}

template <class Decode>
bool RecordingReader::State::decode(std::size_t i, const Decode& decode_content) {
  std::size_t size = 0;
  return is_whole(i, decoder.load(records[i], content, size) ? decode_content(size) : Contents::broken);
}

/// Adds 2^32 us for every overflow of the stream so far. In a scan this also finds the overflows between packets.
template <class Element>
void RecordingReader::State::correct_times(std::size_t i, std::span<Element> elements, bool ascending) {
  if (elements.empty()) return;
  if (scanning) notes[i].before = times[records[i].stream_id];
  StreamTime time = notes[i].before;
  struct Run {
    std::size_t begin;
    std::int64_t shift;
  };
  std::vector<Run> runs;
  std::size_t k = 0;
  const auto advance = [&] {
    const StreamTime::Step step = time.advance_to(elements[k].t);
    if (step == StreamTime::Step::back) {
      // Runs since the leap are void. A run from before the leap has the shift that applies again.
      while (!runs.empty() && runs.back().shift != time.shift()) runs.pop_back();
      if (runs.empty() && time.shift() != 0) runs.push_back({0, time.shift()});
    } else if (step == StreamTime::Step::overflow || (k == 0 && time.shift() != 0)) {
      runs.push_back({k, time.shift()});
    }
    ++k;
  };
  advance();
  if (ascending && time.is_steady(elements.front().t, elements.back().t)) {
    time.advance_to(elements.back().t);
  } else {
    while (k < elements.size()) advance();
  }
  time.end_packet();
  if (scanning) times[records[i].stream_id] = time;
  bool shifted = false;
  for (std::size_t run = 0; run < runs.size(); ++run) {
    if (runs[run].shift == 0) continue;
    shifted = true;
    const std::size_t end = run + 1 < runs.size() ? runs[run + 1].begin : elements.size();
    for (Element& element : elements.subspan(runs[run].begin, end - runs[run].begin)) shift_times(element, runs[run].shift);
  }
  if (!shifted) return;
  notes[i].corrected = true;
  if (!std::exchange(notes[i].unwrapped, true) && !notes[i].counted) ++problems.unwrapped_packets;
}

/// The packet, if it was decoded ahead. A caller that reads packets in sequence is expected to continue.
std::optional<DecodedEvents> RecordingReader::State::events_ahead(std::size_t i) {
  if (threads < 2) return std::nullopt;
  const bool is_new_stream = streams_read.insert(records[i].stream_id).second;
  in_a_row = !is_new_stream && i == next_events ? in_a_row + 1 : 0;
  next_events = i + 1;
  while (next_events < records.size() && !streams_read.contains(records[next_events].stream_id)) ++next_events;

  if (is_new_stream && ahead) ahead->expect({});
  constexpr unsigned habit = 3;
  constexpr std::size_t most_packets = 8192;  // announced at once; the list takes memory
  if (in_a_row == habit || (in_a_row > habit && i >= ahead_until)) {
    std::vector<EventPacket> packets;
    ahead_until = std::min(records.size(), next_events + most_packets);
    for (std::size_t k = next_events; k < ahead_until; ++k) {
      if (streams_read.contains(records[k].stream_id)) packets.push_back({records[k], sensor_of(records[k])});
    }
    constexpr unsigned most_ahead = 4;  // more wait for each other: with 16 threads `info` took longer than with one
    if (!ahead) ahead = std::make_unique<EventReadAhead>(file, start.header.compression, std::min(threads, most_ahead) - 1);
    ahead->expect(std::move(packets));
    return std::nullopt;
  }
  return ahead && in_a_row > habit ? ahead->take(records[i]) : std::nullopt;
}

/// A packet of a recording that is overwritten while it is read may have any time, and so any number of ticks.
/// @throws Error  if a packet is not as it was listed, and the file was written to
void RecordingReader::State::check_unchanged(std::size_t i, bool is_whole, std::span<const Event> events) const {
  const PacketRecord& record = records[i];
  const auto lies_within = [&](const Event& event) { return record.first <= event.t && event.t <= record.last; };
  const bool is_listed = is_whole && (events.empty() || (lies_within(events.front()) && lies_within(events.back())));
  if (!scanning && !is_listed) file.check_unchanged(record.payload_offset);
}

std::span<Event> RecordingReader::State::events(std::size_t i) {
  if (pieces) {
    const std::span<Event> events = pieces->events(records[i]);
    check_unchanged(i, true, events);
    return events;
  }
  std::optional<DecodedEvents> decoded = events_ahead(i);
  if (!decoded) decoded = decoder.decode(records[i], sensor_of(records[i]), content);
  if (!is_whole(i, decoded->contents)) {
    check_unchanged(i, false, {});
    return {};
  }
  if (decoded->dropped > 0) {
    notes[i].corrected = true;
    if (!notes[i].counted) problems.out_of_range_events += decoded->dropped;
  }
  correct_times(i, decoded->events, decoded->ascending);
  check_unchanged(i, true, decoded->events);
  notes[i].counted = true;
  return decoded->events;
}

std::vector<ImuSample> RecordingReader::State::imu(std::size_t i) {
  std::vector<ImuSample> samples;
  if (!decode(i, [&](std::size_t length) { return decode_imu(content, length, samples); })) return {};
  correct_times(i, std::span<ImuSample>(samples), is_ascending(std::span<const ImuSample>(samples)));
  notes[i].counted = true;
  return samples;
}

std::vector<Trigger> RecordingReader::State::triggers(std::size_t i) {
  if (pieces) return pieces->triggers(records[i]);
  std::vector<Trigger> result;
  if (!decode(i, [&](std::size_t length) { return decode_triggers(content, length, result); })) return {};
  correct_times(i, std::span<Trigger>(result), is_ascending(std::span<const Trigger>(result)));
  notes[i].counted = true;
  return result;
}

std::optional<Frame> RecordingReader::State::frame(std::size_t i) {
  Frame picture;
  if (!decode(i, [&](std::size_t length) { return decode_frame(content, length, picture); })) return {};
  correct_times(i, std::span<Frame>(&picture, 1), true);
  notes[i].counted = true;
  return picture;
}

RecordingReader::RecordingReader(fs::path file, unsigned threads) : state_(std::make_unique<State>(std::move(file), threads)) {}
RecordingReader::~RecordingReader() = default;
RecordingReader::RecordingReader(RecordingReader&&) noexcept = default;
RecordingReader& RecordingReader::operator=(RecordingReader&&) noexcept = default;

const fs::path& RecordingReader::file() const { return state_->path; }
std::uint64_t RecordingReader::file_size() const { return state_->file.size(); }
RecordingEncoding RecordingReader::encoding() const { return state_->raw ? state_->raw->encoding : RecordingEncoding::aedat4; }
Compression RecordingReader::compression() const { return state_->start.header.compression; }
std::span<const Stream> RecordingReader::streams() const { return state_->start.header.streams; }
std::span<const PacketRecord> RecordingReader::packets() const { return state_->records; }
PacketIndex RecordingReader::index() const { return state_->index; }
const RecordingProblems& RecordingReader::problems() const { return state_->problems; }

const Stream& RecordingReader::stream(std::int32_t id) const {
  const Stream* found = state_->start.header.declared(id);
  if (found != nullptr) return *found;
  std::string ids;
  for (const Stream& stream : streams()) ids += (ids.empty() ? "" : ", ") + std::to_string(stream.id);
  throw Error(fmt::format("{}: has no stream {}; expected one of {}", state_->file.name(), id, ids));
}

std::span<Event> RecordingReader::read_events(const PacketRecord& packet) {
  return state_->events(state_->index_of(packet, StreamType::events));
}
OwnedEvents RecordingReader::take_events(const PacketRecord& packet) {
  const std::span<Event> events = read_events(packet);
  const auto* first = reinterpret_cast<const std::byte*>(events.data());
  const std::less_equal<const std::byte*> is_up_to;  // also orders pointers into different memory
  const PacketBuffer& content = state_->content;
  if (!events.empty() && is_up_to(content.data(), first) && is_up_to(first, content.data() + content.capacity())) {
    return {std::exchange(state_->content, {}), events};
  }
  OwnedEvents copy;
  copy.memory.grow(events.size_bytes(), 0);
  auto* begin = reinterpret_cast<Event*>(copy.memory.data());
  std::uninitialized_copy(events.begin(), events.end(), begin);
  copy.events = {begin, events.size()};
  return copy;
}
std::vector<ImuSample> RecordingReader::read_imu(const PacketRecord& packet) {
  return state_->imu(state_->index_of(packet, StreamType::imu));
}
std::vector<Trigger> RecordingReader::read_triggers(const PacketRecord& packet) {
  return state_->triggers(state_->index_of(packet, StreamType::triggers));
}
std::optional<Frame> RecordingReader::read_frame(const PacketRecord& packet) {
  return state_->frame(state_->index_of(packet, StreamType::frames));
}
std::span<const std::byte> RecordingReader::read_stored(const PacketRecord& packet) {
  return state_->decoder.stored(state_->records[state_->index_of(packet)]);
}
bool RecordingReader::was_corrected(const PacketRecord& packet) const {
  return state_->notes[state_->index_of(packet)].corrected;
}

const Stream& event_stream(const RecordingReader& recording, std::string_view choice) {
  return event_stream(recording.streams(), recording.file().string(), choice);
}

void for_events_between(RecordingReader& recording, std::int32_t stream_id, CameraTime begin, CameraTime end,
                        const std::function<void(std::span<const Event>)>& use) {
  recording.stream(stream_id);
  for (const PacketRecord& packet : recording.packets()) {
    if (packet.stream_id != stream_id || packet.elements == 0 || packet.first >= end || packet.last < begin) continue;
    std::span<Event> events = recording.read_events(packet);
    const auto by_time = [](const Event& e, CameraTime t) { return e.t < t; };
    if (is_ascending(std::span<const Event>(events))) {
      const auto first = std::lower_bound(events.begin(), events.end(), begin, by_time);
      events = {first, std::lower_bound(first, events.end(), end, by_time)};
    } else {
      const auto outside = [=](const Event& e) { return e.t < begin || e.t >= end; };
      events = {events.begin(), std::remove_if(events.begin(), events.end(), outside)};
    }
    if (!events.empty()) use(events);
  }
}

void for_all_events(RecordingReader& recording, std::int32_t stream_id, const std::function<void(std::span<const Event>)>& use) {
  recording.stream(stream_id);
  for (const PacketRecord& packet : recording.packets()) {
    if (packet.stream_id != stream_id) continue;
    const std::span<Event> events = recording.read_events(packet);
    if (!events.empty()) use(events);
  }
}

}  // namespace tactile::events
