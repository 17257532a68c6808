#include "library_versions.hpp"

#include <H5public.h>
#include <fmt/format.h>
#include <libdeflate.h>
#include <lz4.h>
#include <zstd.h>

#include <opencv2/core/utility.hpp>

#include "tactile/model/inference/lenet_engine.hpp"
#include "tactile/model/training/torch_version.hpp"
#include "text_table.hpp"

extern "C" {
#include <libavutil/avutil.h>
}

namespace tactile::cli {
namespace {

std::string hdf5_version() {
  unsigned major = 0, minor = 0, release = 0;
  H5get_libversion(&major, &minor, &release);
  return fmt::format("{}.{}.{}", major, minor, release);
}

/// Vector instructions that the engine has code for and this processor has, the fastest first, by their usual names.
std::vector<std::string> vector_instructions() {
  std::vector<std::string> names;
  for (const std::string& target : model::LeNetEngine::targets()) {
    if (target == "SCALAR" || target == "EMU128") continue;                    // without vector instructions
    const std::string name = target.starts_with("AVX3") ? "AVX-512" : target;  // of which Highway knows several
    if (names.empty() || names.back() != name) names.push_back(name);
  }
  return names;
}

}  // namespace

std::vector<LibraryVersion> library_versions() {
  return {{"libtorch", model::torch_version()},
          {"OpenCV", cv::getVersionString()},
          {"HDF5", hdf5_version()},
          {"FFmpeg", av_version_info()},
          {"LZ4", LZ4_versionString()},
          {"zstd", ZSTD_versionString()},
          {"libdeflate", LIBDEFLATE_VERSION_STRING}};
}

std::string libraries_text() {
  std::vector<std::pair<std::string, std::string>> lines;
  for (const LibraryVersion& library : library_versions()) lines.emplace_back(library.name, library.version);
  const std::vector<std::string> features = vector_instructions();
  lines.emplace_back("CPU features", features.empty() ? "no vector instructions in use" : features.front() + " in use");
  if (features.size() > 1) lines.back().second += fmt::format(", also {}", fmt::join(features.begin() + 1, features.end(), ", "));
  std::string text = text_list(lines);
  text.pop_back();  // CLI11 ends the last line
  return text;
}

}  // namespace tactile::cli
