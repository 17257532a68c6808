#include "splitting_arguments.hpp"

#include "option_checks.hpp"
#include "robot_columns.hpp"

namespace tactile::cli {

void add_splitting_options(Command command, SplittingArguments& args) {
  command.add_option("--out", args.data, "Folder of runs").type_name("DATA").show_default();
  command.add_option("--robot", args.robot, "Robot log; default: robot.csv next to events.aedat4")
      .type_name("FILE")
      .check(is_existing_file());
  add_robot_columns_option(command, args.robot_columns);
  command
      .add_option("--video", args.video,
                  "Film, with its times in a .csv of the same name; default: video.mp4 next to events.aedat4")
      .type_name("FILE")
      .check(is_existing_file());
  command
      .add_option("--session", args.session,
                  "Session of the runs, if several recordings share one start of camera and controller; default: that of "
                  "run.json, or a separate one for each recording")
      .type_name("NAME");
  command.add_option("--stream", args.stream, "Event stream to use, if a recording has several").type_name("ID|SOURCE");
}

void set_devices(splitting::SplitSource& source, const SplittingArguments& args) {
  if (!args.robot.empty()) source.robot = args.robot;
  source.robot_columns = args.robot_columns;
  if (!args.video.empty()) splitting::set_video(source, args.video);
}

}  // namespace tactile::cli
