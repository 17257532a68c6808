#include "tactile/core/run_folder.hpp"

#include <algorithm>
#include <array>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/json_object.hpp"
#include "tactile/core/runs_below.hpp"

namespace tactile {
namespace fs = std::filesystem;
namespace {

/// Whether the folder is a bag of ROS 2.
bool has_bag(const fs::path& folder) {
  std::error_code unknown;
  for (fs::directory_iterator entry(folder, unknown), end; !unknown && entry != end; entry.increment(unknown)) {
    const fs::path name = entry->path().extension() == ".zstd" ? entry->path().stem() : entry->path();
    if (name.extension() == ".db3" || name.extension() == ".mcap") return true;
  }
  return false;
}

}  // namespace

bool is_run_id(std::string_view name) {
  return name.size() == 2 && name[0] >= '0' && name[0] <= '9' && name[1] >= '0' && name[1] <= '9' && name != "00";
}

bool is_object_name(std::string_view name) {
  const auto is_plain = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); };
  return !name.empty() && is_plain(name.front()) && is_plain(name.back()) &&
         std::all_of(name.begin(), name.end(), [&](char c) { return is_plain(c) || c == '-'; });
}

RunFolder run_folder_at(const fs::path& folder) {
  std::error_code why;
  if (!fs::is_directory(folder, why)) {
    const bool is_unknown = why && why != std::errc::no_such_file_or_directory;
    throw Error(folder.string() + (is_unknown ? ": cannot be read (" + why.message() + ")" : std::string(": no such folder")) +
                "; expected a run, DATA/<object>/<run>");
  }
  fs::path whole = fs::absolute(folder).lexically_normal();
  if (!whole.has_filename()) whole = whole.parent_path();  // "fan/03/" ends in an empty part
  return {folder, whole.parent_path().filename().string(), whole.filename().string()};
}

std::vector<RunFolder> find_runs(const fs::path& data) { return look_for_runs(data).runs; }

fs::path recording_in(const fs::path& folder) {
  const fs::path file = folder / "events.aedat4";
  std::error_code why;
  if (fs::is_regular_file(file, why)) return file;
  if (why && why != std::errc::no_such_file_or_directory)
    throw Error(file.string() + ": cannot be read (" + why.message() + "); expected a readable recording");
  if (has_bag(folder))
    throw Error(folder.string() +
                ": is a ROS bag, not a recording; expected what 'tactile convert' makes of it, a recording or a run folder");
  const std::vector<RunFolder> runs = fs::is_directory(folder, why) ? find_runs(folder) : std::vector<RunFolder>{};
  if (runs.empty()) throw Error(folder.string() + ": has no events.aedat4; expected a run folder or a recording");
  throw Error(folder.string() + ": is a folder of " + (runs.size() == 1 ? "a run" : std::to_string(runs.size()) + " runs") +
              "; expected one run, such as " + runs.front().folder.string());
}

RunInfo read_run_info(const RunFolder& run) {
  nlohmann::json json = read_json(run.info());
  const std::string where = run.info().string();
  check_object(json, where + ":", " with the run's members");
  RunInfo info{
      .object = member<std::string>(json, "object", where),
      .run = member<std::string>(json, "run", where),
      .session = json.contains("session") ? member<std::string>(json, "session", where) : std::string(),
      .simulated = member<bool>(json, "simulated", where),
      .complete = member<bool>(json, "complete", where),
  };
  const auto sensor = member<nlohmann::json>(json, "sensor", where);
  info.width = member<int>(sensor, "width", where);
  info.height = member<int>(sensor, "height", where);
  if (info.width <= 0 || info.height <= 0) throw Error(where + ": 'sensor' has no area; expected width and height of at least 1");
  for (const char* known : std::array{"object", "run", "session", "simulated", "complete", "sensor"}) json.erase(known);
  info.extra = std::move(json);
  return info;
}

nlohmann::json json_of(const RunInfo& info) {
  nlohmann::json json = info.extra;
  json["object"] = info.object;
  json["run"] = info.run;
  json["session"] = info.session;
  json["simulated"] = info.simulated;
  json["complete"] = info.complete;
  json["sensor"] = {{"width", info.width}, {"height", info.height}};
  return json;
}

void write_run_info(const RunFolder& run, const RunInfo& info) { write_json(run.info(), json_of(info)); }

}  // namespace tactile
