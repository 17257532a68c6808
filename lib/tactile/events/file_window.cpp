#include "tactile/events/file_window.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <csignal>

namespace tactile::events {
namespace {

/// Parts begin at multiples of this, so that threads at near packets share one. Each is longer by the size of a packet. Only
/// accessed pages use memory.
constexpr std::size_t part_size = std::size_t{4} << 20, part_overlap = std::size_t{1} << 20;

/// The bytes that this thread accesses, and the place to resume if they cannot be read.
struct Guarded {
  const std::byte* begin = nullptr;
  const std::byte* end = nullptr;
  sigjmp_buf* way_out = nullptr;
};
thread_local Guarded guarded;

struct sigaction action_before;

void leave(int, siginfo_t* info, void*) {
  const auto* at = static_cast<const std::byte*>(info->si_addr);
  if (guarded.way_out != nullptr && at >= guarded.begin && at < guarded.end) {
    sigjmp_buf* way_out = guarded.way_out;
    guarded = {};
    siglongjmp(*way_out, 1);
  }
  ::sigaction(SIGBUS, &action_before, nullptr);  // not ours: it is raised again on return, with the former action
}

bool watch_for_bus_errors() {
  struct sigaction action {};
  action.sa_sigaction = leave;
  action.sa_flags = SA_SIGINFO | SA_NODEFER | SA_ONSTACK;
  return ::sigaction(SIGBUS, &action, &action_before) == 0;
}

}  // namespace

FileParts::Part::~Part() { ::munmap(data, size); }

std::shared_ptr<const FileParts::Part> FileParts::part(int file, std::uint64_t offset, std::size_t size,
                                                       std::uint64_t file_size) {
  const std::scoped_lock lock(guard_);
  std::erase_if(parts_, [](const auto& part) { return part.expired(); });
  for (const auto& candidate : parts_) {
    if (auto part = candidate.lock(); part && part->has(offset, size)) return part;
  }
  const std::uint64_t begin = offset / part_size * part_size;
  const auto length =
      static_cast<std::size_t>(std::min(std::max(offset + size, begin + part_size + part_overlap), file_size) - begin);
  void* data = ::mmap(nullptr, length, PROT_READ, MAP_SHARED, file, static_cast<off_t>(begin));
  if (data == MAP_FAILED) return nullptr;
  auto part = std::make_shared<const Part>(static_cast<std::byte*>(data), begin, length);
  parts_.push_back(part);
  return part;
}

void FileWindow::guard(sigjmp_buf* way_out) const { guarded = {part_->data, part_->data + part_->size, way_out}; }

bool FileWindow::open(int file, std::uint64_t offset, std::size_t size, std::uint64_t file_size) {
  static const bool watches = watch_for_bus_errors();
  if (!watches || size == 0) return false;
  if (part_ && part_->has(offset, size)) return true;
  part_.reset();
  part_ = parts_->part(file, offset, size, file_size);
  return part_ != nullptr;
}

}  // namespace tactile::events
