#pragma once

#include <string>

#include "options.hpp"
#include "tactile/splitting/split_source.hpp"

namespace tactile::cli {

/// The options of commands that make run folders of a recording: `import` and `split`.
struct SplittingArguments {
  std::string data = "data";
  std::string robot, robot_columns, video, session, stream;
};

/// `--out`, `--robot`, `--robot-columns`, `--video`, `--session` and `--stream`. @param args  must outlive the command
void add_splitting_options(Command command, SplittingArguments& args);

/// Sets the robot log and the film that were given, instead of those next to the recording.
/// @throws Error  as `splitting::set_video`
void set_devices(splitting::SplitSource& source, const SplittingArguments& args);

}  // namespace tactile::cli
