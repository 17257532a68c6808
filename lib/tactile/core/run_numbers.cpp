#include "tactile/core/run_numbers.hpp"

#include <fmt/format.h>

#include <system_error>

#include "tactile/core/error.hpp"
#include "tactile/core/run_folder.hpp"

namespace tactile {
namespace fs = std::filesystem;

std::set<int> run_numbers_in(const fs::path& object) {
  std::set<int> numbers;
  std::error_code failed;
  for (fs::directory_iterator entry(object, failed), end; !failed && entry != end; entry.increment(failed)) {
    const std::string name = entry->path().filename().string();
    if (is_run_id(name)) numbers.insert(10 * (name[0] - '0') + (name[1] - '0'));
  }
  if (failed && failed != std::errc::no_such_file_or_directory)
    throw Error(fmt::format("{}: cannot be read ({}); expected a folder of runs", object.string(), failed.message()));
  return numbers;
}

std::string run_id_of(int number) { return fmt::format("{:02}", number); }

}  // namespace tactile
