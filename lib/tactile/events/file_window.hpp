#pragma once

#include <csetjmp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace tactile::events {

/// The parts of a file that are mapped into memory. Threads that use the same part share it, and the last one unmaps it. So its
/// pages are loaded only once.
class FileParts {
 public:
  struct Part {
    Part(std::byte* mapped, std::uint64_t offset, std::size_t length) : data(mapped), begin(offset), size(length) {}
    ~Part();
    Part(const Part&) = delete;
    Part& operator=(const Part&) = delete;

    bool has(std::uint64_t offset, std::size_t length) const { return offset >= begin && offset + length <= begin + size; }

    std::byte* data;
    std::uint64_t begin;  ///< in the file [B]
    std::size_t size;
  };

  /// A part that contains `size` bytes from `offset` on; nothing if it cannot be mapped.
  std::shared_ptr<const Part> part(int file, std::uint64_t offset, std::size_t size, std::uint64_t file_size);

 private:
  std::mutex guard_;
  std::vector<std::weak_ptr<const Part>> parts_;
};

/// A mapped part of a file, which avoids a copy. Memory follows the part, not the file.
///
/// If the file has become shorter or its disk fails, access to the bytes raises SIGBUS, which would end the program. Therefore
/// only `use` accesses them: it handles SIGBUS.
class FileWindow {
 public:
  explicit FileWindow(FileParts& parts) : parts_(&parts) {}

  /// Calls `work` with `size` bytes from `offset` on, which must lie inside the file when its size was `file_size`. If they
  /// cannot be read, `work` is aborted without calling destructors: it must not need them, and its results must be discarded.
  /// @return  whether `work` finished; false also if the file cannot be mapped
  template <class Work>
  bool use(int file, std::uint64_t offset, std::size_t size, std::uint64_t file_size, const Work& work) {
    if (!open(file, offset, size, file_size)) return false;
    sigjmp_buf way_out;
    if (sigsetjmp(way_out, 0) != 0) return false;
    guard(&way_out);
    try {
      work(std::span<const std::byte>(part_->data + (offset - part_->begin), size));
    } catch (...) {  // a destructor instead would be skipped by the jump
      guard(nullptr);
      throw;
    }
    guard(nullptr);
    return true;
  }

 private:
  bool open(int file, std::uint64_t offset, std::size_t size, std::uint64_t file_size);
  void guard(sigjmp_buf* way_out) const;

  FileParts* parts_;
  std::shared_ptr<const FileParts::Part> part_;
};

}  // namespace tactile::events
