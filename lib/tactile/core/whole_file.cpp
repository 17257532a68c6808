#include "tactile/core/whole_file.hpp"

#include <fcntl.h>
#include <stdio.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <system_error>
#include <utility>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/core/make_folders.hpp"
#include "tactile/core/renaming.hpp"

namespace tactile {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t first_read = 65'536;
constexpr std::string_view random_part = "XXXXXX";  // mkdtemp replaces it
constexpr const char* lock_name = ".lock";

fs::path folder_of(const fs::path& target) { return target.has_parent_path() ? target.parent_path() : fs::path("."); }
constexpr std::string_view part_mark = ".part-";
std::string part_prefix(const fs::path& target) { return "." + target.filename().string() + std::string(part_mark); }

/// Removes the folders of killed processes whose names begin with `prefix`.
void remove_parts_in(const fs::path& folder, std::string_view prefix) {
  std::vector<fs::path> parts;
  std::error_code failed;
  for (fs::directory_iterator entry(folder, failed); !failed && entry != fs::directory_iterator(); entry.increment(failed)) {
    const std::string name = entry->path().filename().string();
    const std::size_t mark = name.rfind(part_mark);
    std::error_code unknown;
    const bool is_part = name.starts_with('.') && mark != std::string::npos &&
                         name.size() - mark == part_mark.size() + random_part.size() && name.starts_with(prefix);
    if (is_part && fs::is_directory(entry->symlink_status(unknown))) parts.push_back(entry->path());
  }
  for (const fs::path& part : parts) {
    const int lock = ::open((part / lock_name).c_str(), O_RDWR | O_CLOEXEC);
    std::error_code ignored;
    if (lock < 0) {
      if (errno == ENOENT) ::rmdir(part.c_str());  // killed before it was locked: it is empty, or belongs to another program
      continue;
    }
    if (::flock(lock, LOCK_EX | LOCK_NB) == 0) fs::remove_all(part, ignored);
    ::close(lock);
  }
}

/// Syncs a file, or a folder with everything in it.
void sync_all(const fs::path& path) {
  if (fs::is_directory(path)) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(path)) {
      if (!entry.is_symlink() && (entry.is_regular_file() || entry.is_directory())) sync_to_disk(entry.path());
    }
  }
  sync_to_disk(path);
}

[[noreturn]] void throw_not_in_place(const fs::path& target, int error) {
  throw Error(target.string() + ": cannot be put in place (" + std::strerror(error) + "); expected a writable folder" +
              (error == EISDIR || error == ENOTDIR ? ", and no folder where a file belongs, or the reverse" : ""));
}

fs::path without_slash(fs::path target) {
  if (target.has_filename()) return target;
  return target.parent_path();
}

}  // namespace

PartFolder::PartFolder(const fs::path& target) {
  const fs::path folder = folder_of(target);
  make_folders(folder);
  remove_leftovers(target);
  // Another process may remove the folder as a leftover until it is locked, or the folder above, which it made and leaves empty:
  // then the next one is created.
  constexpr int most_attempts = 100;
  for (int attempt = 1;; ++attempt) {
    std::string name = (folder / (part_prefix(target) + std::string(random_part))).string();
    if (::mkdtemp(name.data()) == nullptr) {
      if (errno == ENOENT && attempt < most_attempts) {
        make_folders(folder);
        continue;
      }
      throw Error(target.string() + ": cannot be written, because no file can be created in its folder (" + std::strerror(errno) +
                  "); expected a writable folder with room");
    }
    path_ = name;
    lock_ = ::open((path_ / lock_name).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (lock_ < 0) {
      if (errno == ENOENT) continue;
      const int reason = errno;
      ::rmdir(path_.c_str());
      throw Error(target.string() + ": cannot be written (" + std::strerror(reason) + "); expected a writable place with room");
    }
    // If a disk does not support locks, no process removes leftovers.
    static_cast<void>(::flock(lock_, LOCK_EX));
    struct stat lock {};
    if (::fstat(lock_, &lock) != 0 || lock.st_nlink > 0) return;
    ::close(lock_);
  }
}

PartFolder::~PartFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  ::close(lock_);
  remove_empty_made_folders(path_.parent_path());
}

WholeFile::WholeFile(fs::path target, IfThere if_there)
    : target_(without_slash(std::move(target))),
      if_there_(if_there),
      part_(target_),
      temporary_(part_.path() / target_.filename()) {}

void WholeFile::commit() {
  if (if_there_ == IfThere::refuse) {
    if (!commit_if_free())
      throw Error(target_.string() + ": appeared while the output was written, and is kept; expected a free name");
    return;
  }
  sync_all(temporary_);
  const int error = fs::is_directory(temporary_) ? exchange_folders(temporary_, target_) : replace_file(temporary_, target_);
  if (error != 0) throw_not_in_place(target_, error);
  sync_to_disk(folder_of(target_));
}

bool WholeFile::commit_if_free() {
  sync_all(temporary_);
  const int error = rename_if_free(temporary_, target_);
  if (error == EEXIST) return false;
  if (error != 0) throw_not_in_place(target_, error);
  sync_to_disk(folder_of(target_));
  return true;
}

void remove_leftovers(const fs::path& target) {
  const fs::path plain = without_slash(target);
  remove_parts_in(folder_of(plain), part_prefix(plain));
}

void remove_leftovers_in(const fs::path& folder) { remove_parts_in(folder, ""); }

void remove_whole(const fs::path& folder) {
  const fs::path plain = without_slash(folder);
  const PartFolder part(plain);
  std::error_code failed;
  fs::rename(plain, part.path() / plain.filename(), failed);
  if (failed == std::errc::no_such_file_or_directory) return;
  if (failed) throw Error(folder.string() + ": cannot be removed (" + failed.message() + "); expected a writable folder");
  sync_to_disk(folder_of(plain));
}

void write_whole(const fs::path& file, std::string_view text, IfThere if_there) {
  WholeFile whole(file, if_there);
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
  // A pipe has no size, a file in /proc has size 0, and a file may grow meanwhile: only the bytes read count.
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
  if (!in.eof()) throw Error(file.string() + ": reading it failed; expected a readable file");
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
