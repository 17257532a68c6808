#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "tactile/events/file_descriptor.hpp"
#include "tactile/events/file_window.hpp"
#include "tactile/events/recording_header.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile {

/// A recording's file, open for reading. Its size is what it was when it was opened.
class RecordingFile {
 public:
  /// @throws Error  if it is no regular file or cannot be opened
  explicit RecordingFile(const std::filesystem::path& path);

  const std::string& name() const { return name_; }  ///< for errors
  std::uint64_t size() const { return size_; }
  int descriptor() const { return file_.number(); }
  FileParts& parts() const { return parts_; }  ///< for several threads
  /// Fills `bytes` from `offset` on. @throws Error if they cannot be read, or the file has become shorter
  void read(std::uint64_t offset, std::span<std::byte> bytes) const;

 private:
  std::string name_;
  FileDescriptor file_;
  std::uint64_t size_ = 0;
  mutable FileParts parts_;
};

/// A recording's header, checked, and where the packets begin behind it [B].
struct RecordingStart {
  RecordingHeader header;
  std::uint64_t data_begin = 0;
};

/// @throws Error  if the file is none of AEDAT4, or declares no stream
RecordingStart read_start(const RecordingFile& file);

/// The packets that a recording has.
struct PacketList {
  std::vector<PacketRecord> packets;  ///< in file order, of declared streams; by a table with its elements and times
  PacketIndex index = PacketIndex::scan;
  RecordingProblems problems;  ///< as far as they can be told without the packets' contents
};

/// Finds the packets: from header to header, which a data table must agree with to be believed. Where a header can be none, the
/// way goes on
///
///   1. with the packet that a data table has there, or next, where there is a table and what it says leads to a packet,
///   2. else with the next place that looks like a packet in all that can be known: a declared stream, a size that fits, contents
///      that begin as they must, and behind them the end, another such place, or contents that prove whole.
///
/// A size that led astray is put right where the table or the place of the next packet tells it. The cost grows with the file's
/// size, whatever its bytes.
/// @throws Error  if the file cannot be read
PacketList find_packets(const RecordingFile& file, const RecordingStart& start);

}  // namespace tactile
