#include "tactile/events/file_window.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>

namespace tactile {
namespace {

constexpr std::size_t least_size = std::size_t{4} << 20;  ///< only what is touched becomes part of this process

/// What this thread looks at, and where it goes on when that cannot be read.
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
  ::sigaction(SIGBUS, &action_before, nullptr);  // not ours: it is raised again on return, and met as before
}

bool watch_for_bus_errors() {
  struct sigaction action {};
  action.sa_sigaction = leave;
  action.sa_flags = SA_SIGINFO | SA_NODEFER | SA_ONSTACK;
  return ::sigaction(SIGBUS, &action, &action_before) == 0;
}

}  // namespace

void FileWindow::close() {
  if (data_ != nullptr) ::munmap(data_, size_);
  data_ = nullptr;
  begin_ = size_ = 0;
}

void FileWindow::guard(sigjmp_buf* way_out) const { guarded = {data_, data_ + size_, way_out}; }

bool FileWindow::open(int file, std::uint64_t offset, std::size_t size, std::uint64_t file_size) {
  static const bool watches = watch_for_bus_errors();
  static const auto page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  if (!watches || size == 0) return false;
  if (data_ != nullptr && offset >= begin_ && offset + size <= begin_ + size_) return true;
  close();
  const std::uint64_t begin = offset / page * page;
  const auto length = static_cast<std::size_t>(std::min(std::max(offset + size, begin + least_size), file_size) - begin);
  void* data = ::mmap(nullptr, length, PROT_READ, MAP_SHARED, file, static_cast<off_t>(begin));
  if (data == MAP_FAILED) return false;
  data_ = static_cast<std::byte*>(data);
  begin_ = begin;
  size_ = length;
  return true;
}

}  // namespace tactile
