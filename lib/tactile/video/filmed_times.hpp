#pragma once

#include <fmt/core.h>

#include <cstdint>
#include <string>

#include "tactile/core/time.hpp"

namespace tactile::video {

/// The columns of `video.csv` beside a recorded film, and the row of a frame, which ends in a newline.
inline constexpr const char* filmed_columns = "index,pts_us,host_time_us";

inline std::string filmed_row(std::uint64_t index, VideoTime t, HostTime came) {
  return fmt::format("{},{},{}\n", index, us_of(t), us_of(came));
}

}  // namespace tactile::video
