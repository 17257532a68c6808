#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace tactile {

/// A file or folder that appears under its name only once it is whole: written under a hidden temporary name beside it with the
/// same extension, then synced and renamed. One that is never committed is removed.
class WholeFile {
 public:
  /// Makes the folder above `target` if it is missing. @throws Error if that fails
  explicit WholeFile(std::filesystem::path target);
  ~WholeFile();
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  const std::filesystem::path& path() const { return temporary_; }  ///< where to write until `commit`
  void commit();                                                    ///< @throws Error if syncing or renaming fails

 private:
  std::filesystem::path target_;
  std::filesystem::path temporary_;
  bool committed_ = false;
};

/// Removes what processes that were killed on this machine left of a `WholeFile` of this name. @throws nothing: what cannot be
/// removed stays
void remove_leftovers(const std::filesystem::path& target);

/// Writes `text` to `file`, whole or not at all. @throws Error if it cannot be written
void write_whole(const std::filesystem::path& file, std::string_view text);

/// All of a file, or of a pipe until it ends. @throws Error if it cannot be read or holds more than `limit` bytes
std::string read_text(const std::filesystem::path& file, std::size_t limit = std::size_t{256} << 20);

/// Flushes a file's or a folder's data to the disk. @throws Error if that fails
void sync_to_disk(const std::filesystem::path& path);

/// Lets the system forget what it holds in memory of a file that was synced, but for its last `kept` bytes. Only a hint.
void release_memory_of(const std::filesystem::path& file, std::uint64_t kept);

}  // namespace tactile
