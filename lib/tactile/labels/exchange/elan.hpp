#pragma once

#include <filesystem>
#include <string>

#include "tactile/labels/exchange/exchanged_labels.hpp"

namespace tactile::labels {

/// An annotation document of ELAN (EAF 3.0). The tier `touch` has the intervals in whole milliseconds, "press" or "slip", with "
/// ok" if a person confirmed it. The ANNOTATION_ID is the interval's id. A vocabulary offers the four values. The tiers `onset 95
/// %` and `doubts` show the uncertainty of onsets and the flags. Properties of the header name the run and the origin of its
/// times. The film is linked, so that ELAN plays it synchronously.
/// @param file  the path of the document, to which the film's path is relative
/// @throws Error  as `check_ids`; if an interval begins before the file's time 0, or two lie within one millisecond: ELAN cannot
///                represent either
/// Source: the EAF 3.0 schema, https://www.mpi.nl/tools/elan/EAFv3.0.xsd
std::string elan_text(const LabelsToExport& labels, const std::filesystem::path& file);

/// Reads the tier `touch` of such a document and ignores the rest.
/// @throws Error  with the annotation, if it cannot be read; if the file is larger than 8 MiB, is not EAF in milliseconds, has no
/// tier
///                `touch`, or declares a document type or entities
ImportedLabels read_elan(const std::filesystem::path& file);

}  // namespace tactile::labels
