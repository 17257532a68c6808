#include "run_places.hpp"

#include <spdlog/spdlog.h>

#include <filesystem>
#include <set>

#include "tactile/core/error.hpp"
#include "tactile/core/folders_in.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

bool is_named_as_run(const fs::path& folder) { return is_run_id(folder.filename().string()); }

}  // namespace

std::vector<RunFolder> runs_of_object(const fs::path& place) {
  std::vector<RunFolder> runs;
  for (const fs::path& folder : folders_in(place)) {
    if (is_named_as_run(folder) && is_there(folder / "events.aedat4")) runs.push_back(named_run_at(folder));
  }
  return runs;
}

RunsBelow runs_in(const std::vector<std::string>& places, LeftOutFolders left_out) {
  const bool warns = left_out == LeftOutFolders::warn;
  RunsBelow all;
  const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  for (const std::string& place : places) {
    std::error_code unknown;
    if (fs::is_regular_file(place, unknown))
      throw Error(place + ": is a file; expected a run's folder, or a folder of runs: 'tactile import' makes them of recordings");
    if (fs::is_directory(place, unknown) && is_there(fs::path(place) / "events.aedat4")) {
      all.runs.push_back(named_run_at(place));
      continue;
    }
    RunsBelow found = look_for_runs(place);
    for (const std::string& misnamed : found.misnamed)
      if (warns) spdlog::warn("{}", misnamed);
    if (const std::string missing = sentence_on_missing_recordings(found.without_recording); warns && !missing.empty())
      spdlog::warn("{}", missing);
    if (found.runs.empty()) found.runs = runs_of_object(place);
    if (found.runs.empty()) {
      for (const std::string& unreadable : found.unreadable)
        if (warns) spdlog::error("{}", unreadable);
      throw Error(
          place +
          (found.misnamed.empty() && found.unreadable.empty()
               ? ": holds no run; expected DATA/<object>/<run>/events.aedat4: 'tactile import' makes such folders of recordings"
               : ": no run can be used, as the messages above explain; expected DATA/<object>/<run>/events.aedat4"));
    }
    append(all.runs, found.runs);
    append(all.misnamed, found.misnamed);
    append(all.without_recording, found.without_recording);
    append(all.unreadable, found.unreadable);
  }
  std::set<fs::path> seen;
  std::erase_if(all.runs, [&](const RunFolder& run) {
    std::error_code unknown;
    const fs::path place = fs::weakly_canonical(run.folder, unknown);
    return !seen.insert(unknown ? run.folder : place).second;
  });
  return all;
}

}  // namespace tactile::cli
