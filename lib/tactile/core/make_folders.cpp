#include "tactile/core/make_folders.hpp"

#include <system_error>

#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile {
namespace fs = std::filesystem;

void make_folders(const fs::path& folder) {
  if (folder.empty()) return;
  std::error_code failed;
  if (fs::is_directory(folder, failed)) return;
  if (!folder.has_filename()) return make_folders(folder.parent_path());  // "data/"
  const fs::path above = folder.has_parent_path() ? folder.parent_path() : fs::path(".");
  make_folders(above);
  fs::create_directory(folder, failed);
  if (failed)
    throw Error(folder.string() + ": the folder cannot be created (" + failed.message() + "); expected a writable place");
  sync_to_disk(above);
}

}  // namespace tactile
