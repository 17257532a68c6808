#pragma once

#include <filesystem>
#include <string>

#include "tactile/labels/exchange/exchanged_labels.hpp"

namespace tactile {

/// An annotation document of ELAN (EAF 3.0). The tier `touch` holds the intervals in whole milliseconds, "press" or "slip", with
/// " ok" once a person confirmed it, its ANNOTATION_ID being the interval's id; a vocabulary offers the four values. The tiers
/// `onset 95 %` and `doubts` show how sure onsets are and which flags stand. Properties of the header say which run it is and
/// what its times count from; the film is linked so that ELAN plays it in step.
/// @param file  where it will lie, from which the film is found
/// @throws Error  as `check_ids`; if an interval begins before the file's time 0, which ELAN cannot hold, or two lie within one
/// millisecond
/// Source: the EAF 3.0 schema, https://www.mpi.nl/tools/elan/EAFv3.0.xsd
std::string elan_text(const LabelsToExport& labels, const std::filesystem::path& file);

/// Reads the tier `touch` of such a document; all else is passed over.
/// @throws Error  naming the annotation where it cannot be read; if the file is larger than 8 MiB, no EAF in milliseconds, has no
/// tier `touch`, or declares a document type or entities
ImportedLabels read_elan(const std::filesystem::path& file);

}  // namespace tactile
