#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace tactile::model {

/// A file of scalars that TensorBoard reads while it grows.
///
/// Records are those of TFRecord: the length (uint64), the masked CRC-32C of the length (uint32), the bytes, and their masked
/// CRC-32C (uint32), all little-endian; mask(c) = rotate_right(c, 15) + 0xa282ead8. Each holds a protobuf message `Event`: wall
/// time, step, and file version, session or summary. Each record reaches the file by one write, so a reader never sees a
/// part of one, but after a power cut.
/// Source: tensorflow/core/lib/io/record_writer.h, tensorflow/core/util/event.proto, core/framework/summary.proto.
class EventFile {
 public:
  using Scalars = std::vector<std::pair<std::string, float>>;  ///< tag, such as "train/loss", and value

  /// Makes a new file `events.out.tfevents.<seconds>.tactile.<process>` in `folder`, and the folder.
  /// @throws Error  if that fails
  explicit EventFile(const std::filesystem::path& folder);
  ~EventFile();
  EventFile(const EventFile&) = delete;
  EventFile& operator=(const EventFile&) = delete;

  /// Values from this step on, in older files of the folder, no longer count: a training resumes before it.
  void restart_at(std::int64_t step);
  void add(std::int64_t step, const Scalars& scalars);  ///< @throws Error  if it cannot be written

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  int file_ = -1;
};

/// Whether the folder has such a file.
bool has_event_file(const std::filesystem::path& folder);

std::string version_record(double wall_time);                                                       ///< the first record
std::string restart_record(double wall_time, std::int64_t step);                                    ///< of `restart_at`
std::string scalars_record(double wall_time, std::int64_t step, const EventFile::Scalars& values);  ///< of `add`

}  // namespace tactile::model
