#pragma once

#include <csetjmp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace tactile {

/// The parts of a file that are mapped into memory. Who looks at the same part shares it, and the last one lets it go: its pages
/// come and go once, whichever threads read them.
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

  /// A part that has `size` bytes from `offset` on; nothing where it cannot be mapped.
  std::shared_ptr<const Part> part(int file, std::uint64_t offset, std::size_t size, std::uint64_t file_size);

 private:
  std::mutex guard_;
  std::vector<std::weak_ptr<const Part>> parts_;
};

/// A part of a file as the kernel holds it, which saves copying it. Memory follows the part, not the file.
///
/// Where the file has become shorter or its disk fails, touching such bytes raises SIGBUS, which would end the program: they are
/// touched in `use` only, which survives it.
class FileWindow {
 public:
  explicit FileWindow(FileParts& parts) : parts_(&parts) {}

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
      work(std::span<const std::byte>(part_->data + (offset - part_->begin), size));
    } catch (...) {  // no object with a destructor instead: the way out would pass it by
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

}  // namespace tactile
