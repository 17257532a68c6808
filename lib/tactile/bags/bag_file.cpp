#include "tactile/bags/bag_file.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>

#include "tactile/core/error.hpp"

namespace tactile::bags {
namespace fs = std::filesystem;

BagFile::BagFile(const fs::path& path)
    : name_(path.string()), file_(fs::is_directory(path) ? -1 : ::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  struct stat status {};
  if (!file_.is_open() || ::fstat(file_.number(), &status) != 0)
    throw Error(fmt::format("{}: cannot be opened ({}); expected a readable bag", name_,
                            fs::is_directory(path) ? "a folder" : std::strerror(errno)));
  size_ = static_cast<std::uint64_t>(status.st_size);
}

void BagFile::read(std::uint64_t offset, std::span<std::byte> bytes) const {
  if (file_.read_at(offset, bytes) >= 0) return;
  throw Error(fmt::format("{}: reading it failed half-way ({}); expected a readable file", name_, std::strerror(errno)));
}

}  // namespace tactile::bags
