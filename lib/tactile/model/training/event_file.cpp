#include "tactile/model/training/event_file.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <string_view>
#include <system_error>

#include "tactile/core/error.hpp"
#include "tactile/core/make_folders.hpp"

namespace tactile::model {
namespace {

namespace fs = std::filesystem;

/// Castagnoli's polynomial, bits reflected.
constexpr std::array<std::uint32_t, 256> crc32c_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t byte = 0; byte < table.size(); ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0x82f63b78U : 0U);
    table.at(byte) = crc;
  }
  return table;
}

std::uint32_t masked_crc32c(std::string_view bytes) {
  static constexpr std::array<std::uint32_t, 256> table = crc32c_table();
  std::uint32_t crc = ~0U;
  for (const char byte : bytes) crc = (crc >> 8) ^ table.at((crc ^ static_cast<unsigned char>(byte)) & 0xffU);
  return std::rotr(~crc, 15) + 0xa282ead8U;
}

template <class Unsigned>
std::string little_endian(Unsigned value) {
  std::string bytes;
  for (std::size_t i = 0; i < sizeof(value); ++i) bytes += static_cast<char>((value >> (8 * i)) & 0xffU);
  return bytes;
}

std::string record_of(const std::string& bytes) {
  const std::string length = little_endian(std::uint64_t{bytes.size()});
  return length + little_endian(masked_crc32c(length)) + bytes + little_endian(masked_crc32c(bytes));
}

// Fields of protobuf: a key, 8 * number + type, then the value. Types: 0 variable length, 1 eight bytes, 2 text or message,
// 5 four bytes.

std::string varint(std::uint64_t value) {
  std::string bytes;
  for (; value >= 0x80; value >>= 7) bytes += static_cast<char>((value & 0x7f) | 0x80);
  return bytes + static_cast<char>(value);
}

std::string integer_field(unsigned number, std::uint64_t value) { return varint(8 * number) + varint(value); }
std::string text_field(unsigned number, const std::string& text) { return varint(8 * number + 2) + varint(text.size()) + text; }

std::string double_field(unsigned number, double value) {
  return varint(8 * number + 1) + little_endian(std::bit_cast<std::uint64_t>(value));
}

std::string float_field(unsigned number, float value) {
  return varint(8 * number + 5) + little_endian(std::bit_cast<std::uint32_t>(value));
}

double wall_time_now() { return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count(); }

constexpr std::string_view name_part = "tfevents";

void write_record(int file, const std::string& record, const fs::path& path) {
  std::string_view rest = record;
  while (!rest.empty()) {
    const ssize_t written = ::write(file, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw Error(path.string() + ": cannot be written (" + std::strerror(errno) + ")");
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
}

}  // namespace

std::string version_record(double wall_time) { return record_of(double_field(1, wall_time) + text_field(3, "brain.Event:2")); }

std::string restart_record(double wall_time, std::int64_t step) {
  return record_of(double_field(1, wall_time) + integer_field(2, static_cast<std::uint64_t>(step)) +
                   text_field(7, integer_field(1, 1)));
}

std::string scalars_record(double wall_time, std::int64_t step, const EventFile::Scalars& values) {
  std::string summary;
  for (const auto& [tag, value] : values) summary += text_field(1, text_field(1, tag) + float_field(2, value));
  return record_of(double_field(1, wall_time) + integer_field(2, static_cast<std::uint64_t>(step)) + text_field(5, summary));
}

EventFile::EventFile(const fs::path& folder) {
  make_folders(folder);
  const double now = wall_time_now();
  // Readers take the files of a folder in the order of their names: the seconds have ten digits until the year 2286.
  const std::string name = fmt::format("events.out.{}.{:010}.tactile.{}", name_part, static_cast<std::int64_t>(now), ::getpid());
  for (unsigned more = 0; file_ < 0; ++more) {
    path_ = folder / (name + (more == 0 ? "" : fmt::format(".{}", more)));
    file_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0666);
    if (file_ < 0 && errno != EEXIST) break;
  }
  if (file_ < 0) throw Error(path_.string() + ": cannot be made (" + std::strerror(errno) + "); expected a writable folder");
  try {
    write_record(file_, version_record(now), path_);
  } catch (const Error&) {
    ::close(file_);
    throw;
  }
}

EventFile::~EventFile() { ::close(file_); }

void EventFile::restart_at(std::int64_t step) { write_record(file_, restart_record(wall_time_now(), step), path_); }

void EventFile::add(std::int64_t step, const Scalars& scalars) {
  write_record(file_, scalars_record(wall_time_now(), step, scalars), path_);
}

bool has_event_file(const fs::path& folder) {
  std::error_code none;
  for (fs::directory_iterator entry(folder, none), end; !none && entry != end; entry.increment(none)) {
    if (entry->path().filename().string().find(name_part) != std::string::npos) return true;
  }
  return false;
}

}  // namespace tactile::model
