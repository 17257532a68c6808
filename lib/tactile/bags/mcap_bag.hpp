#pragma once

#include <filesystem>
#include <memory>

#include "tactile/bags/bag.hpp"

namespace tactile::bags {

/// Reads the messages of an MCAP file from front to back. The summary and the indexes at its end are not used. Therefore a file
/// that was cut off, or never closed, is read up to its end. Of an incomplete chunk, the part that can be decompressed is read.
/// Chunks are plain, or compressed with LZ4 or zstd; their checksums are verified. A file has at most 65 536 channels and
/// schemas.
///
/// Source: the MCAP format specification, mcap.dev/spec.
class McapReader : public BagReader {
 public:
  /// @throws Error  if the file cannot be read, or is no MCAP file
  explicit McapReader(const std::filesystem::path& file);
  ~McapReader() override;

  std::optional<BagMessage> next() override;
  void rewind() override;
  std::uint64_t bytes_read() const override;
  std::uint64_t file_size() const override;
  const BagProblems& problems() const override;
  std::string_view format() const override { return "ROS 2 bag (MCAP)"; }

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::bags
