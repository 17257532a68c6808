#include "tactile/events/whole_recording.hpp"

#include <unistd.h>

#include <string>
#include <system_error>

#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile {
namespace fs = std::filesystem;

void check_target(const fs::path& target, const fs::path& input, bool replace) {
  std::error_code failed;
  if (fs::equivalent(target, input, failed)) {
    throw Error(target.string() + ": the output is the input, " + input.string() +
                "; expected another file, the input is never written over");
  }
  const fs::file_status status = fs::symlink_status(target, failed);
  if (!fs::exists(status)) return;
  if (fs::is_directory(target, failed)) throw Error(target.string() + ": the output is a folder; expected the name of a file");
  if (!replace) throw Error(target.string() + ": the output exists already; expected a new name, or --force to replace it");
}

WholeRecording::WholeRecording(fs::path target, const fs::path& input, bool replace) : target_(std::move(target)) {
  check_target(target_, input, replace);
  const fs::path folder = target_.has_parent_path() ? target_.parent_path() : fs::path(".");
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) throw Error(folder.string() + ": the folder cannot be made (" + failed.message() + "); expected a writable place");
  temporary_ = folder / ("." + target_.stem().string() + "." + std::to_string(::getpid()) + ".part.aedat4");
  fs::remove(temporary_, failed);
}

WholeRecording::~WholeRecording() {
  std::error_code ignored;
  if (!committed_) fs::remove(temporary_, ignored);
}

void WholeRecording::commit() {
  sync_to_disk(temporary_);
  std::error_code failed;
  fs::rename(temporary_, target_, failed);
  if (failed) throw Error(target_.string() + ": cannot be put in place (" + failed.message() + "); expected a writable folder");
  committed_ = true;
  sync_to_disk(target_.has_parent_path() ? target_.parent_path() : fs::path("."));
}

}  // namespace tactile
