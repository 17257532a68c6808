#include "tactile/core/whole_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "tactile/core/error.hpp"

namespace tactile {
namespace fs = std::filesystem;

WholeFile::WholeFile(fs::path target) : target_(std::move(target)) {
  const fs::path folder = target_.has_parent_path() ? target_.parent_path() : fs::path(".");
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) throw Error(folder.string() + ": the folder cannot be made (" + failed.message() + "); expected a writable place");
  temporary_ =
      folder / ("." + target_.stem().string() + "." + std::to_string(::getpid()) + ".part" + target_.extension().string());
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
  sync_to_disk(target_.has_parent_path() ? target_.parent_path() : fs::path("."));
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
  if (!fs::exists(file)) throw Error(file.string() + ": is missing; expected a readable file");
  std::ifstream in(file, std::ios::binary);
  if (!in || fs::is_directory(file)) throw Error(file.string() + ": cannot be read; expected a readable file");
  in.seekg(0, std::ios::end);
  const auto size = static_cast<std::size_t>(in.tellg());
  if (size > limit) {
    throw Error(file.string() + ": " + std::to_string(size) + " bytes long; expected at most " + std::to_string(limit));
  }
  in.seekg(0);
  std::string text(size, '\0');
  in.read(text.data(), static_cast<std::streamsize>(size));
  if (!in) throw Error(file.string() + ": reading it failed half-way; expected a readable file");
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

}  // namespace tactile
