#pragma once

#include <filesystem>
#include <string>

#include "tactile/labels/exchange/exchanged_labels.hpp"

namespace tactile::labels {

/// A label track of Audacity: UTF-8, one label per line, `start TAB end TAB text`, seconds with six decimals. The text is the
/// interval's id, its class, half the 95 % interval of its onset, and "ok" if a person confirmed it. The first label, a point at
/// time 0, describes the track: "# fan/01 from first-event".
/// @throws Error  as `check_ids`
/// Source: Audacity's manual, "Importing and Exporting Labels".
std::string audacity_text(const LabelsToExport& labels);

/// Reads such a track. Lines of frequencies (they begin with a backslash) and labels that begin with '#' are ignored.
/// @throws Error  with the line, if it cannot be read, or if the file is empty or larger than 8 MiB
ImportedLabels read_audacity(const std::filesystem::path& file);

}  // namespace tactile::labels
