#pragma once

#include <csetjmp>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tactile {

/// A part of a file as the kernel holds it, which saves copying it. Memory follows the part, not the file.
///
/// Where the file has become shorter or its disk fails, touching such bytes raises SIGBUS, which would end the program: they are
/// touched in `use` only, which survives it.
class FileWindow {
 public:
  FileWindow() = default;
  ~FileWindow() { close(); }
  FileWindow(const FileWindow&) = delete;
  FileWindow& operator=(const FileWindow&) = delete;

  /// Calls `work` with `size` bytes from `offset` on, which lay inside the file when its size was `file_size`. Where they turn
  /// out not to be readable, it is left where it stands: nothing in it may need a destructor then, and what it has changed
  /// half-way must be thrown away. @return whether it ended; false also where the file cannot be viewed at all
  template <class Work>
  bool use(int file, std::uint64_t offset, std::size_t size, std::uint64_t file_size, const Work& work) {
    if (!open(file, offset, size, file_size)) return false;
    sigjmp_buf way_out;
    if (sigsetjmp(way_out, 0) != 0) return false;
    guard(&way_out);
    try {
      work(std::span<const std::byte>(data_ + (offset - begin_), size));
    } catch (...) {  // no object with a destructor instead: the way out would pass it by
      guard(nullptr);
      throw;
    }
    guard(nullptr);
    return true;
  }

 private:
  bool open(int file, std::uint64_t offset, std::size_t size, std::uint64_t file_size);
  void close();
  void guard(sigjmp_buf* way_out) const;

  std::byte* data_ = nullptr;
  std::uint64_t begin_ = 0;
  std::size_t size_ = 0;
};

}  // namespace tactile
