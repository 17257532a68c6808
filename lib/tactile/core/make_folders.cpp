#include "tactile/core/make_folders.hpp"

#include <unistd.h>

#include <mutex>
#include <set>
#include <system_error>

#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile {
namespace fs = std::filesystem;
namespace {

/// The folders that this process made.
struct MadeFolders {
  std::mutex guard;
  std::set<fs::path> paths;
};
MadeFolders& made_folders() {
  static MadeFolders made;
  return made;
}

}  // namespace

void make_folders(const fs::path& folder) {
  if (folder.empty()) return;
  std::error_code failed;
  if (fs::is_directory(folder, failed)) return;
  if (!folder.has_filename()) return make_folders(folder.parent_path());  // "data/"
  const fs::path above = folder.has_parent_path() ? folder.parent_path() : fs::path(".");
  make_folders(above);
  if (fs::create_directory(folder, failed)) {
    const std::scoped_lock lock(made_folders().guard);
    made_folders().paths.insert(folder);
  }
  if (failed) {
    remove_empty_made_folders(above);
    throw Error(folder.string() + ": the folder cannot be created (" + failed.message() + "); expected a writable place");
  }
  sync_to_disk(above);
}

void remove_empty_made_folders(fs::path folder) {
  const std::scoped_lock lock(made_folders().guard);
  while (made_folders().paths.contains(folder) && ::rmdir(folder.c_str()) == 0) {
    made_folders().paths.erase(folder);
    folder = folder.parent_path();
  }
}

}  // namespace tactile
