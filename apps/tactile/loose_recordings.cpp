#include "loose_recordings.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "tactile/bags/bag.hpp"
#include "tactile/core/text.hpp"

namespace tactile::cli {

namespace fs = std::filesystem;

bool has_recording_name(const fs::path& file) {
  constexpr std::array<std::string_view, 5> extensions{".aedat4", ".raw", ".bag", ".db3", ".mcap"};
  return std::find(extensions.begin(), extensions.end(), lower_case(file.extension().string())) != extensions.end();
}

std::vector<std::string> loose_recordings_in(const fs::path& folder) {
  std::vector<std::string> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string extension = lower_case(entry.path().extension().string());
    const bool is_recording = entry.is_regular_file() && (extension == ".aedat4" || extension == ".raw");
    if (is_recording || (extension != ".csv" && bags::is_bag(entry.path()))) found.push_back(entry.path().string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace tactile::cli
