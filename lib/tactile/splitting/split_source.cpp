#include "tactile/splitting/split_source.hpp"

#include <algorithm>
#include <cctype>
#include <optional>
#include <string_view>
#include <system_error>
#include <vector>

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

/// The names of a table's columns; none if it is no table: another file may have this name by chance.
std::vector<std::string> columns_of(const fs::path& file) {
  if (!is_file(file)) return {};
  try {
    return TableFile(file, {.name = "a table", .header = "names of columns", .ends_in_any_bytes = true}).names();
  } catch (const Error&) {
    return {};
  }
}

bool has(const std::vector<std::string>& columns, std::string_view name) {
  return std::find(columns.begin(), columns.end(), name) != columns.end();
}

bool has_film_times(const fs::path& file) {
  const std::vector<std::string> columns = columns_of(file);
  return has(columns, "index") && has(columns, "pts_us");
}

/// Whether it has times and any of the columns that motion follows from.
bool is_robot_log(const fs::path& file) {
  const std::vector<std::string> columns = columns_of(file);
  const auto is_motion = [](const std::string& column) {
    return column.starts_with("actual_TCP_") || column.starts_with("actual_q") || column.starts_with("target_TCP_") ||
           column.starts_with("target_q");
  };
  return has(columns, "timestamp") && std::any_of(columns.begin(), columns.end(), is_motion);
}

constexpr std::string_view recordings[] = {".aedat4", ".raw", ".bag", ".db3", ".mcap"};

bool names_more_than(const std::string& file, const std::string& name) {
  return file.size() > name.size() && file.starts_with(name) && std::isalnum(static_cast<unsigned char>(file[name.size()])) == 0;
}

/// The only robot log whose name begins with that of the recording, "take 1 robot.csv" or "take 1_rtde.csv", and not with the
/// longer one of another recording; nothing if there is none, or are several.
std::optional<fs::path> robot_log_named_after(const fs::path& recording) {
  const std::string name = recording.filename().string();
  std::vector<fs::path> logs;
  std::vector<std::string> longer;
  std::error_code failed;
  const fs::path folder = recording.has_parent_path() ? recording.parent_path() : fs::path(".");
  for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed)) {
    if (!names_more_than(entry->path().filename().string(), name)) continue;
    const std::string extension = entry->path().extension().string();
    if (entry->is_directory() || std::find(std::begin(recordings), std::end(recordings), extension) != std::end(recordings))
      longer.push_back(entry->path().stem().string());
    else if (extension == ".csv" && is_robot_log(entry->path()))
      logs.push_back(entry->path());
  }
  std::erase_if(logs, [&](const fs::path& log) {
    return std::any_of(longer.begin(), longer.end(), [&](const std::string& other) {
      return other.size() > name.size() && names_more_than(log.filename().string(), other);
    });
  });
  return logs.size() == 1 ? std::optional(logs.front()) : std::nullopt;
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
  fs::path name = recording.lexically_normal();
  if (!name.has_filename()) name = name.parent_path();  // "bag/" ends in an empty part
  if (!fs::is_directory(name)) name.replace_extension();
  const auto with = [&](const char* extension) { return fs::path(name).concat(extension); };
  if (!source.robot) take_if_there(source.robot, with(".robot.csv"));
  if (!source.robot && with(".csv") != recording && is_robot_log(with(".csv"))) source.robot = with(".csv");
  if (!source.robot) source.robot = robot_log_named_after(name);
  if (!source.video && is_file(with(".mp4"))) set_video(source, with(".mp4"));
}

void set_video(SplitSource& source, const fs::path& video) {
  if (!is_file(video)) throw Error(video.string() + ": no such file; expected a film");
  source.video = video;
  const fs::path times = fs::path(video).replace_extension(".csv");
  source.video_times = has_film_times(times) ? std::optional(times) : std::nullopt;
}

std::string session_of(const SplitSource& source, const events::Stream& stream, const std::string& sha256) {
  if (source.info && !source.info->session.empty()) return source.info->session;
  if (const auto start = labels::camera_session_of(stream)) return *start;
  return fs::path(source.origin).stem().string() + "-" + sha256.substr(0, 8);
}

}  // namespace tactile::splitting
