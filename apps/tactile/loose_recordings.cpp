#include "loose_recordings.hpp"

#include <algorithm>
#include <cctype>

#include "tactile/bags/bag.hpp"

namespace tactile::cli {

namespace fs = std::filesystem;
namespace {

std::string lower_extension(const fs::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

}  // namespace

std::vector<std::string> loose_recordings_in(const fs::path& folder) {
  std::vector<std::string> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string extension = lower_extension(entry.path());
    const bool is_recording = entry.is_regular_file() && (extension == ".aedat4" || extension == ".raw");
    if (is_recording || (extension != ".csv" && bags::is_bag(entry.path()))) found.push_back(entry.path().string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace tactile::cli
