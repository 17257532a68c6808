#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tactile/report/report_input.hpp"
#include "tactile/results/accuracy.hpp"
#include "tactile/results/json_view.hpp"

namespace tactile::report {

// What the input of a report from a study shares with that from models.

using TableRow = std::vector<std::string>;

/// Whether the file exists; if not, a sentence on `what` is added to `input.missing`.
bool is_found(ReportInput& input, const std::filesystem::path& file, std::string_view what);

/// Reads `history.csv` of a training. @throws Error  if it is of another format
TrainingCurve training_in(const std::filesystem::path& file, const std::string& name);

/// The mean over objects first, then objects by name.
/// @param accuracies  by history in milliseconds
ReportedHistories histories_of(const std::string& runs, const std::vector<std::pair<double, results::Accuracy>>& accuracies);

/// Appends the members of an object as rows of two columns, those of objects in it by their paths.
void add_settings(std::vector<TableRow>& rows, const std::string& prefix, const results::JsonView& json);

/// Appends lines as sentences: log lines have no full stop.
void add_sentences(std::vector<std::string>& sentences, const std::vector<std::string>& lines);

/// "2 runs: fan/02, usb-hub/02"; "none"
std::string list_of_runs(const std::vector<std::string>& names);

}  // namespace tactile::report
