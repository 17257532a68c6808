#include "tactile/capture/new_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "tactile/core/error.hpp"
#include "tactile/core/make_folders.hpp"
#include "tactile/core/renaming.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::capture {
namespace fs = std::filesystem;
namespace {

constexpr int most_runs = 99;

/// The next number to try; 0 if all are taken.
int next_number(const fs::path& object) {
  std::array<bool, most_runs + 1> taken{};
  int highest = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(object)) {
    const std::string name = entry.path().filename().string();
    if (!is_run_id(name)) continue;
    const int number = 10 * (name[0] - '0') + (name[1] - '0');
    taken[static_cast<std::size_t>(number)] = true;
    highest = std::max(highest, number);
  }
  if (highest < most_runs) return highest + 1;
  const auto free = std::find(taken.begin() + 1, taken.end(), false);
  return free == taken.end() ? 0 : static_cast<int>(free - taken.begin());
}

}  // namespace

RunFolder make_run_folder(const fs::path& data, const std::string& object, const std::string& run) {
  if (!is_object_name(object)) {
    throw Error(fmt::format(
        "'{}' is not a name for an object; expected lower-case letters, digits and inner hyphens, such as usb-hub", object));
  }
  if (!run.empty() && !is_run_id(run)) throw Error(fmt::format("'{}' is not a run; expected two digits, 01 to 99", run));
  make_folders(data / object);
  std::error_code failed;
  for (;;) {
    const int number = run.empty() ? next_number(data / object) : 0;
    if (run.empty() && number == 0) {
      throw Error(fmt::format("{}: the runs 01 to 99 all exist; expected a free number", (data / object).string()));
    }
    const std::string id = run.empty() ? fmt::format("{:02}", number) : run;
    const fs::path folder = data / object / id;
    const bool made = fs::create_directory(folder, failed);
    if (failed && failed != std::errc::file_exists)
      throw Error(
          fmt::format("{}: the folder cannot be created ({}); expected a writable place", folder.string(), failed.message()));
    if (made) {
      sync_to_disk(data / object);
      return {folder, object, id};
    }
    if (!run.empty()) {
      throw Error(folder.string() + ": the run exists already, and is never overwritten; expected a free number");
    }
  }
}

fs::path discard_run(const RunFolder& run) {
  const fs::path beside = run.folder.parent_path();
  for (int k = 1;; ++k) {
    const fs::path target = beside / fmt::format("{}.discarded-{}", run.run, k);
    const int error = rename_if_free(run.folder, target);
    if (error == EEXIST) continue;
    if (error != 0) {
      throw Error(fmt::format("{}: cannot be renamed to {} ({}); expected a writable place", run.folder.string(),
                              target.filename().string(), std::strerror(error)));
    }
    sync_to_disk(beside);
    return target;
  }
}

}  // namespace tactile::capture
