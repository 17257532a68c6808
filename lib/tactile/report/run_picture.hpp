#pragma once

#include "tactile/core/run_folder.hpp"
#include "tactile/report/label_picture.hpp"

namespace tactile {

/// What the files of a run show of its labels: the event rate, the robot through its clock, and the IMU. What cannot be read is
/// left out, and told in a remark.
/// @throws Error  if the events cannot be read
LabelPicture picture_of(const RunFolder& run, const Labels& labels, const EventRateOptions& options = {});

}  // namespace tactile
