#include <fstream>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/run_files.hpp"
#include "tactile/core/run_folder.hpp"

/// For any run.json, it is read, its files are compared and it is printed, or there is an Error.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactile;
  static const test::TemporaryFolder folder;
  const RunFolder run{folder.path(), "fan", "01"};
  std::ofstream(run.info(), std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    const RunInfo info = read_run_info(run);
    check_files(run, info, FileComparison::contents);
    json_of(info).dump();
  } catch (const Error&) {
  }
  return 0;
}
