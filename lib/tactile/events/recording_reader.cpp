#include "tactile/events/recording_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/events/event_checks.hpp"
#include "tactile/events/event_read_ahead.hpp"
#include "tactile/events/packet_compression.hpp"
#include "tactile/events/packet_contents.hpp"
#include "tactile/events/recording_header.hpp"
#include "tactile/events/recording_index.hpp"

namespace tactile {
namespace fs = std::filesystem;
namespace {

constexpr std::int64_t wrap = std::int64_t{1} << 32;

template <class Element>
bool is_ascending(std::span<const Element> elements) {
  bool falls = false;  // without a branch: most packets are sound
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

/// How far the times of a stream have come, put right.
///
/// A step back by more than 2^31 us and at most 2^32 is an overflow, for adding 2^32 us makes a shorter step on of it: a writer
/// cut its times to 32 bits and extended their sign. A damaged time makes such a step too, before it or behind it. So the place
/// that a leap started from is kept, and where the stream comes back to it soon, nothing has overflowed.
class StreamTime {
 public:
  enum class Step : std::uint8_t { on, overflow, back };

  /// Goes on to a time as it is stored; `back` takes all shifts since the leap away again.
  Step go_to(CameraTime stored) {
    Step result = Step::on;
    const std::int64_t step = begun_ ? step_between(last_, after(stored, microseconds{shift_})) : 0;
    const bool leaps = step > leap || step < -leap;
    const std::int64_t step_there = step_between(left_at_, after(stored, microseconds{shift_there_}));
    // A leap within reach of an overflow may be a silence: then one behind it explains a step back as well as its undoing does.
    const std::int64_t going_on = strayed_far_ || is_near(step) || step > 0 ? step : saturating_add(step, wrap);
    if (strayed_ && is_near(step_there) && size_of(step_there) < size_of(going_on)) {
      result = Step::back;
      shift_ = shift_there_;
      strayed_ = false;
    } else if (leaps) {
      if (!strayed_ || !strayed_far_) {
        strayed_ = leapt_ = true;
        strayed_far_ = !is_near(step);
        left_at_ = last_;
        shift_there_ = shift_;
      }
      const std::int64_t shift_before = shift_;
      if (!is_near(step) && step < 0 && step >= -wrap) shift_ += wrap;
      if (!is_near(step) && step > 0 && step <= wrap && shift_ > 0) shift_ -= wrap;
      if (shift_ != shift_before) result = Step::overflow;
    }
    begun_ = true;
    last_ = after(stored, microseconds{shift_});
    return result;
  }

  /// Likewise to the last of a packet's times, which ascend and lie close together.
  bool is_steady(CameraTime first, CameraTime last) const {
    return shift_ == 0 && !strayed_ && step_between(first, last) <= leap;
  }

  /// Who leapt and goes on from there for a whole packet does not come back.
  void end_packet() {
    strayed_ = strayed_ && leapt_;
    leapt_ = false;
  }

  std::int64_t shift() const { return shift_; }  ///< to be added to what is stored [us]

 private:
  static constexpr std::int64_t leap = wrap / 64;  ///< a minute, which no stream of a camera is silent for unless all is still

  static std::int64_t step_between(CameraTime a, CameraTime b) { return saturating_subtract(us_of(b), us_of(a)); }
  static double size_of(std::int64_t step) { return std::abs(static_cast<double>(step)); }
  static bool is_near(std::int64_t step) { return step >= -wrap / 2 && step <= wrap / 2; }

  CameraTime last_{};
  std::int64_t shift_ = 0;
  CameraTime left_at_{};  ///< where the stream strayed from
  std::int64_t shift_there_ = 0;
  bool begun_ = false;
  bool strayed_ = false;
  bool strayed_far_ = false;  ///< by more than 2^31 us
  bool leapt_ = false;        ///< in this packet
};

/// What has been found out about one packet.
struct PacketNote {
  StreamTime before;       ///< it
  bool counted = false;    ///< its problems are in the counts
  bool unwrapped = false;  ///< likewise that its times were put right
  bool put_right = false;  ///< its elements are not quite those that are stored
};

}  // namespace

struct RecordingReader::State {
  fs::path path;
  unsigned threads;
  RecordingFile file;
  RecordingStart start;
  PacketIndex index = PacketIndex::scan;
  RecordingProblems problems;
  std::vector<PacketRecord> records;
  std::vector<PacketNote> notes;  ///< one per record
  std::map<std::int32_t, StreamTime> times;
  bool scanning = false;

  PacketBuffer content;
  EventPacketDecoder decoder;
  std::unique_ptr<EventReadAhead> ahead;  ///< once packets of events are read one after the other
  std::size_t ahead_until = 0;            ///< the first packet behind those that it knows of
  std::set<std::int32_t> streams_read;    ///< streams of events that were read from
  std::size_t next_events = 0;            ///< the packet of those that follows the one read last
  unsigned in_a_row = 0;                  ///< packets read one after the other

  State(fs::path recording, unsigned thread_count)
      : path(std::move(recording)),
        threads(thread_count),
        file(path),
        start(read_start(file)),
        decoder(file, start.header.compression) {
    PacketList list = find_packets(file, start);
    index = list.index;
    problems = std::move(list.problems);
    records = std::move(list.packets);
    notes.resize(records.size());
    index == PacketIndex::table ? follow_table_times() : scan();
  }

  const Stream* declared(std::int32_t id) const;
  SensorSize sensor_of(const PacketRecord& record) const;
  bool is_events(const PacketRecord& record) const { return declared(record.stream_id)->type == StreamType::events; }

  void follow_table_times();
  void scan();

  std::size_t index_of(const PacketRecord& packet) const;
  std::size_t index_of(const PacketRecord& packet, StreamType type) const;
  bool is_whole(std::size_t i, Contents contents);
  template <class Decode>
  bool decode(std::size_t i, const Decode& decode_content);
  template <class Element>
  void put_times_right(std::size_t i, std::span<Element> elements, bool ascending);
  template <class Element>
  void note_elements(std::size_t i, std::span<const Element> elements);

  std::optional<DecodedEvents> events_ahead(std::size_t i);
  std::span<Event> events(std::size_t i);
  std::vector<ImuSample> imu(std::size_t i);
  std::vector<Trigger> triggers(std::size_t i);
  std::optional<Frame> frame(std::size_t i);
};

const Stream* RecordingReader::State::declared(std::int32_t id) const {
  const std::vector<Stream>& streams = start.header.streams;
  const auto found = std::find_if(streams.begin(), streams.end(), [id](const Stream& s) { return s.id == id; });
  return found == streams.end() ? nullptr : &*found;
}

SensorSize RecordingReader::State::sensor_of(const PacketRecord& record) const {
  return bounds_of(declared(record.stream_id)->size);
}

/// Puts times right that a table has as they are stored.
void RecordingReader::State::follow_table_times() {
  for (std::size_t i = 0; i < records.size(); ++i) {
    PacketRecord& record = records[i];
    if (record.elements == 0) continue;
    StreamTime& time = times[record.stream_id];
    notes[i].before = time;
    time.go_to(record.first);
    const std::int64_t shift_at_first = time.shift();
    time.go_to(record.last);
    // Where they differ, one of them is an outlier: it stays, and the packet's times are all between them.
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

/// Completes the records by decoding every packet once.
void RecordingReader::State::scan() {
  scanning = true;
  for (const Stream& stream : start.header.streams) {
    if (stream.type == StreamType::events) streams_read.insert(stream.id);
  }
  for (std::size_t i = 0; i < records.size(); ++i) {
    switch (declared(records[i].stream_id)->type) {
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
  const auto by_time = [](const Element& a, const Element& b) { return a.t < b.t; };
  const auto [first, last] = std::minmax_element(elements.begin(), elements.end(), by_time);
  records[i].elements = static_cast<std::int64_t>(elements.size());
  records[i].first = first->t;
  records[i].last = last->t;
}

std::size_t RecordingReader::State::index_of(const PacketRecord& packet) const {
  const auto by_offset = [](const PacketRecord& a, std::uint64_t offset) { return a.payload_offset < offset; };
  const auto found = std::lower_bound(records.begin(), records.end(), packet.payload_offset, by_offset);
  if (found == records.end() || found->payload_offset != packet.payload_offset) {
    throw Error(fmt::format("{}: has no packet at byte {}; expected one of its own", file.name(), packet.payload_offset));
  }
  return static_cast<std::size_t>(found - records.begin());
}

std::size_t RecordingReader::State::index_of(const PacketRecord& packet, StreamType type) const {
  const std::size_t i = index_of(packet);
  const Stream& stream = *declared(records[i].stream_id);
  if (stream.type == type) return i;
  throw Error(fmt::format("{}: stream {} holds {}; expected {}", file.name(), stream.id, name_of(stream.type), name_of(type)));
}

/// Counts a packet that is not, once.
bool RecordingReader::State::is_whole(std::size_t i, Contents contents) {
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

/// Adds 2^32 us once for every wrap of the stream so far. In a scan this is also where the wraps between packets are found.
template <class Element>
void RecordingReader::State::put_times_right(std::size_t i, std::span<Element> elements, bool ascending) {
  if (elements.empty()) return;
  if (scanning) notes[i].before = times[records[i].stream_id];
  StreamTime time = notes[i].before;
  struct Run {
    std::size_t begin;
    std::int64_t shift;
  };
  std::vector<Run> runs;
  std::size_t k = 0;
  const auto go_on = [&] {
    const StreamTime::Step step = time.go_to(elements[k].t);
    if (step == StreamTime::Step::back) {
      // Runs since the leap are no runs. One that began before it has the shift that is in force again.
      while (!runs.empty() && runs.back().shift != time.shift()) runs.pop_back();
      if (runs.empty() && time.shift() != 0) runs.push_back({0, time.shift()});
    } else if (step == StreamTime::Step::overflow || (k == 0 && time.shift() != 0)) {
      runs.push_back({k, time.shift()});
    }
    ++k;
  };
  go_on();
  if (ascending && time.is_steady(elements.front().t, elements.back().t)) {
    time.go_to(elements.back().t);
  } else {
    while (k < elements.size()) go_on();
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
  notes[i].put_right = true;
  if (!std::exchange(notes[i].unwrapped, true) && !notes[i].counted) ++problems.unwrapped_packets;
}

/// What was decoded ahead of being asked for, if it was. Who reads packet after packet of some streams is taken to go on so.
std::optional<DecodedEvents> RecordingReader::State::events_ahead(std::size_t i) {
  if (threads < 2) return std::nullopt;
  const bool is_new_stream = streams_read.insert(records[i].stream_id).second;
  in_a_row = !is_new_stream && i == next_events ? in_a_row + 1 : 0;
  next_events = i + 1;
  while (next_events < records.size() && !streams_read.contains(records[next_events].stream_id)) ++next_events;

  if (is_new_stream && ahead) ahead->expect({});
  constexpr unsigned habit = 3;
  constexpr std::size_t most_packets = 8192;  // that it is told of at once, for the list takes memory
  if (in_a_row == habit || (in_a_row > habit && i >= ahead_until)) {
    std::vector<EventPacket> packets;
    ahead_until = std::min(records.size(), next_events + most_packets);
    for (std::size_t k = next_events; k < ahead_until; ++k) {
      if (streams_read.contains(records[k].stream_id)) packets.push_back({records[k], sensor_of(records[k])});
    }
    if (!ahead) ahead = std::make_unique<EventReadAhead>(file, start.header.compression, threads - 1);
    ahead->expect(std::move(packets));
    return std::nullopt;
  }
  return ahead && in_a_row > habit ? ahead->take(records[i]) : std::nullopt;
}

std::span<Event> RecordingReader::State::events(std::size_t i) {
  std::optional<DecodedEvents> decoded = events_ahead(i);
  if (!decoded) decoded = decoder.decode(records[i], sensor_of(records[i]), content);
  if (!is_whole(i, decoded->contents)) return {};
  if (decoded->dropped > 0) {
    notes[i].put_right = true;
    if (!notes[i].counted) problems.out_of_range_events += decoded->dropped;
  }
  put_times_right(i, decoded->events, decoded->ascending);
  notes[i].counted = true;
  return decoded->events;
}

std::vector<ImuSample> RecordingReader::State::imu(std::size_t i) {
  std::vector<ImuSample> samples;
  if (!decode(i, [&](std::size_t length) { return decode_imu(content, length, samples); })) return {};
  put_times_right(i, std::span<ImuSample>(samples), is_ascending(std::span<const ImuSample>(samples)));
  notes[i].counted = true;
  return samples;
}

std::vector<Trigger> RecordingReader::State::triggers(std::size_t i) {
  std::vector<Trigger> result;
  if (!decode(i, [&](std::size_t length) { return decode_triggers(content, length, result); })) return {};
  put_times_right(i, std::span<Trigger>(result), is_ascending(std::span<const Trigger>(result)));
  notes[i].counted = true;
  return result;
}

std::optional<Frame> RecordingReader::State::frame(std::size_t i) {
  Frame picture;
  if (!decode(i, [&](std::size_t length) { return decode_frame(content, length, picture); })) return {};
  put_times_right(i, std::span<Frame>(&picture, 1), true);
  notes[i].counted = true;
  return picture;
}

RecordingReader::RecordingReader(fs::path file, unsigned threads) : state_(std::make_unique<State>(std::move(file), threads)) {}
RecordingReader::~RecordingReader() = default;
RecordingReader::RecordingReader(RecordingReader&&) noexcept = default;
RecordingReader& RecordingReader::operator=(RecordingReader&&) noexcept = default;

const fs::path& RecordingReader::file() const { return state_->path; }
std::uint64_t RecordingReader::file_size() const { return state_->file.size(); }
Compression RecordingReader::compression() const { return state_->start.header.compression; }
std::span<const Stream> RecordingReader::streams() const { return state_->start.header.streams; }
std::span<const PacketRecord> RecordingReader::packets() const { return state_->records; }
PacketIndex RecordingReader::index() const { return state_->index; }
const RecordingProblems& RecordingReader::problems() const { return state_->problems; }

const Stream& RecordingReader::stream(std::int32_t id) const {
  const Stream* found = state_->declared(id);
  if (found != nullptr) return *found;
  std::string ids;
  for (const Stream& stream : streams()) ids += (ids.empty() ? "" : ", ") + std::to_string(stream.id);
  throw Error(fmt::format("{}: has no stream {}; expected one of {}", state_->file.name(), id, ids));
}

std::span<Event> RecordingReader::read_events(const PacketRecord& packet) {
  return state_->events(state_->index_of(packet, StreamType::events));
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
bool RecordingReader::was_put_right(const PacketRecord& packet) const {
  return state_->notes[state_->index_of(packet)].put_right;
}

const Stream& event_stream(const RecordingReader& recording, std::string_view choice) {
  return event_stream(recording.streams(), recording.file().string(), choice);
}

const Stream& event_stream(std::span<const Stream> streams, std::string_view where, std::string_view choice) {
  std::vector<const Stream*> all;
  for (const Stream& stream : streams) {
    if (stream.type == StreamType::events) all.push_back(&stream);
  }
  const std::string name(where);
  if (all.empty()) throw Error(name + ": no event stream; expected an EVTS stream");
  std::vector<const Stream*> chosen = all;
  if (!choice.empty()) {
    const auto id = whole_number_in(choice);
    std::erase_if(chosen, [&](const Stream* s) { return !id || s->id != *id; });
    if (chosen.empty())
      std::copy_if(all.begin(), all.end(), std::back_inserter(chosen), [&](const Stream* s) { return s->source == choice; });
  }
  if (chosen.size() == 1) return *chosen.front();
  std::string list;
  for (const Stream* stream : all) {
    list +=
        fmt::format("{}{}{}", list.empty() ? "" : ", ", stream->id, stream->source.empty() ? "" : " (" + stream->source + ")");
  }
  if (choice.empty())
    throw Error(fmt::format("{}: has {} event streams; expected a choice of {} by id or source", name, all.size(), list));
  throw Error(fmt::format("{}: '{}' names {} of its event streams; expected one of {} by id or source", name, choice,
                          chosen.empty() ? "none" : "more than one", list));
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

}  // namespace tactile
