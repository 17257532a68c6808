#include "tactile/core/whole_file.hpp"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>
#include <system_error>

#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"

namespace tactile {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t first_read = 65'536;

fs::path folder_of(const fs::path& target) { return target.has_parent_path() ? target.parent_path() : fs::path("."); }

/// This machine's name, for a folder may be shared by several whose processes' numbers mean nothing to each other.
const std::string& machine() {
  static const std::string name = [] {
    std::array<char, 256> text{};
    ::gethostname(text.data(), text.size() - 1);
    std::string plain;
    for (const char c : std::string_view(text.data())) plain += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '-';
    return plain.substr(0, 64);
  }();
  return name;
}

/// A temporary name is the hidden stem, a process's number at a machine, and `.part` with the extension.
std::string name_before(const fs::path& target) { return "." + target.stem().string() + "."; }
std::string name_behind(const fs::path& target) { return "@" + machine() + ".part" + target.extension().string(); }

}  // namespace

WholeFile::WholeFile(fs::path target) : target_(std::move(target)) {
  const fs::path folder = folder_of(target_);
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) throw Error(folder.string() + ": the folder cannot be made (" + failed.message() + "); expected a writable place");
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    throw Error(target_.string() + ": cannot be written, its folder takes no file (" + std::strerror(errno) +
                "); expected a writable folder");
  }
  temporary_ = folder / (name_before(target_) + std::to_string(::getpid()) + name_behind(target_));
  fs::remove_all(temporary_, failed);
}

WholeFile::~WholeFile() {
  std::error_code ignored;
  if (!committed_) fs::remove_all(temporary_, ignored);
}

void WholeFile::commit() {
  sync_to_disk(temporary_);
  std::error_code failed;
  fs::rename(temporary_, target_, failed);
  if (failed) throw Error(target_.string() + ": cannot be put in place (" + failed.message() + "); expected a writable folder");
  committed_ = true;
  sync_to_disk(folder_of(target_));
}

void remove_leftovers(const fs::path& target) {
  const std::string before = name_before(target), behind = name_behind(target);
  std::error_code failed;
  for (fs::directory_iterator entry(folder_of(target), failed); !failed && entry != fs::directory_iterator();
       entry.increment(failed)) {
    const std::string name = entry->path().filename().string();
    if (name.size() <= before.size() + behind.size() || !name.starts_with(before) || !name.ends_with(behind)) continue;
    const auto process =
        whole_number_in(std::string_view(name).substr(before.size(), name.size() - before.size() - behind.size()));
    const bool is_process = process && *process > 0 && *process <= std::numeric_limits<pid_t>::max();
    if (!is_process || ::kill(static_cast<pid_t>(*process), 0) == 0 || errno != ESRCH) continue;
    std::error_code ignored;
    fs::remove_all(entry->path(), ignored);
  }
}

void write_whole(const fs::path& file, std::string_view text) {
  WholeFile whole(file);
  std::ofstream out(whole.path(), std::ios::binary);
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  out.close();
  if (!out)
    throw Error(file.string() + ": cannot be written (" + std::strerror(errno) + "); expected a writable place with room");
  whole.commit();
}

std::string read_text(const fs::path& file, std::size_t limit) {
  std::error_code unknown;
  const fs::file_type type = fs::status(file, unknown).type();
  if (type == fs::file_type::not_found) throw Error(file.string() + ": is missing; expected a readable file");
  if (type == fs::file_type::none)
    throw Error(file.string() + ": cannot be read (" + unknown.message() + "); expected a readable file");
  std::ifstream in(file, std::ios::binary);
  if (!in || type == fs::file_type::directory) throw Error(file.string() + ": cannot be read; expected a readable file");
  if (fs::is_regular_file(file, unknown)) {
    const std::uintmax_t size = fs::file_size(file, unknown);
    if (!unknown && size > limit)
      throw Error(file.string() + ": " + std::to_string(size) + " bytes long; expected at most " + std::to_string(limit));
  }
  // A pipe has no size, one of /proc says 0, and a file may grow meanwhile: what comes is what counts.
  std::string text;
  while (in) {
    const std::size_t had = text.size(), wanted = std::min(std::max(first_read, had), limit - had + 1);
    text.resize(had + wanted);
    in.read(text.data() + had, static_cast<std::streamsize>(wanted));
    text.resize(had + static_cast<std::size_t>(in.gcount()));
    if (text.size() > limit)
      throw Error(file.string() + ": more than " + std::to_string(limit) + " bytes long; expected at most " +
                  std::to_string(limit));
  }
  if (!in.eof()) throw Error(file.string() + ": reading it failed half-way; expected a readable file");
  return text;
}

void sync_to_disk(const fs::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = file >= 0 && (::fsync(file) == 0 || errno == EINVAL);
  const int error = errno;
  if (file >= 0) ::close(file);
  if (!synced)
    throw Error(path.string() + ": cannot be synced to the disk (" + std::strerror(error) + "); expected a writable disk");
}

void release_memory_of(const fs::path& path, std::uint64_t kept) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return;
  const off_t end = ::lseek(file, 0, SEEK_END);
  if (end > static_cast<off_t>(kept)) ::posix_fadvise(file, 0, end - static_cast<off_t>(kept), POSIX_FADV_DONTNEED);
  ::close(file);
}

}  // namespace tactile
