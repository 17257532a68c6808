#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace tactile {

/// What becomes of a file or folder that already has an output's name when the output is complete.
enum class IfThere : std::uint8_t { refuse, replace };

/// A hidden folder `.NAME.part-XXXXXX` next to a target, with a random name that no other process has, removed when this goes.
/// A lock in it dies with the process, so that others can distinguish a folder in use from one that a killed process left.
class PartFolder {
 public:
  /// Makes the folder above `target` if it is missing, and removes what killed processes left of this target.
  /// @throws Error if that fails
  explicit PartFolder(const std::filesystem::path& target);
  ~PartFolder();
  PartFolder(const PartFolder&) = delete;
  PartFolder& operator=(const PartFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  int lock_ = -1;
};

/// A file or folder that appears under its name only when it is complete: written in a `PartFolder` under the name it will have,
/// then synced with all that is in it, and renamed in one step. One that is never committed is removed.
class WholeFile {
 public:
  /// @throws Error if the folder above `target` cannot be made or written
  WholeFile(std::filesystem::path target, IfThere if_there);

  const std::filesystem::path& path() const { return temporary_; }  ///< where to write until `commit`

  /// @throws Error if syncing or renaming fails, or if something has the name that must not be replaced: that then stays
  void commit();
  /// As `commit`, but replaces nothing: false if the name is taken. @throws Error if syncing or renaming fails
  [[nodiscard]] bool commit_if_free();

 private:
  std::filesystem::path target_;
  IfThere if_there_;
  PartFolder part_;
  std::filesystem::path temporary_;
};

/// Removes what killed processes left of a `PartFolder` of this target. @throws nothing: what cannot be removed stays
void remove_leftovers(const std::filesystem::path& target);
/// The same of every target in `folder`.
void remove_leftovers_in(const std::filesystem::path& folder);

/// Takes a folder's name away in one step, then its files, so that no half of it is ever found under the name. None there: done.
/// @throws Error if it cannot be removed
void remove_whole(const std::filesystem::path& folder);

/// Writes `text` to `file`, whole or not at all. @throws Error if it cannot be written, or is there and must not be replaced
void write_whole(const std::filesystem::path& file, std::string_view text, IfThere if_there = IfThere::replace);

/// All of a file, or of a pipe until it ends. @throws Error if it cannot be read or holds more than `limit` bytes
std::string read_text(const std::filesystem::path& file, std::size_t limit = std::size_t{256} << 20);

/// Flushes a file's data, or a folder's list of names, to the disk. @throws Error if that fails
void sync_to_disk(const std::filesystem::path& path);

/// Lets the system forget what it holds in memory of a file that was synced, except for its last `kept` bytes. Only a hint.
void release_memory_of(const std::filesystem::path& file, std::uint64_t kept);

}  // namespace tactile
