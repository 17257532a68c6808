#include "tactile/splitting/split_source.hpp"

#include <algorithm>
#include <initializer_list>
#include <string_view>

#include "tactile/core/error.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/core/table_file.hpp"
#include "tactile/labels/session_name.hpp"

namespace tactile::splitting {
namespace fs = std::filesystem;
namespace {

void take_if_there(std::optional<fs::path>& place, const fs::path& file) {
  if (is_file(file)) place = file;
}

/// Whether it is a table with these columns.
bool has_columns(const fs::path& file, std::initializer_list<std::string_view> names) {
  if (!is_file(file)) return false;
  try {
    const TableFile table(file, {.name = "a table", .header = "names of columns", .ends_in_any_bytes = true});
    return std::all_of(names.begin(), names.end(), [&](std::string_view name) { return table.find(name).has_value(); });
  } catch (const Error&) {
    return false;  // another file that has this name by chance
  }
}

}  // namespace

SplitSource split_source_at(const fs::path& what) {
  SplitSource source{.recording = fs::is_directory(what) ? recording_in(what) : what,
                     .name = what.string(),
                     .origin = what.filename().string(),
                     .info = {},
                     .robot = {},
                     .video = {},
                     .video_times = {},
                     .labels = {}};
  if (!is_file(source.recording)) throw Error(source.name + ": no such file; expected a recording or a run folder");
  const fs::path folder = source.recording.has_parent_path() ? source.recording.parent_path() : fs::path(".");
  const RunFolder run = run_folder_at(folder);
  if (source.recording.filename() != run.events().filename()) return source;
  source.origin = run.name();
  if (is_file(run.info())) source.info = read_run_info(run);
  take_if_there(source.robot, run.robot());
  take_if_there(source.labels, run.labels());
  if (is_file(run.video())) set_video(source, run.video());
  return source;
}

void take_devices_of_same_name(SplitSource& source, const fs::path& recording) {
  for (const char* extension : {".robot.csv", ".csv"}) {
    const fs::path log = fs::path(recording).replace_extension(extension);
    if (!source.robot && log != recording && has_columns(log, {"timestamp"})) source.robot = log;
  }
  if (const fs::path film = fs::path(recording).replace_extension(".mp4"); !source.video && is_file(film))
    set_video(source, film);
}

void set_video(SplitSource& source, const fs::path& video) {
  if (!is_file(video)) throw Error(video.string() + ": no such file; expected a film");
  source.video = video;
  const fs::path times = fs::path(video).replace_extension(".csv");
  source.video_times = has_columns(times, {"index", "pts_us"}) ? std::optional(times) : std::nullopt;
}

std::string session_of(const SplitSource& source, const events::RecordingReader& recording, const std::string& sha256) {
  if (source.info && !source.info->session.empty()) return source.info->session;
  if (const auto start = labels::camera_session_of(recording)) return *start;
  return fs::path(source.origin).stem().string() + "-" + sha256.substr(0, 8);
}

}  // namespace tactile::splitting
