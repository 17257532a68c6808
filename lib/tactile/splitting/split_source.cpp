#include "tactile/splitting/split_source.hpp"

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

/// Whether it is a table with the times of a film's frames.
bool has_film_times(const fs::path& file) {
  if (!is_file(file)) return false;
  try {
    const TableFile table(file, {.name = "the times of a film's frames", .header = "index,pts_us", .ends_in_any_bytes = true});
    return table.find("index") && table.find("pts_us");
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

void set_video(SplitSource& source, const fs::path& video) {
  if (!is_file(video)) throw Error(video.string() + ": no such file; expected a film");
  source.video = video;
  const fs::path times = fs::path(video).replace_extension(".csv");
  source.video_times = has_film_times(times) ? std::optional(times) : std::nullopt;
}

std::string session_of(const SplitSource& source, const events::RecordingReader& recording, const std::string& sha256) {
  if (source.info && !source.info->session.empty()) return source.info->session;
  if (const auto start = labels::camera_session_of(recording)) return *start;
  return fs::path(source.origin).stem().string() + "-" + sha256.substr(0, 8);
}

}  // namespace tactile::splitting
