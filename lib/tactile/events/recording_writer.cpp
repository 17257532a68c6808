#include "tactile/events/recording_writer.hpp"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <future>
#include <limits>
#include <string_view>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/start_beside.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/event_checks.hpp"
#include "tactile/events/file_descriptor.hpp"
#include "tactile/events/packet_batch.hpp"
#include "tactile/events/packet_checksums.hpp"
#include "tactile/events/packet_compression.hpp"
#include "tactile/events/packet_contents.hpp"
#include "tactile/events/packet_table.hpp"
#include "tactile/events/recording_header.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::events {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t most_packet_events = (packet_limit - event_packet_head) / sizeof(Event);
/// The format of the table does not allow more entries. Then the file has no table, and readers scan it.
constexpr std::size_t most_table_entries = 30'000'000;

/// The waiting elements of one stream.
struct Waiting {
  Stream stream;
  WrittenStream written;
  std::size_t count = 0;
  CameraTime first, last;  ///< of the waiting elements
  bool begun = false;      ///< elements were added before
  CameraTime newest;       ///< of all so far
  PacketBuffer events;     ///< the next packet: its header, the head of its contents, the events
  std::vector<ImuSample> imu;
  std::vector<Trigger> triggers;
};

}  // namespace

struct RecordingWriter::State {
  fs::path path;
  std::string name;  ///< for errors
  RecordingWriterOptions options;
  FileDescriptor file;
  PacketChecksumWriter checksums;
  std::uint64_t end = 0;             ///< of the last whole packet [B]
  std::uint64_t position_field = 0;  ///< where the header has the table's position [B]
  std::vector<Waiting> streams;
  PacketTable table;
  PacketBuffer content;
  PacketBatch full{Compression::none, 1}, being_written{Compression::none, 1};
  PacketCompressor compressor;  ///< of the table
  std::future<void> writing;    ///< of `being_written`; the last member, so that it ends first

  ~State() {
    try {
      close();
    } catch (const std::exception&) {
      // A destructor cannot report it. The file is readable nevertheless.
    }
  }

  void open(const std::vector<Stream>& declared);
  void check_streams(const std::vector<Stream>& declared) const;
  Waiting& waiting(std::int32_t id, StreamType type);
  template <class Element>
  void check_times(const Waiting& stream, std::span<const Element> elements) const;
  void check_events(const Waiting& stream, std::span<const Event> events) const;
  template <class Element, class Append>
  void gather(Waiting& stream, std::span<const Element> elements, const Append& append);
  void append_events(Waiting& stream, std::span<const Event> events) const;
  void write_waiting(Waiting& stream);
  void take_packet(const PacketRecord& record, PacketBuffer& packet, std::size_t content_size);
  void write_if_full();
  void begin_writing();
  void finish_writing();
  void write(PacketBatch& batch);
  void write_table();
  void write_at(std::uint64_t offset, std::span<const std::byte> bytes) const;
  void sync();
  void cut_to_end() const;
  void write_all_waiting();
  void flush();
  void close();
};

void RecordingWriter::State::check_streams(const std::vector<Stream>& declared) const {
  if (path.extension() != ".aedat4") throw Error(name + ": does not end in .aedat4, which readers require; expected such a name");
  if (declared.empty()) throw Error(name + ": no stream to write; expected at least one");
  for (std::size_t i = 0; i < declared.size(); ++i) {
    const Stream& stream = declared[i];
    check_readable_by_vendor(stream, name);
    for (std::size_t other = 0; other < i; ++other) {
      if (declared[other].id != stream.id) continue;
      throw Error(fmt::format("{}: stream {} is declared twice; expected different ids", name, stream.id));
    }
  }
}

void RecordingWriter::State::open(const std::vector<Stream>& declared) {
  name = path.string();
  check_streams(declared);
  if (options.packet_span <= microseconds{0}) throw Error(name + ": a packet's span is not positive; expected at least 1 us");
  if (options.packet_events < 1 || options.packet_events > most_packet_events) {
    throw Error(fmt::format("{}: {} events a packet; expected 1 to {}", name, options.packet_events, most_packet_events));
  }
  const HeaderImage header = header_image(options.compression, declared);
  file = FileDescriptor(::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
  if (!file.is_open() && errno == EEXIST) throw Error(name + ": exists already; expected the name of a new file");
  if (!file.is_open()) throw Error(name + ": cannot be made (" + std::strerror(errno) + "); expected a writable folder");
  const std::string start = std::string(magic_line) + header.bytes;
  if (!file.write_at(0, std::as_bytes(std::span(start)))) {
    const std::string why = std::strerror(errno);
    file.reset();
    ::unlink(path.c_str());
    throw Error(name + ": its header cannot be written (" + why + "); expected a disk with room");
  }
  end = start.size();
  table = PacketTable(end);
  position_field = magic_line.size() + header.table_position;
  for (PacketBatch* batch : {&full, &being_written}) *batch = PacketBatch(options.compression, options.threads);
  if (options.checksums) checksums = PacketChecksumWriter(checksums_beside(path));
  checksums.add_header(std::as_bytes(std::span(start)), position_field);
  sync_to_disk(path.has_parent_path() ? path.parent_path() : fs::path("."));  // so that a power cut does not remove its name
  for (const Stream& stream : declared) streams.emplace_back().stream = stream;
}

Waiting& RecordingWriter::State::waiting(std::int32_t id, StreamType type) {
  if (!file.is_open()) throw Error(name + ": is closed; expected elements before that");
  const auto found = std::find_if(streams.begin(), streams.end(), [id](const Waiting& w) { return w.stream.id == id; });
  if (found == streams.end()) throw Error(fmt::format("{}: declares no stream {}; expected a declared stream", name, id));
  if (found->stream.type != type) {
    throw Error(fmt::format("{}: stream {} holds {}, not {}", name, id, name_of(found->stream.type), name_of(type)));
  }
  return *found;
}

template <class Element>
void RecordingWriter::State::check_times(const Waiting& stream, std::span<const Element> elements) const {
  bool any = stream.begun;
  CameraTime newest = stream.newest;
  for (const Element& element : elements) {
    if (any && element.t < newest) {
      throw Error(fmt::format("{}: stream {} goes back in time, from {} to {} us; expected times that never fall", name,
                              stream.stream.id, us_of(newest), us_of(element.t)));
    }
    newest = element.t;
    any = true;
  }
}

void RecordingWriter::State::check_events(const Waiting& stream, std::span<const Event> events) const {
  const SensorSize size = *stream.stream.size;
  const EventsCheck check = tactile::events::check_events(events, size);
  const bool continues = events.empty() || !stream.begun || events.front().t >= stream.newest;
  if (check.inside && check.ascending && continues) return;
  check_times(stream, events);  // this or the loop finds the error
  for (const Event& e : events) {
    if (!is_outside(e, size)) continue;
    if (e.on > 1)
      throw Error(fmt::format("{}: stream {} has an event of polarity {}; expected 0 or 1", name, stream.stream.id, e.on));
    throw Error(fmt::format("{}: stream {} has an event at ({}, {}); expected it inside {} x {}", name, stream.stream.id, e.x,
                            e.y, size.width, size.height));
  }
}

/// Divides the checked elements into packets, and passes each piece to `append`.
template <class Element, class Append>
void RecordingWriter::State::gather(Waiting& stream, std::span<const Element> elements, const Append& append) {
  while (!elements.empty()) {
    const CameraTime first = stream.count == 0 ? elements.front().t : stream.first;
    const auto in_packet = [&](const Element& e) { return between(first, e.t) < options.packet_span; };
    const auto in_time = std::partition_point(elements.begin(), elements.end(), in_packet) - elements.begin();
    const std::size_t taken = std::min(static_cast<std::size_t>(in_time), options.packet_events - stream.count);
    if (taken == 0) {
      write_waiting(stream);
      continue;
    }
    append(elements.first(taken));
    stream.first = first;
    stream.last = stream.newest = elements[taken - 1].t;
    stream.begun = true;
    stream.count += taken;
    elements = elements.subspan(taken);
    if (stream.count == options.packet_events) write_waiting(stream);
  }
}

/// Appends events to the waiting packet. Padding is cleared, because equal events must give equal bytes.
void RecordingWriter::State::append_events(Waiting& stream, std::span<const Event> events) const {
  constexpr std::size_t head = packet_header_size + event_packet_head;
  const std::size_t used = head + stream.count * sizeof(Event);
  const std::size_t needed = used + events.size_bytes();
  if (needed > stream.events.capacity()) {
    stream.events.grow(std::min(std::max(2 * needed, std::size_t{4096}), head + options.packet_events * sizeof(Event)), used);
  }
  constexpr std::uint64_t all_but_padding = (std::uint64_t{1} << 40) - 1;  // of an event's second half
  std::byte* place = stream.events.data() + used;
  for (const Event& event : events) {
    std::array<std::uint64_t, 2> halves;
    std::memcpy(halves.data(), &event, sizeof event);
    halves[1] &= all_but_padding;
    std::memcpy(place, halves.data(), sizeof event);
    place += sizeof event;
  }
}

void RecordingWriter::State::write_waiting(Waiting& stream) {
  if (stream.count == 0) return;
  const PacketRecord record{.stream_id = stream.stream.id,
                            .elements = static_cast<std::int64_t>(stream.count),
                            .first = stream.first,
                            .last = stream.last};
  std::size_t size = 0;
  switch (stream.stream.type) {
    case StreamType::events:
      write_event_packet_head(stream.events.data() + packet_header_size, stream.count);
      size = event_packet_head + stream.count * sizeof(Event);
      break;
    case StreamType::imu:
      size = encode_imu(stream.imu, content, packet_header_size);
      break;
    default:
      size = encode_triggers(stream.triggers, content, packet_header_size);
      break;
  }
  take_packet(record, stream.stream.type == StreamType::events ? stream.events : content, size);
  stream.count = 0;
  stream.imu.clear();
  stream.triggers.clear();
  write_if_full();
}

void RecordingWriter::State::write(PacketBatch& batch) {
  batch.write_all([this](const PacketRecord& record, std::span<const std::byte> bytes) {
    write_at(end, bytes);  // one write, so that only a kill during it leaves an incomplete packet
    checksums.add_packet(end, bytes);
    end += bytes.size();
    table.add(record);
    const auto of_stream = [&](const Waiting& each) { return each.stream.id == record.stream_id; };
    WrittenStream& stream = std::find_if(streams.begin(), streams.end(), of_stream)->written;
    if (stream.elements == 0) stream.first = record.first;
    stream.last = record.last;
    stream.elements += static_cast<std::uint64_t>(record.elements);
    ++stream.packets;
  });
}

/// Ends what `begin_writing` began, also what an error of the disk has left.
void RecordingWriter::State::finish_writing() {
  if (writing.valid()) writing.get();
  write(being_written);
}

/// Writes the full packets; with several threads, beside the caller, who can fill further ones.
void RecordingWriter::State::begin_writing() {
  finish_writing();
  std::swap(full, being_written);
  writing = start_beside(options.compression == Compression::none ? 1 : options.threads, [this] { write(being_written); });
}

/// Takes a packet; the caller then calls `write_if_full`. @param packet  its memory is replaced by other
void RecordingWriter::State::take_packet(const PacketRecord& record, PacketBuffer& packet, std::size_t content_size) {
  write_if_full();  // an error of the disk may have left it full
  full.add(record, packet, content_size);
}

void RecordingWriter::State::write_if_full() {
  if (full.is_full()) begin_writing();
}

void RecordingWriter::State::write_table() {
  std::uint64_t at = end;
  compressor.compress_pieces(
      options.compression, table.content_size(), [&](const ByteSink& sink) { table.write_contents(sink); },
      [&](std::span<const std::byte> piece) {
        write_at(at, piece);
        at += piece.size();
      });
  end = at;
}

void RecordingWriter::State::write_at(std::uint64_t offset, std::span<const std::byte> bytes) const {
  if (file.write_at(offset, bytes)) return;
  throw Error(name + ": cannot be written (" + std::strerror(errno) + "); expected a disk with room");
}

void RecordingWriter::State::sync() {
  if (::fsync(file.number()) != 0 && errno != EINVAL && errno != EROFS)
    throw Error(name + ": cannot be synced (" + std::strerror(errno) + "); expected a working disk");
  checksums.sync();
}

/// A packet whose writing failed may extend beyond the end of the later ones.
void RecordingWriter::State::cut_to_end() const {
  if (::ftruncate(file.number(), static_cast<off_t>(end)) == 0) return;
  throw Error(name + ": cannot be cut to its length (" + std::strerror(errno) + "); expected a writable file");
}

void RecordingWriter::State::write_all_waiting() {
  if (!file.is_open()) return;
  for (Waiting& stream : streams) write_waiting(stream);
  begin_writing();
  finish_writing();
}

void RecordingWriter::State::flush() {
  if (!file.is_open()) return;
  write_all_waiting();
  sync();
}

void RecordingWriter::State::close() {
  if (!file.is_open()) return;
  struct Shut {
    State& state;
    ~Shut() {
      if (state.writing.valid()) state.writing.wait();
      state.file.reset();
    }
  } const shut{*this};
  std::exception_ptr failure;  // the first one, thrown when the file is as complete as possible
  const auto attempt = [&](const auto& work) {
    try {
      work();
    } catch (const Error&) {
      if (!failure) failure = std::current_exception();
    }
  };
  attempt([&] {
    if (writing.valid()) writing.get();
  });
  attempt([&] { write_all_waiting(); });
  cut_to_end();
  const std::uint64_t table_at = end;
  checksums.add_end(end);
  bool has_table = table.packets() <= most_table_entries;
  if (has_table) {
    try {
      write_table();
    } catch (const Error&) {
      if (!failure) failure = std::current_exception();
      has_table = false;
      cut_to_end();
    }
  }
  sync();
  if (has_table) {
    const auto position = static_cast<std::int64_t>(table_at);
    write_at(position_field, std::as_bytes(std::span(&position, 1)));
    sync();
  }
  if (failure) std::rethrow_exception(failure);
}

RecordingWriter::RecordingWriter(const fs::path& file, const std::vector<Stream>& streams, RecordingWriterOptions options)
    : state_(std::make_unique<State>()) {
  state_->path = file;
  state_->options = options;
  state_->open(streams);
}
RecordingWriter::~RecordingWriter() = default;
RecordingWriter::RecordingWriter(RecordingWriter&&) noexcept = default;
RecordingWriter& RecordingWriter::operator=(RecordingWriter&&) noexcept = default;

void RecordingWriter::write_events(std::int32_t stream_id, std::span<const Event> events) {
  Waiting& stream = state_->waiting(stream_id, StreamType::events);
  state_->check_events(stream, events);
  state_->gather(stream, events, [&](std::span<const Event> piece) { state_->append_events(stream, piece); });
}

void RecordingWriter::write_imu(std::int32_t stream_id, std::span<const ImuSample> samples) {
  Waiting& stream = state_->waiting(stream_id, StreamType::imu);
  state_->check_times(stream, samples);
  state_->gather(stream, samples,
                 [&](std::span<const ImuSample> piece) { stream.imu.insert(stream.imu.end(), piece.begin(), piece.end()); });
}

void RecordingWriter::write_triggers(std::int32_t stream_id, std::span<const Trigger> triggers) {
  Waiting& stream = state_->waiting(stream_id, StreamType::triggers);
  state_->check_times(stream, triggers);
  state_->gather(stream, triggers, [&](std::span<const Trigger> piece) {
    stream.triggers.insert(stream.triggers.end(), piece.begin(), piece.end());
  });
}

void RecordingWriter::write_frame(std::int32_t stream_id, const Frame& frame) {
  Waiting& stream = state_->waiting(stream_id, StreamType::frames);
  state_->check_times(stream, std::span(&frame, 1));
  const std::size_t pixel = bytes_per_pixel(frame.format);
  const auto pixels =
      static_cast<std::size_t>(std::max<int>(frame.width, 0)) * static_cast<std::size_t>(std::max<int>(frame.height, 0));
  if (pixel == 0 || frame.width < 0 || frame.height < 0 || frame.pixels.size() != pixel * pixels) {
    throw Error(
        fmt::format("{}: stream {} has a frame of {} x {} in format {} with {} bytes; expected one value per pixel and channel",
                    state_->name, stream_id, frame.width, frame.height, frame.format, frame.pixels.size()));
  }
  if (frame.pixels.size() > packet_limit - 4096) {
    throw Error(fmt::format("{}: stream {} has a frame of {} bytes; expected at most {}", state_->name, stream_id,
                            frame.pixels.size(), packet_limit - 4096));
  }
  const std::size_t size = encode_frame(frame, state_->content, packet_header_size);
  state_->take_packet({.stream_id = stream_id, .elements = 1, .first = frame.t, .last = frame.t}, state_->content, size);
  stream.newest = frame.t;
  stream.begun = true;
  state_->write_if_full();
}

void RecordingWriter::write_waiting() { state_->write_all_waiting(); }
void RecordingWriter::flush() { state_->flush(); }
void RecordingWriter::close() { state_->close(); }

std::vector<WrittenStream> RecordingWriter::written() const {
  if (state_->writing.valid()) state_->writing.wait();
  std::vector<WrittenStream> all;
  for (const Waiting& stream : state_->streams) all.push_back(stream.written);
  return all;
}

Stream event_stream_declaration(SensorSize size, std::string source) {
  return {.id = 0,
          .type = StreamType::events,
          .type_identifier = std::string(identifier_of(StreamType::events)),
          .source = std::move(source),
          .name = "events",
          .size = size,
          .info = {}};
}

}  // namespace tactile::events
