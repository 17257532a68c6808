#include "library_versions.hpp"

#include <H5public.h>
#include <fmt/format.h>
#include <libdeflate.h>
#include <lz4.h>
#include <xgboost/c_api.h>
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

std::string xgboost_version() {
  int major = 0, minor = 0, patch = 0;
  XGBoostVersion(&major, &minor, &patch);
  return fmt::format("{}.{}.{}", major, minor, patch);
}

}  // namespace

std::vector<LibraryVersion> library_versions() {
  return {{"libtorch", model::torch_version()}, {"OpenCV", cv::getVersionString()},       {"HDF5", hdf5_version()},
          {"FFmpeg", av_version_info()},        {"XGBoost", xgboost_version()},           {"LZ4", LZ4_versionString()},
          {"zstd", ZSTD_versionString()},       {"libdeflate", LIBDEFLATE_VERSION_STRING}};
}

std::string libraries_text() {
  std::vector<std::pair<std::string, std::string>> lines;
  for (const LibraryVersion& library : library_versions()) lines.emplace_back(library.name, library.version);
  const std::vector<std::string> targets = model::LeNetEngine::targets();
  const std::vector<std::string> others(targets.begin() + 1, targets.end());
  lines.emplace_back("CPU features", others.empty()
                                         ? targets.front() + " in use"
                                         : fmt::format("{} in use, also {}", targets.front(), fmt::join(others, ", ")));
  std::string text = text_list(lines);
  text.pop_back();  // CLI11 ends the last line
  return text;
}

}  // namespace tactile::cli
