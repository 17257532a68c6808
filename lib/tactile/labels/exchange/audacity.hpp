#pragma once

#include <filesystem>
#include <string>

#include "tactile/labels/exchange/exchanged_labels.hpp"

namespace tactile {

/// A label track of Audacity: UTF-8, one label a line, `start TAB end TAB text`, seconds with six decimals. The text is the
/// interval's id, class and half its onset's 95 % interval, then "ok" once a person confirmed it. The first label, a point at the
/// track's 0, says what the track is: "# fan/01 from first-event".
/// @throws Error  as `check_ids`
/// Source: Audacity's manual, "Importing and Exporting Labels".
std::string audacity_text(const LabelsToExport& labels);

/// Reads such a track; lines of frequencies (they begin with a backslash) are passed over, and so are labels that begin with '#'.
/// @throws Error  naming the line where it cannot be read, or if the file is empty or larger than 8 MiB
ImportedLabels read_audacity(const std::filesystem::path& file);

}  // namespace tactile
