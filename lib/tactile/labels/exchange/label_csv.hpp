#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "tactile/labels/exchange/exchanged_labels.hpp"

namespace tactile::labels {

/// The intervals of all runs, one per row; seconds with six decimals:
///
///   run,id,class,start_s,end_s,confirmed,source,start_low_s,start_high_s,end_low_s,end_high_s,events_s,robot_s,video_s,imu_s,
///   flags,origin,zero_s,drift_ppm
///
/// A run without intervals has one row of the class none. A spreadsheet keeps only 15 digits, so times count from near the run,
/// except with the origin `camera`.
/// @throws Error  as `check_ids`
std::string label_csv_text(std::span<const LabelsToExport> runs);

/// Reads such a file, also as saved by a spreadsheet: with commas, semicolons or tabs, decimal commas, quotes. Requires `class`,
/// `start_s` and `end_s`. Uses `run`, `id`, `confirmed`, `origin`, `zero_s` and `drift_ppm` if present, and ignores other
/// columns. With the origin `video` and no `zero_s`, `times` are left to the run's own film. A row of the class none is not an
/// interval.
/// @throws Error  with the row and the column, if it cannot be read, or if the file is larger than 8 MiB
std::vector<ImportedLabels> read_label_csv(const std::filesystem::path& file);

}  // namespace tactile::labels
