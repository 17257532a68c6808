#include "robot_columns.hpp"

#include "option_checks.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile::cli {

Option add_robot_columns_option(Command& command, std::string& columns) {
  return command
      .add_option("--robot-columns", columns,
                  "Columns of robot logs without header row, in their order: timestamp, actual_q*6 for six, - to skip one")
      .type_name("NAMES")
      .check(readable_by(robot::column_names));
}

}  // namespace tactile::cli
