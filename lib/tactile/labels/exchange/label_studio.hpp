#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "tactile/labels/exchange/exchanged_labels.hpp"

namespace tactile {

/// Tasks of Label Studio: `data` has the run, its flags in words, what its times count from, and the signals themselves, so that
/// one file is all there is to import. The labels are a prediction, of score 0 while a flag stands, else 1; once a person has
/// confirmed all of a run's they are an annotation too. A result's id is the interval's.
/// @throws Error  as `check_ids`
/// Source: Label Studio's documentation, "Import pre-annotated data" and the tag TimeSeries.
std::string label_studio_text(std::span<const LabelsToExport> runs);

/// The labelling configuration that such tasks need: pasted under Settings, Labeling Interface, Code. It has the curves of the
/// first task.
std::string label_studio_config(std::span<const LabelsToExport> runs);

/// Reads Label Studio's export as JSON (not JSON-MIN). Each run has the intervals of its one annotation that was not cancelled,
/// all confirmed by having been submitted; without such an annotation nobody has looked at it.
/// @throws Error  naming task and result where it cannot be read, or if the file is larger than 256 MiB
std::vector<ImportedLabels> read_label_studio(const std::filesystem::path& file);

}  // namespace tactile
