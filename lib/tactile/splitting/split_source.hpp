#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "tactile/core/run_folder.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::splitting {

/// A long recording, and the files that belong to it.
struct SplitSource {
  std::filesystem::path recording;  ///< AEDAT4
  std::string name;                 ///< what was given, for messages
  std::string origin;               ///< its name in run.json of the runs: "fan/01", or a file's
  std::optional<RunInfo> info;      ///< its run.json
  std::optional<std::filesystem::path> robot, video, video_times, labels;
  std::string robot_columns{};  ///< of a robot log without header row, as `robot::column_names` takes them
};

/// The recording at `what`, a file or a run's folder. The other files are those of the run if the recording has the name that it
/// has in a run, `events.aedat4`. @throws Error  if there is no recording, or run.json cannot be read
SplitSource split_source_at(const std::filesystem::path& what);

/// Takes the robot log and the film of a loose recording by their names, unless it has them. Next to `take-1.aedat4`, these are
/// `take-1.robot.csv`, or `take-1.csv` if it has a robot log's columns, else the only such file whose name begins so,
/// `take-1 rtde.csv`; and `take-1.mp4`.
/// @param recording  as it was given; of a folder (a ROS 2 bag), the extensions follow the whole name
void take_devices_of_same_name(SplitSource& source, const std::filesystem::path& recording);

/// Takes another film, and the times next to it that have its name and end in .csv, if they are a film's times.
void set_video(SplitSource& source, const std::filesystem::path& video);

/// The session of all pieces: that of run.json; else the start of the camera, if the recording has it; else one made of the
/// recording's name and hash. So the pieces share their clocks. @param sha256  of the recording
std::string session_of(const SplitSource& source, const events::Stream& stream, const std::string& sha256);

}  // namespace tactile::splitting
