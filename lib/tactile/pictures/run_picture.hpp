#pragma once

#include "tactile/alignment/run_signals.hpp"
#include "tactile/pictures/label_picture.hpp"

namespace tactile::pictures {

/// What the signals of a run show of its labels: the event rate, the robot and the film through their clocks, and the IMU. What
/// has no clock is left out.
LabelPicture picture_of(const alignment::RunSignals& signals, const labels::Labels& labels);

}  // namespace tactile::pictures
