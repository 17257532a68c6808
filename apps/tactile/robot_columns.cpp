#include "robot_columns.hpp"

#include "tactile/core/error.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile::cli {
namespace {

std::string check_columns(const std::string& text) {
  try {
    robot::column_names(text);
    return {};
  } catch (const Error& e) {
    return e.what();
  }
}

}  // namespace

Option add_robot_columns_option(Command& command, std::string& columns) {
  return command
      .add_option("--robot-columns", columns,
                  "Columns of robot logs without header row, in their order: timestamp, actual_q*6 for six, - to skip one")
      .type_name("NAMES")
      .check(Check{check_columns, ""});
}

}  // namespace tactile::cli
