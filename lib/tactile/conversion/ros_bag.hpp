#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "tactile/core/time.hpp"

namespace tactile::conversion {

/// A publisher on a topic of a bag.
struct BagConnection {
  std::string topic, type, md5sum;  ///< "/dvs/events", "dvs_msgs/EventArray", 32 hexadecimal digits that identify its definition
};

struct BagMessage {
  const BagConnection* connection = nullptr;  ///< valid as long as the reader
  HostTime received;                          ///< when the recording host received it
  std::span<const std::byte> data;            ///< in ROS 1's serialisation; valid until the next call
};

/// What is damaged in a bag and was skipped; all 0 in a sound one.
struct BagProblems {
  std::uint64_t truncated_bytes = 0;   ///< after the last whole record, even if messages of the incomplete chunk were read
  std::uint64_t broken_chunks = 0;     ///< that cannot be decompressed, or end inside a record
  std::uint64_t broken_records = 0;    ///< whose header is incomplete
  std::uint64_t unknown_messages = 0;  ///< of a connection that no earlier record declares
};

/// Reads the messages of a ROS 1 bag, version 2.0, from front to back. The index at the end of the bag is not used. Therefore a
/// bag that was cut off, or never closed, is read up to its end. Of an incomplete chunk, the part that can be decompressed is
/// read.
///
/// Every length is checked before memory is allocated for it: a record is at most as long as the file, a header at most 1 MiB,
/// and a chunk or message at most 256 MiB, compressed or not.
///
/// Source: the ROS wiki's Bags/Format/2.0.
class RosBagReader {
 public:
  /// @throws Error  if the file cannot be read, is not a bag of this version, or is encrypted
  explicit RosBagReader(const std::filesystem::path& file);
  ~RosBagReader();
  RosBagReader(RosBagReader&&) noexcept;
  RosBagReader& operator=(RosBagReader&&) noexcept;

  std::optional<BagMessage> next();  ///< nothing at the end of the bag. @throws Error if the file cannot be read
  void rewind();                     ///< to the first message; the counts of problems restart

  std::uint64_t bytes_read() const;  ///< of the file, up to the record being read
  std::uint64_t file_size() const;
  const BagProblems& problems() const;  ///< so far

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::conversion
