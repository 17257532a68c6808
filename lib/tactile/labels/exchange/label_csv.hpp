#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "tactile/labels/exchange/exchanged_labels.hpp"

namespace tactile {

/// Every run's intervals with all that is known of them, one a row; seconds with six decimals:
///
///   run,id,class,start_s,end_s,confirmed,source,start_low_s,start_high_s,end_low_s,end_high_s,events_s,robot_s,video_s,imu_s,
///   flags,origin,zero_s,drift_ppm
///
/// A run without intervals has one row of the class none. A spreadsheet keeps 15 digits, so times count from near the run, never
/// in whole microseconds of camera time, unless the origin says so.
/// @throws Error  as `check_ids`
std::string label_csv_text(std::span<const LabelsToExport> runs);

/// Reads such a file, also one that a spreadsheet wrote anew: separated by commas, semicolons or tabs, decimal commas, quotes.
/// Needs `class`, `start_s` and `end_s`; `run`, `id`, `confirmed`, `origin`, `zero_s` and `drift_ppm` count where they are there,
/// any other column is passed over. A row of the class none is no interval.
/// @throws Error  naming the row and the column where it cannot be read, or if the file is larger than 8 MiB
std::vector<ImportedLabels> read_label_csv(const std::filesystem::path& file);

}  // namespace tactile
