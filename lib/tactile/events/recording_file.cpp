#include "tactile/events/recording_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>

#include "tactile/core/error.hpp"
#include "tactile/events/packet_compression.hpp"

namespace tactile::events {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t header_limit = std::size_t{16} << 20;  // known headers are a hundred times smaller [B]

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
  for (const std::string_view bag : {"#ROSBAG", "SQLite format 3", "\x89MCAP"}) {
    if (start.starts_with(bag))
      throw Error(name +
                  ": is a ROS bag, not a recording; expected what 'tactile convert' makes of it, a recording or a run folder");
  }
  constexpr std::string_view aedat = "#!AER-DAT";
  if (start.starts_with(aedat) && !start.starts_with("#!AER-DAT4.0")) {
    const auto version = start.substr(aedat.size(), start.find_first_of("\r\n ") - aedat.size());
    throw Error(name + ": is of AEDAT version " + quoted(version) + "; expected version 4.0");
  }
  throw Error(name + ": starts with " + quoted(start.substr(0, magic_line.size())) +
              "; expected the line #!AER-DAT4.0 of an AEDAT4 recording, or '% ' of a Prophesee RAW file");
}

Error shorter(const std::string& name) {
  return Error(name + ": became shorter while it was read; expected it to stay as it is");
}

}  // namespace

RecordingFile::RecordingFile(const fs::path& path)
    : name_(path.string()), file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
  struct stat status {};
  if (!file_.is_open() || ::fstat(file_.number(), &status) != 0) {
    throw Error(name_ + ": cannot be opened (" + std::strerror(errno) + "); expected an AEDAT4 recording");
  }
  if (!S_ISREG(status.st_mode)) throw Error(name_ + ": is no regular file; expected an AEDAT4 recording");
  size_ = static_cast<std::uint64_t>(status.st_size);
  written_ = status.st_mtim;
}

void RecordingFile::check_unchanged(std::uint64_t offset) const {
  struct stat status {};
  if (::fstat(file_.number(), &status) != 0 || static_cast<std::uint64_t>(status.st_size) < size_) throw shorter(name_);
  if (status.st_mtim.tv_sec == written_.tv_sec && status.st_mtim.tv_nsec == written_.tv_nsec) return;
  throw Error(fmt::format(
      "{}: was written to while it was read: the packet at byte {} is no longer the one listed; expected it to stay as it is",
      name_, offset));
}

void RecordingFile::read(std::uint64_t offset, std::span<std::byte> bytes) const {
  const std::ptrdiff_t got = file_.read_at(offset, bytes);
  if (got < 0) throw Error(name_ + ": cannot be read (" + std::strerror(errno) + "); expected a readable file");
  if (static_cast<std::size_t>(got) != bytes.size()) throw shorter(name_);
}

std::optional<RawHeader> raw_header_of(const RecordingFile& file) {
  std::array<std::byte, 2> start{};
  if (file.size() < start.size()) return std::nullopt;
  file.read(0, start);
  const bool is_it = is_raw({reinterpret_cast<const char*>(start.data()), start.size()});
  return is_it ? std::optional(read_raw_header(file)) : std::nullopt;
}

RecordingStart read_start(const RecordingFile& file) {
  std::array<std::byte, 64> start{};
  const auto start_size = static_cast<std::size_t>(std::min<std::uint64_t>(file.size(), start.size()));
  file.read(0, std::span(start).first(start_size));
  const std::string_view text(reinterpret_cast<const char*>(start.data()), start_size);
  if (!text.starts_with(magic_line)) refuse_magic(text, file.name());

  const std::size_t header_at = magic_line.size();
  const std::uint64_t header_size = start_size < header_at + 4 ? file.size() : std::uint64_t{u32_at(start, header_at)} + 4;
  if (header_size > file.size() - header_at) {
    throw Error(file.name() + ": ends inside its header; expected a recording whose header was written whole");
  }
  if (header_size > header_limit) {
    throw Error(fmt::format("{}: claims a header of {} bytes; expected at most {}", file.name(), header_size, header_limit));
  }
  PacketBuffer buffer;
  buffer.grow(static_cast<std::size_t>(header_size), 0);
  const std::span<std::byte> bytes(buffer.data(), static_cast<std::size_t>(header_size));
  file.read(header_at, bytes);
  return {.header = read_header(bytes, file.name()), .data_begin = header_at + header_size};
}

}  // namespace tactile::events
