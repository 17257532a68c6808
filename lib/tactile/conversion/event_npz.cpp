#include "tactile/conversion/event_npz.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <zlib.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/events/file_descriptor.hpp"

namespace tactile::conversion {
namespace {

constexpr std::size_t record_bytes = 13;
constexpr std::size_t buffered_records = 65'536;
constexpr std::size_t array_head_bytes = 192;  // a multiple of 64, as NumPy aligns data, with room for any count
constexpr std::uint32_t no_size = 0xFFFFFFFF;  // the real size is in the 64-bit field
constexpr std::uint16_t zip_version = 45;      // 64-bit sizes
constexpr std::uint16_t first_day = 0x0021;    // 1 January 1980, the earliest date that ZIP knows

/// Appends a value's bytes. All supported machines are little-endian.
template <class T>
void put(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// The head before an array's values, `size` bytes long.
std::string array_head(std::string_view type, std::string_view shape, std::size_t size) {
  std::string head("\x93NUMPY\x01\x00", 8);
  const std::string text = fmt::format("{{'descr': {}, 'fortran_order': False, 'shape': ({},), }}", type, shape);
  put(head, static_cast<std::uint16_t>(size - head.size() - 2));
  head += text;
  head.resize(size - 1, ' ');
  return head + '\n';
}

std::string event_array_head(std::uint64_t events) {
  return array_head("[('t_us', '<i8'), ('x', '<u2'), ('y', '<u2'), ('on', '|u1')]", std::to_string(events), array_head_bytes);
}

struct Entry {
  std::string name;
  std::uint64_t offset = 0;  ///< of its local header
  std::uint64_t size = 0;    ///< of its contents
  std::uint32_t crc = 0;
};

/// The common part of an entry's local and central header.
void put_common(std::string& bytes, const Entry& entry, std::uint16_t extra_size) {
  put<std::uint16_t>(bytes, zip_version);
  put<std::uint16_t>(bytes, 0);  // flags
  put<std::uint16_t>(bytes, 0);  // stored
  put<std::uint16_t>(bytes, 0);  // midnight
  put<std::uint16_t>(bytes, first_day);
  put<std::uint32_t>(bytes, entry.crc);
  put<std::uint32_t>(bytes, no_size);
  put<std::uint32_t>(bytes, no_size);
  put<std::uint16_t>(bytes, static_cast<std::uint16_t>(entry.name.size()));
  put<std::uint16_t>(bytes, extra_size);
}

void put_sizes(std::string& bytes, const Entry& entry, std::uint16_t field_size) {
  put<std::uint16_t>(bytes, 1);  // the 64-bit field
  put<std::uint16_t>(bytes, field_size);
  put<std::uint64_t>(bytes, entry.size);
  put<std::uint64_t>(bytes, entry.size);
}

std::string local_header(const Entry& entry) {
  std::string bytes;
  put<std::uint32_t>(bytes, 0x04034b50);
  put_common(bytes, entry, 20);
  bytes += entry.name;
  put_sizes(bytes, entry, 16);
  return bytes;
}

std::string central_header(const Entry& entry) {
  std::string bytes;
  put<std::uint32_t>(bytes, 0x02014b50);
  put<std::uint16_t>(bytes, (3 << 8) | zip_version);  // made on Unix
  put_common(bytes, entry, 28);
  put<std::uint16_t>(bytes, 0);               // no comment
  put<std::uint16_t>(bytes, 0);               // first disk
  put<std::uint16_t>(bytes, 0);               // no text
  put<std::uint32_t>(bytes, 0100644U << 16);  // a plain file
  put<std::uint32_t>(bytes, no_size);         // its real place is in the 64-bit field
  bytes += entry.name;
  put_sizes(bytes, entry, 24);
  put<std::uint64_t>(bytes, entry.offset);
  return bytes;
}

std::string archive_end(std::uint64_t entries, std::uint64_t directory_at, std::uint64_t directory_size) {
  std::string bytes;
  put<std::uint32_t>(bytes, 0x06064b50);
  put<std::uint64_t>(bytes, 44);  // of the rest of this record
  put<std::uint16_t>(bytes, (3 << 8) | zip_version);
  put<std::uint16_t>(bytes, zip_version);
  put<std::uint32_t>(bytes, 0);
  put<std::uint32_t>(bytes, 0);
  put<std::uint64_t>(bytes, entries);
  put<std::uint64_t>(bytes, entries);
  put<std::uint64_t>(bytes, directory_size);
  put<std::uint64_t>(bytes, directory_at);
  put<std::uint32_t>(bytes, 0x07064b50);  // the place of that record
  put<std::uint32_t>(bytes, 0);
  put<std::uint64_t>(bytes, directory_at + directory_size);
  put<std::uint32_t>(bytes, 1);
  put<std::uint32_t>(bytes, 0x06054b50);  // the end record for old readers
  put<std::uint16_t>(bytes, 0);
  put<std::uint16_t>(bytes, 0);
  put<std::uint16_t>(bytes, 0xFFFF);
  put<std::uint16_t>(bytes, 0xFFFF);
  put<std::uint32_t>(bytes, no_size);
  put<std::uint32_t>(bytes, no_size);
  put<std::uint16_t>(bytes, 0);
  return bytes;
}

std::uint32_t crc_of(std::string_view bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

}  // namespace

struct EventNpzWriter::State {
  std::string name;  ///< for errors
  events::SensorSize size;
  events::FileDescriptor file;
  std::uint64_t end = 0;  ///< of what was written [B]
  std::uint64_t events = 0, steps_back = 0;
  CameraTime previous = CameraTime::min();
  uLong crc = 0;             ///< of the records
  std::vector<char> buffer;  ///< records that wait

  void write_at(std::uint64_t offset, std::string_view bytes) const {
    if (file.write_at(offset, std::as_bytes(std::span(bytes)))) return;
    throw Error(fmt::format("{}: cannot be written ({}); expected a place with room", name, std::strerror(errno)));
  }
  void append(std::string_view bytes) {
    write_at(end, bytes);
    end += bytes.size();
  }
  void put_waiting() {
    const std::string_view bytes(buffer.data(), buffer.size());
    crc = crc32_z(crc, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
    append(bytes);
    buffer.clear();
  }
};

EventNpzWriter::EventNpzWriter(const std::filesystem::path& file, events::SensorSize size) : state_(std::make_unique<State>()) {
  State& state = *state_;
  state.name = file.string();
  state.size = size;
  state.file = events::FileDescriptor(::open(file.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
  if (!state.file.is_open())
    throw Error(fmt::format("{}: cannot be made ({}); expected a writable folder", state.name, std::strerror(errno)));
  state.buffer.reserve(buffered_records * record_bytes);
  state.append(local_header({.name = "events.npy"}) + event_array_head(0));
}

EventNpzWriter::~EventNpzWriter() = default;
EventNpzWriter::EventNpzWriter(EventNpzWriter&&) noexcept = default;
EventNpzWriter& EventNpzWriter::operator=(EventNpzWriter&&) noexcept = default;

void EventNpzWriter::write(std::span<const events::Event> events) {
  State& state = *state_;
  for (const events::Event& event : events) {
    if (event.t < state.previous) ++state.steps_back;
    state.previous = event.t;
    if (state.buffer.size() == buffered_records * record_bytes) state.put_waiting();
    std::array<char, record_bytes> record;
    const std::int64_t t = us_of(event.t);
    std::memcpy(record.data(), &t, 8);
    std::memcpy(record.data() + 8, &event.x, 2);
    std::memcpy(record.data() + 10, &event.y, 2);
    std::memcpy(record.data() + 12, &event.on, 1);
    state.buffer.insert(state.buffer.end(), record.begin(), record.end());
  }
  state.events += events.size();
}

std::uint64_t EventNpzWriter::steps_back() const { return state_->steps_back; }

void EventNpzWriter::close() {
  State& state = *state_;
  state.put_waiting();
  const std::string head = event_array_head(state.events);
  Entry events{.name = "events.npy", .offset = 0, .size = head.size() + state.events * record_bytes};
  events.crc =
      static_cast<std::uint32_t>(crc32_combine(crc_of(head), state.crc, static_cast<z_off_t>(state.events * record_bytes)));
  state.write_at(0, local_header(events) + head);

  std::string size = array_head("'<i4'", "2", 128);
  put(size, static_cast<std::int32_t>(state.size.width));
  put(size, static_cast<std::int32_t>(state.size.height));
  const Entry sensor{.name = "sensor_size.npy", .offset = state.end, .size = size.size(), .crc = crc_of(size)};
  state.append(local_header(sensor) + size);

  const std::string directory = central_header(events) + central_header(sensor);
  const std::uint64_t directory_at = state.end;
  state.append(directory + archive_end(2, directory_at, directory.size()));
  state.file.reset();
}

}  // namespace tactile::conversion
