#include "camera_time.hpp"

namespace tactile::cli {

Option add_camera_time_option(Command command, bool& camera_time) {
  return command.add_flag("--camera-time", camera_time,
                          "Print camera times instead of seconds since the recording's first event");
}

}  // namespace tactile::cli
