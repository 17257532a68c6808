#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "tactile/core/time.hpp"

namespace tactile {

/// Who says what on a topic of a bag.
struct BagConnection {
  std::string topic, type, md5sum;  ///< "/dvs/events", "dvs_msgs/EventArray", 32 hexadecimal digits that name its definition
};

struct BagMessage {
  const BagConnection* connection = nullptr;  ///< stays as long as the reader
  HostTime received;                          ///< when the recording host got it
  std::span<const std::byte> data;            ///< in ROS 1's own serialisation; valid until the next is read
};

/// What was wrong with a bag and was passed over; all 0 in a sound one.
struct BagProblems {
  std::uint64_t truncated_bytes = 0;   ///< behind the last whole record, even if the messages of a chunk cut off were read
  std::uint64_t broken_chunks = 0;     ///< that do not decompress, or end amid a record
  std::uint64_t broken_records = 0;    ///< whose header lacks what it must have
  std::uint64_t unknown_messages = 0;  ///< of a connection that no record before them names
};

/// Reads the messages of a ROS 1 bag, version 2.0, from front to back. The index at the bag's end is not used, so one that was
/// cut off, or never closed, is read up to there: of a chunk cut off its front, as far as that decompresses.
///
/// Every length is checked against what is there before anything is allocated for it: no record may be longer than the file, no
/// header than 1 MiB, and no chunk or message than 256 MiB, compressed or not.
///
/// Source: the ROS wiki's Bags/Format/2.0.
class RosBagReader {
 public:
  /// @throws Error  if the file cannot be read, is no bag of this version, or is encrypted
  explicit RosBagReader(const std::filesystem::path& file);
  ~RosBagReader();
  RosBagReader(RosBagReader&&) noexcept;
  RosBagReader& operator=(RosBagReader&&) noexcept;

  std::optional<BagMessage> next();  ///< nothing once the bag ends. @throws Error if the file cannot be read
  void rewind();                     ///< to the first message; problems are counted anew

  std::uint64_t bytes_read() const;  ///< of the file, up to the record being read
  std::uint64_t file_size() const;
  const BagProblems& problems() const;  ///< so far

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile
