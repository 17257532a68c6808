#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/bags/ros_types.hpp"
#include "tactile/core/time.hpp"

namespace tactile::bags {

/// A publisher on a topic of a bag.
struct BagConnection {
  std::string topic, type;  ///< "/dvs/events", "dvs_msgs/EventArray"; ROS 2 writes "dvs_msgs/msg/EventArray"
  std::string md5sum{};     ///< of the definition, 32 hexadecimal digits; empty in a bag of ROS 2
  RosMessage message = RosMessage::other;
  RosSerialisation serialisation = RosSerialisation::ros1;
};

struct BagMessage {
  const BagConnection* connection = nullptr;  ///< valid until the next call
  HostTime received;                          ///< when the recording host received it
  std::span<const std::byte> data;            ///< valid until the next call

  SerialisedMessage serialised() const { return {data, connection->serialisation}; }
};

/// What is damaged in a bag and was skipped; all 0 in a sound one.
struct BagProblems {
  std::uint64_t truncated_bytes = 0;   ///< cut off, or after the last whole record
  std::uint64_t broken_chunks = 0;     ///< chunks or pages that cannot be read
  std::uint64_t broken_records = 0;    ///< whose header is incomplete
  std::uint64_t unknown_messages = 0;  ///< of a connection that no earlier record declares

  BagProblems& operator+=(const BagProblems& more);
};

/// Reads the messages of a bag in the order in which they were written. Every length is checked before memory is allocated for
/// it: a chunk or message has at most 256 MiB, compressed or not.
class BagReader {
 public:
  BagReader() = default;
  virtual ~BagReader() = default;
  BagReader(const BagReader&) = delete;
  BagReader& operator=(const BagReader&) = delete;

  virtual std::optional<BagMessage> next() = 0;  ///< nothing at the end of the bag. @throws Error if the file cannot be read
  virtual void rewind() = 0;                     ///< to the first message; the counts of problems restart

  virtual std::uint64_t bytes_read() const = 0;  ///< about, for progress; at most `file_size`
  virtual std::uint64_t file_size() const = 0;
  virtual const BagProblems& problems() const = 0;  ///< so far
  virtual std::string_view format() const = 0;      ///< "ROS 1 bag", "ROS 2 bag (SQLite)", "ROS 2 bag (MCAP)"
};

/// Whether this is a bag by its name: .bag, .db3 or .mcap, also with .zstd after it, or a folder that contains such files of
/// ROS 2.
bool is_bag(const std::filesystem::path& place);

/// The files of a bag, in the order of their numbers: the file itself, or those of its folder.
/// @throws Error  if there is none
std::vector<std::filesystem::path> files_of_bag(const std::filesystem::path& place);

/// Opens a bag of ROS 1 or ROS 2. The first bytes of a file show its format. `metadata.yaml` of a folder is not needed. A file
/// that zstd compressed is first decompressed into the folder for temporary files.
/// @throws Error  if there is no bag, or its first file cannot be read
std::unique_ptr<BagReader> open_bag(const std::filesystem::path& place);

}  // namespace tactile::bags
