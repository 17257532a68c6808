#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tactile/core/error.hpp"
#include "tactile/core/run_files.hpp"
#include "tactile/core/run_folder.hpp"

namespace {

/// A run's folder that goes when the fuzzer does.
struct Folder {
  std::filesystem::path path = std::filesystem::temp_directory_path() / ("tactile-fuzz-" + std::to_string(getpid()));
  Folder() { std::filesystem::create_directories(path); }
  ~Folder() { std::filesystem::remove_all(path); }
};

}  // namespace

/// Whatever run.json holds: it is read, its files are compared and it is printed, or an Error says why not.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactile;
  static const Folder folder;
  const RunFolder run{folder.path, "fan", "01"};
  std::ofstream(run.info(), std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    const RunInfo info = read_run_info(run);
    check_files(run, info, FileComparison::contents);
    json_of(info).dump();
  } catch (const Error&) {
  }
  return 0;
}
