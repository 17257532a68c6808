#include "tactile/capture/new_run.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <set>
#include <system_error>

#include "tactile/core/error.hpp"
#include "tactile/core/make_folders.hpp"
#include "tactile/core/renaming.hpp"
#include "tactile/core/run_numbers.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::capture {
namespace fs = std::filesystem;
namespace {

/// The next number to try; 0 if all are taken.
int next_number(const fs::path& object) {
  const std::set<int> taken = run_numbers_in(object);
  if (taken.empty() || *taken.rbegin() < most_runs) return taken.empty() ? 1 : *taken.rbegin() + 1;
  for (int number = 1; number <= most_runs; ++number) {
    if (!taken.contains(number)) return number;
  }
  return 0;
}

}  // namespace

RunFolder make_run_folder(const fs::path& data, const std::string& object, const std::string& run) {
  if (const std::string why = why_not_an_object_name(object); !why.empty()) throw Error(why);
  if (!run.empty() && !is_run_id(run)) throw Error(fmt::format("'{}' is not a run; expected two digits, 01 to 99", run));
  make_folders(data / object);
  std::error_code failed;
  for (;;) {
    const int number = run.empty() ? next_number(data / object) : 0;
    if (run.empty() && number == 0) {
      throw Error(fmt::format("{}: the runs 01 to 99 all exist; expected a free number", (data / object).string()));
    }
    const std::string id = run.empty() ? run_id_of(number) : run;
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
