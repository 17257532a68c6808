#include "tactile/events/recording_reader.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <map>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/events/file_descriptor.hpp"
#include "tactile/events/packet_compression.hpp"
#include "tactile/events/packet_contents.hpp"
#include "tactile/events/recording_header.hpp"

namespace tactile {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t packet_header_size = 8;
constexpr std::size_t header_limit = std::size_t{16} << 20;  ///< no header we know has a hundredth of that [B]
constexpr std::int64_t wrap = std::int64_t{1} << 32;

constexpr std::uint32_t lz4_magic = 0x184D2204;
constexpr std::uint32_t zstd_magic = 0xFD2FB528;

std::uint32_t u32_at(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// A step back that adding 2^32 us turns into a step on of less than 2^31: a writer cut its times to 32 bits and extended their
/// sign.
bool is_wrap(CameraTime previous, CameraTime next) {
  const std::int64_t step = saturating_subtract(us_of(next), us_of(previous));
  return step >= -wrap && step < -wrap / 2;
}

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

/// What has been found out about one packet.
struct PacketNote {
  std::int64_t shift = 0;  ///< added to its times, until one wraps inside of it [us]
  bool counted = false;    ///< its problems are in the counts
};

/// How far the times of a stream have come, put right.
struct StreamTime {
  bool begun = false;
  CameraTime last;
  std::int64_t shift = 0;

  std::int64_t shift_at(CameraTime first) const {
    return begun && is_wrap(last, after(first, microseconds{shift})) ? shift + wrap : shift;
  }
};

/// The packets from the first on, as their headers tell.
struct Walk {
  std::vector<PacketRecord> packets;  ///< with contents, declared or not
  std::uint64_t end = 0;              ///< where the last one ends [B]
  std::uint64_t empty = 0;
  bool at_table = false;  ///< it ended before a data table
};

std::string quoted(std::string_view text) {
  std::string result;
  for (const char c : text.substr(0, 40)) result += c >= ' ' && c <= '~' ? c : '?';
  return "'" + result + "'";
}

void refuse_magic(std::string_view start, const std::string& name) {
  if (start.empty()) throw Error(name + ": is empty; expected an AEDAT4 recording");
  if (start.starts_with("version https://git-lfs")) {
    throw Error(name + ": is a Git LFS pointer, not the recording itself; expected the file that 'git lfs pull' brings");
  }
  constexpr std::string_view aedat = "#!AER-DAT";
  if (start.starts_with(aedat) && !start.starts_with("#!AER-DAT4.0")) {
    const auto version = start.substr(aedat.size(), start.find_first_of("\r\n ") - aedat.size());
    throw Error(name + ": is of AEDAT version " + quoted(version) + "; expected version 4.0");
  }
  throw Error(name + ": starts with " + quoted(start.substr(0, magic_line.size())) +
              "; expected the line #!AER-DAT4.0 of an AEDAT4 recording");
}

}  // namespace

struct RecordingReader::State {
  fs::path path;
  std::string name;  ///< for errors
  FileDescriptor file;
  std::uint64_t size = 0;
  std::uint64_t data_begin = 0;  ///< of the first packet [B]
  RecordingHeader header;
  std::vector<PacketRecord> records;
  std::vector<PacketNote> notes;  ///< one per record
  std::map<std::int32_t, StreamTime> times;
  bool scanning = false;
  PacketIndex index = PacketIndex::scan;
  RecordingProblems problems;
  PacketBuffer stored, content;
  PacketDecompressor decompressor;

  void open();
  void read(std::uint64_t offset, std::span<std::byte> bytes) const;
  const Stream* declared(std::int32_t id) const;

  std::string read_table(std::uint64_t at, std::vector<PacketRecord>& entries);
  Walk walk(std::uint64_t end);
  bool table_starts_at(std::uint64_t at, std::span<const std::byte> head);
  bool may_be_payload(std::span<const std::byte> payload, std::uint32_t payload_size) const;
  std::string disagreement(const std::vector<PacketRecord>& entries, const Walk& walked) const;
  void take(const Walk& walked);
  void take_table(std::vector<PacketRecord> entries);
  void scan();

  std::size_t index_of(const PacketRecord& packet, StreamType type) const;
  bool load(const PacketRecord& record, std::size_t& content_size);
  template <class Decode>
  bool decode(std::size_t i, const Decode& decode_content);
  template <class Element>
  void put_times_right(std::size_t i, std::span<Element> elements);
  std::span<Event> sound_events(std::size_t i, std::span<Event> events);
  template <class Element>
  void note_elements(std::size_t i, std::span<const Element> elements);

  std::span<Event> events(std::size_t i);
  std::vector<ImuSample> imu(std::size_t i);
  std::vector<Trigger> triggers(std::size_t i);
  std::optional<Frame> frame(std::size_t i);
};

void RecordingReader::State::read(std::uint64_t offset, std::span<std::byte> bytes) const {
  const std::ptrdiff_t got = file.read_at(offset, bytes);
  if (got < 0) throw Error(name + ": cannot be read (" + std::strerror(errno) + "); expected a readable file");
  if (static_cast<std::size_t>(got) != bytes.size())
    throw Error(name + ": became shorter while it was read; expected it to stay as it is");
}

const Stream* RecordingReader::State::declared(std::int32_t id) const {
  const auto found = std::find_if(header.streams.begin(), header.streams.end(), [id](const Stream& s) { return s.id == id; });
  return found == header.streams.end() ? nullptr : &*found;
}

void RecordingReader::State::open() {
  name = path.string();
  file = FileDescriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat status {};
  if (!file.is_open() || ::fstat(file.number(), &status) != 0) {
    throw Error(name + ": cannot be opened (" + std::strerror(errno) + "); expected an AEDAT4 recording");
  }
  if (!S_ISREG(status.st_mode)) throw Error(name + ": is no regular file; expected an AEDAT4 recording");
  size = static_cast<std::uint64_t>(status.st_size);

  std::array<std::byte, 64> start{};
  const auto start_size = static_cast<std::size_t>(std::min<std::uint64_t>(size, start.size()));
  read(0, std::span(start).first(start_size));
  const std::string_view text(reinterpret_cast<const char*>(start.data()), start_size);
  if (!text.starts_with(magic_line)) refuse_magic(text, name);

  const std::size_t header_at = magic_line.size();
  const std::uint64_t header_size = start_size < header_at + 4 ? size : std::uint64_t{u32_at(start, header_at)} + 4;
  if (header_size > size - header_at) {
    throw Error(name + ": ends inside its header; expected a recording whose header was written whole");
  }
  if (header_size > header_limit) {
    throw Error(fmt::format("{}: claims a header of {} bytes; expected at most {}", name, header_size, header_limit));
  }
  content.grow(static_cast<std::size_t>(header_size), 0);
  const std::span<std::byte> header_bytes(content.data(), static_cast<std::size_t>(header_size));
  read(header_at, header_bytes);
  header = read_header(header_bytes, name);
  data_begin = header_at + header_size;

  std::vector<PacketRecord> entries;
  const std::int64_t position = header.table_position;
  const bool has_position = position >= 0 || position < -2;  // -1: not closed, -2: jAER's mark for the same
  if (has_position) {
    const auto table_at = static_cast<std::uint64_t>(position);
    if (position < 0 || table_at < data_begin || table_at >= size) {
      problems.table =
          fmt::format("its position {} lies outside the packets' part of the file, {} to {}", position, data_begin, size);
    } else {
      problems.table = read_table(table_at, entries);
      if (problems.table.empty()) {
        const Walk walked = walk(table_at);
        problems.table =
            walked.end == table_at ? disagreement(entries, walked) : "the packets before it do not end where it begins";
        if (problems.table.empty()) {
          take(walked);
          take_table(std::move(entries));
          return;
        }
      }
    }
  }

  const Walk walked = walk(size);
  take(walked);
  if (walked.at_table && !has_position) {
    problems.table = read_table(walked.end, entries);
    if (problems.table.empty()) problems.table = disagreement(entries, walked);
    if (problems.table.empty()) {
      take_table(std::move(entries));
      return;
    }
  }
  if (!walked.at_table) problems.truncated_bytes = size - walked.end;
  scan();
}

/// The data table at `at`, which runs to the end of the file; returns why it cannot be had, or nothing.
std::string RecordingReader::State::read_table(std::uint64_t at, std::vector<PacketRecord>& entries) {
  const std::uint64_t room = size - at;
  std::array<std::byte, 12> head{};
  if (room < head.size()) return "it is cut off";
  read(at, head);
  const bool plain = std::memcmp(head.data() + 8, "FTAB", 4) == 0;
  const std::uint32_t magic = u32_at(head, 0);
  if (!plain && magic != lz4_magic && magic != zstd_magic) return fmt::format("there is none at its position {}", at);

  // Every packet takes 9 bytes at least and its entry some 50, so a table cannot be longer than this.
  const std::uint64_t limit =
      std::min<std::uint64_t>((at - data_begin) / 9 * 128 + 4096, std::numeric_limits<std::int32_t>::max() - 64);
  if (room > limit) return fmt::format("it has {} bytes for packets of {}", room, at - data_begin);
  PacketBuffer& raw = plain ? content : stored;
  raw.grow(static_cast<std::size_t>(room), 0);
  const std::span<std::byte> bytes(raw.data(), static_cast<std::size_t>(room));
  read(at, bytes);
  std::size_t table_size = bytes.size();
  if (!plain) {
    const Compression method = magic == lz4_magic ? Compression::lz4 : Compression::zstd;
    const Decompressed result = decompressor.decompress(method, bytes, content, static_cast<std::size_t>(limit));
    if (!result.whole) return "it does not decompress";
    table_size = result.size;
  }
  return decode_table(content, table_size, entries) == Contents::whole ? "" : "it does not decode as an FTAB table";
}

/// From header to header up to `end`, a data table, or what can be no packet.
Walk RecordingReader::State::walk(std::uint64_t end) {
  Walk walked;
  std::uint64_t at = data_begin;
  std::uint64_t empty_at_end = 0;
  while (end - at >= packet_header_size) {
    std::array<std::byte, packet_header_size + 4> bytes{};
    const std::span<std::byte> head =
        std::span(bytes).first(static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), end - at)));
    read(at, head);
    if (end == size && table_starts_at(at, head)) {
      walked.at_table = true;
      break;
    }
    std::int32_t id = 0;
    std::int32_t payload_size = 0;
    std::memcpy(&id, head.data(), sizeof id);
    std::memcpy(&payload_size, head.data() + sizeof id, sizeof payload_size);
    if (payload_size < 0 || static_cast<std::uint64_t>(payload_size) > end - at - packet_header_size) break;
    const auto length = static_cast<std::uint32_t>(payload_size);
    if (declared(id) == nullptr && !may_be_payload(head.subspan(packet_header_size), length)) break;
    if (length == 0) {
      ++walked.empty;
      ++empty_at_end;
    } else {
      empty_at_end = 0;
      walked.packets.push_back({.stream_id = id, .payload_offset = at + packet_header_size, .payload_size = length});
    }
    at += packet_header_size + length;
  }
  if (end == size && !walked.at_table && empty_at_end > 1) {  // the zeros that a power cut leaves behind
    walked.empty -= empty_at_end;
    at -= empty_at_end * packet_header_size;
  }
  walked.end = at;
  return walked;
}

bool RecordingReader::State::table_starts_at(std::uint64_t at, std::span<const std::byte> head) {
  const bool plain = head.size() >= 12 && std::memcmp(head.data() + 8, "FTAB", 4) == 0;
  const std::uint32_t magic = u32_at(head, 0);
  const bool compressed = (magic == lz4_magic || magic == zstd_magic) && declared(static_cast<std::int32_t>(magic)) == nullptr;
  if (!plain && !compressed) return false;
  if (static_cast<std::int64_t>(at) == header.table_position) return true;  // sound or not, the header says so too
  std::vector<PacketRecord> ignored;
  return read_table(at, ignored).empty();
}

/// Whether these first bytes can begin a packet's contents: what an undeclared stream's packet must show to be believed.
bool RecordingReader::State::may_be_payload(std::span<const std::byte> payload, std::uint32_t payload_size) const {
  if (payload_size < 12 || payload.size() < 4) return false;
  const std::uint32_t first = u32_at(payload, 0);
  switch (header.compression) {
    case Compression::none:
      return first <= payload_size - 4 && first >= 8;
    case Compression::lz4:
    case Compression::lz4_high:
      return first == lz4_magic;
    case Compression::zstd:
    case Compression::zstd_high:
      return first == zstd_magic;
  }
  return false;
}

/// Where the table's entries differ from what the packets' own headers say, or cannot be; nothing if they agree.
std::string RecordingReader::State::disagreement(const std::vector<PacketRecord>& entries, const Walk& walked) const {
  auto packet = walked.packets.begin();
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const PacketRecord& entry = entries[i];
    if (entry.payload_size == 0) continue;
    if (packet == walked.packets.end())
      return fmt::format("it lists more packets than the {} that the file has", walked.packets.size());
    // One known writer gives where the packet's header stands, not what is behind it.
    const bool same_place =
        entry.payload_offset == packet->payload_offset || entry.payload_offset == packet->payload_offset - packet_header_size;
    if (!same_place || entry.stream_id != packet->stream_id || entry.payload_size != packet->payload_size) {
      return fmt::format("its entry {} does not agree with the packet at byte {}", i,
                         packet->payload_offset - packet_header_size);
    }
    const Stream* stream = declared(entry.stream_id);
    std::size_t most = std::numeric_limits<std::int64_t>::max();
    if (stream != nullptr && stream->type != StreamType::other) {
      const std::size_t bytes = largest_content(header.compression, entry.payload_size);
      most = stream->type == StreamType::events ? bytes / sizeof(Event) : stream->type == StreamType::frames ? 1 : bytes / 8;
    }
    if (entry.elements < 0 || static_cast<std::uint64_t>(entry.elements) > most) {
      return fmt::format("its entry {} claims {} elements in {} bytes", i, entry.elements, entry.payload_size);
    }
    if (entry.elements > 0 && entry.last < entry.first) return fmt::format("its entry {} ends before it begins", i);
    ++packet;
  }
  if (packet != walked.packets.end()) {
    return fmt::format("it lists {} packets where the file has {}", packet - walked.packets.begin(), walked.packets.size());
  }
  return {};
}

void RecordingReader::State::take(const Walk& walked) {
  problems.empty_packets = walked.empty;
  for (const PacketRecord& packet : walked.packets) {
    if (declared(packet.stream_id) != nullptr) {
      records.push_back(packet);
    } else {
      ++problems.undeclared_packets;
    }
  }
  notes.resize(records.size());
}

/// Completes the records by the table's entries, which agree with them.
void RecordingReader::State::take_table(std::vector<PacketRecord> entries) {
  index = PacketIndex::table;
  std::size_t i = 0;
  for (const PacketRecord& entry : entries) {
    if (entry.payload_size == 0 || declared(entry.stream_id) == nullptr) continue;
    PacketRecord& record = records[i];
    record.elements = entry.elements;
    record.first = entry.first;
    record.last = entry.last;
    if (record.elements > 0) {
      StreamTime& time = times[record.stream_id];
      const std::int64_t shift = time.shift_at(record.first);
      shift_time(record.first, shift);
      shift_time(record.last, shift);
      notes[i].shift = shift;
      if (shift != 0) ++problems.unwrapped_packets;
      time = {.begun = true, .last = record.last, .shift = shift};
    }
    ++i;
  }
}

/// Completes the records by decoding every packet once.
void RecordingReader::State::scan() {
  scanning = true;
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

std::size_t RecordingReader::State::index_of(const PacketRecord& packet, StreamType type) const {
  const auto by_offset = [](const PacketRecord& a, std::uint64_t offset) { return a.payload_offset < offset; };
  const auto found = std::lower_bound(records.begin(), records.end(), packet.payload_offset, by_offset);
  if (found == records.end() || found->payload_offset != packet.payload_offset) {
    throw Error(fmt::format("{}: has no packet at byte {}; expected one of its own", name, packet.payload_offset));
  }
  const Stream& stream = *declared(found->stream_id);
  if (stream.type != type) {
    throw Error(fmt::format("{}: stream {} holds {}; expected {}", name, stream.id, name_of(stream.type), name_of(type)));
  }
  return static_cast<std::size_t>(found - records.begin());
}

/// Brings a packet's contents to the front of `content`; false if they do not decompress.
bool RecordingReader::State::load(const PacketRecord& record, std::size_t& content_size) {
  if (header.compression == Compression::none) {
    content.grow(record.payload_size, 0);
    read(record.payload_offset, {content.data(), record.payload_size});
    content_size = record.payload_size;
    return true;
  }
  stored.grow(record.payload_size, 0);
  const std::span<std::byte> bytes(stored.data(), record.payload_size);
  read(record.payload_offset, bytes);
  const std::size_t limit = largest_content(header.compression, bytes.size());
  const Decompressed result = decompressor.decompress(header.compression, bytes, content, limit);
  content_size = result.size;
  return result.whole;
}

template <class Decode>
bool RecordingReader::State::decode(std::size_t i, const Decode& decode_content) {
  std::size_t content_size = 0;
  const Contents contents = load(records[i], content_size) ? decode_content(content_size) : Contents::broken;
  if (contents != Contents::whole && !std::exchange(notes[i].counted, true)) {
    ++(contents == Contents::broken ? problems.broken_packets : problems.mismatched_packets);
  }
  return contents == Contents::whole;
}

/// Adds 2^32 us once for every wrap of the stream so far. In a scan this is also where the wraps between packets are found.
template <class Element>
void RecordingReader::State::put_times_right(std::size_t i, std::span<Element> elements) {
  if (elements.empty()) return;
  StreamTime& time = times[records[i].stream_id];
  if (scanning) notes[i].shift = time.shift_at(elements.front().t);
  std::int64_t shift = notes[i].shift;
  CameraTime previous = after(elements.front().t, microseconds{shift});
  if (shift == 0 && is_ascending(std::span<const Element>(elements))) {
    previous = elements.back().t;
  } else {
    for (Element& element : elements) {
      if (is_wrap(previous, after(element.t, microseconds{shift}))) shift += wrap;
      if (shift != 0) shift_times(element, shift);
      previous = element.t;
    }
  }
  if (scanning) time = {.begun = true, .last = previous, .shift = shift};
  const bool known = !scanning && notes[i].shift != 0;  // counted when the table was taken
  if (shift != 0 && !known && !notes[i].counted) ++problems.unwrapped_packets;
}

/// Drops what lies outside the sensor or has no polarity, in place. The first pass looks without a branch, for most packets are
/// sound.
std::span<Event> RecordingReader::State::sound_events(std::size_t i, std::span<Event> events) {
  constexpr int most = std::numeric_limits<std::int16_t>::max() + 1;
  const SensorSize size_of_sensor = declared(records[i].stream_id)->size.value_or(SensorSize{.width = most, .height = most});
  const auto width = static_cast<std::uint32_t>(std::min(size_of_sensor.width, most));
  const auto height = static_cast<std::uint32_t>(std::min(size_of_sensor.height, most));
  const auto is_bad = [=](const Event& e) {
    return (static_cast<std::uint16_t>(e.x) >= width) | (static_cast<std::uint16_t>(e.y) >= height) | (e.on > 1);
  };
  unsigned bad = 0;
  for (const Event& event : events) bad |= static_cast<unsigned>(is_bad(event));
  if (bad == 0) return events;
  const auto kept_end = std::remove_if(events.begin(), events.end(), is_bad);
  const auto kept = static_cast<std::size_t>(kept_end - events.begin());
  if (!notes[i].counted) problems.out_of_range_events += events.size() - kept;
  return events.first(kept);
}

std::span<Event> RecordingReader::State::events(std::size_t i) {
  std::span<Event> events;
  if (!decode(i, [&](std::size_t length) { return decode_events(content, length, events); })) return {};
  events = sound_events(i, events);
  put_times_right(i, events);
  notes[i].counted = true;
  return events;
}

std::vector<ImuSample> RecordingReader::State::imu(std::size_t i) {
  std::vector<ImuSample> samples;
  if (!decode(i, [&](std::size_t length) { return decode_imu(content, length, samples); })) return {};
  put_times_right(i, std::span<ImuSample>(samples));
  notes[i].counted = true;
  return samples;
}

std::vector<Trigger> RecordingReader::State::triggers(std::size_t i) {
  std::vector<Trigger> result;
  if (!decode(i, [&](std::size_t length) { return decode_triggers(content, length, result); })) return {};
  put_times_right(i, std::span<Trigger>(result));
  notes[i].counted = true;
  return result;
}

std::optional<Frame> RecordingReader::State::frame(std::size_t i) {
  Frame picture;
  if (!decode(i, [&](std::size_t length) { return decode_frame(content, length, picture); })) return {};
  put_times_right(i, std::span<Frame>(&picture, 1));
  notes[i].counted = true;
  return picture;
}

RecordingReader::RecordingReader(fs::path file) : state_(std::make_unique<State>()) {
  state_->path = std::move(file);
  state_->open();
}
RecordingReader::~RecordingReader() = default;
RecordingReader::RecordingReader(RecordingReader&&) noexcept = default;
RecordingReader& RecordingReader::operator=(RecordingReader&&) noexcept = default;

const fs::path& RecordingReader::file() const { return state_->path; }
std::uint64_t RecordingReader::file_size() const { return state_->size; }
Compression RecordingReader::compression() const { return state_->header.compression; }
std::span<const Stream> RecordingReader::streams() const { return state_->header.streams; }
std::span<const PacketRecord> RecordingReader::packets() const { return state_->records; }
PacketIndex RecordingReader::index() const { return state_->index; }
const RecordingProblems& RecordingReader::problems() const { return state_->problems; }

const Stream& RecordingReader::stream(std::int32_t id) const {
  const Stream* found = state_->declared(id);
  if (found != nullptr) return *found;
  std::string ids;
  for (const Stream& stream : streams()) ids += (ids.empty() ? "" : ", ") + std::to_string(stream.id);
  throw Error(fmt::format("{}: has no stream {}; expected one of {}", state_->name, id, ids));
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
