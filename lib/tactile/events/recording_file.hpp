#pragma once

#include <sys/stat.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "tactile/events/file_descriptor.hpp"
#include "tactile/events/file_window.hpp"
#include "tactile/events/raw_header.hpp"
#include "tactile/events/recording_header.hpp"

namespace tactile::events {

/// A recording's file, open for reading. Its size is the size when it was opened.
class RecordingFile {
 public:
  /// @throws Error  if it is not a regular file or cannot be opened
  explicit RecordingFile(const std::filesystem::path& path);

  const std::string& name() const { return name_; }  ///< for errors
  std::uint64_t size() const { return size_; }
  /// For a packet at byte `offset` that is not as it was listed. @throws Error  if the file was cut or written to meanwhile
  void check_unchanged(std::uint64_t offset) const;
  int descriptor() const { return file_.number(); }
  FileParts& parts() const { return parts_; }  ///< for several threads
  /// Fills `bytes` from `offset` on. @throws Error if they cannot be read, or the file has become shorter
  void read(std::uint64_t offset, std::span<std::byte> bytes) const;

 private:
  std::string name_;
  FileDescriptor file_;
  std::uint64_t size_ = 0;
  timespec written_{};  ///< when it was last written to, as it was opened
  mutable FileParts parts_;
};

/// The number that is stored in the four bytes from `at` on, little-endian.
inline std::uint32_t u32_at(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// The header of a Prophesee RAW file; nothing if the file is none. @throws Error  as `read_raw_header`
std::optional<RawHeader> raw_header_of(const RecordingFile& file);

/// A recording's header, checked, and where the packets begin [B].
struct RecordingStart {
  RecordingHeader header;
  std::uint64_t data_begin = 0;
};

/// @throws Error  if the file is not AEDAT4, or declares no stream
RecordingStart read_start(const RecordingFile& file);

}  // namespace tactile::events
