#pragma once

#include <compare>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tactile {

/// Where one run's files lie: `DATA/<object>/<run>/`. A run's id is two digits from "01"; object names are lower-case letters,
/// digits and hyphens.
struct RunFolder {
  std::filesystem::path folder;
  std::string object;
  std::string run;

  std::filesystem::path events() const { return folder / "events.aedat4"; }
  std::filesystem::path robot() const { return folder / "robot.csv"; }
  std::filesystem::path video() const { return folder / "video.mp4"; }
  std::filesystem::path video_times() const { return folder / "video.csv"; }
  std::filesystem::path info() const { return folder / "run.json"; }
  std::filesystem::path labels() const { return folder / "labels.json"; }
  std::filesystem::path truth() const { return folder / "truth.json"; }
  std::string name() const { return object + "/" + run; }
};

/// What `run.json` says of a run; `extra` holds every member that is not named here, and is written back as it was read.
struct RunInfo {
  std::string object;
  std::string run;
  std::string session;  ///< runs that share one start of camera and controller, and so their clocks; may be empty
  bool simulated = false;
  bool complete = false;  ///< false until the recording is closed
  int width = 0;          ///< [px] > 0
  int height = 0;         ///< [px] > 0
  nlohmann::json extra = nlohmann::json::object();
};

bool is_run_id(std::string_view name);       ///< two digits from "01"
bool is_object_name(std::string_view name);  ///< lower-case letters, digits and inner hyphens

/// The run in `folder`, named by its last two parts. @throws Error if there is no such folder
RunFolder run_folder_at(const std::filesystem::path& folder);

/// Every run below `data` that holds an `events.aedat4`, by object, then run; folders with other names are passed over.
/// @throws Error if `data` is no folder
std::vector<RunFolder> find_runs(const std::filesystem::path& data);

/// The recording of the run in `folder`. @throws Error if there is none; it names a run where `folder` holds runs instead
std::filesystem::path recording_in(const std::filesystem::path& folder);

/// @throws Error if `run.json` is missing, no JSON, or lacks a member
RunInfo read_run_info(const RunFolder& run);
nlohmann::json json_of(const RunInfo& info);  ///< as `run.json` holds it
void write_run_info(const RunFolder& run, const RunInfo& info);

}  // namespace tactile
