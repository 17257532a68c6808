#include "tactile/core/folders_in.hpp"

#include <algorithm>
#include <system_error>

namespace tactile {

namespace fs = std::filesystem;

std::vector<fs::path> folders_in(const fs::path& folder, Links links) {
  std::vector<fs::path> folders;
  std::error_code failed, unknown;
  for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed)) {
    const fs::file_status status = links == Links::follow ? entry->status(unknown) : entry->symlink_status(unknown);
    if (fs::is_directory(status)) folders.push_back(entry->path());
  }
  std::sort(folders.begin(), folders.end());
  return folders;
}

}  // namespace tactile
