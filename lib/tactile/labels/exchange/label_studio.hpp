#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "tactile/labels/exchange/exchanged_labels.hpp"

namespace tactile::labels {

/// Tasks of Label Studio. `data` has the run, its flags as text, the origin of its times, and the signals, so that one file is
/// enough to import. The labels are a prediction with score 0 if there is an unconfirmed flag, otherwise 1. If a person has
/// confirmed all labels of a run, they are also an annotation. A result's id is the interval's id.
/// @throws Error  as `check_ids`
/// Source: Label Studio's documentation, "Import pre-annotated data" and the tag TimeSeries.
std::string label_studio_text(std::span<const LabelsToExport> runs);

/// The labelling configuration for such tasks, to be pasted under Settings, Labeling Interface, Code. It has the curves of the
/// first task.
std::string label_studio_config(std::span<const LabelsToExport> runs);

/// Reads Label Studio's export as JSON (not JSON-MIN). Each run gets the intervals of its only annotation that was not cancelled,
/// all confirmed. A run without such an annotation has not been annotated.
/// @throws Error  with task and result, if it cannot be read, or if the file is larger than 256 MiB
std::vector<ImportedLabels> read_label_studio(const std::filesystem::path& file);

}  // namespace tactile::labels
