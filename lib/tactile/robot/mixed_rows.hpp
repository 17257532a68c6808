#pragma once

#include "tactile/robot/robot_log.hpp"

namespace tactile::robot {

constexpr microseconds longest_row_step = 100ms;  ///< a recorder loses single packages now and then; longer steps are gaps

/// Drops rows that mix two packages: a pose or speed appears in two rows, while before and after them it changes (a speed by
/// 0.5 mm/s) and the arm moves (5 mm/s, and by more than the rounding of the log's numbers). Of the two, the row that fits their
/// neighbours worse is dropped and counted.
void drop_mixed_rows(RobotLog& log, bool has_speeds, bool has_poses);

}  // namespace tactile::robot
