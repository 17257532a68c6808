#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/labels/exchange/exchanged_labels.hpp"
#include "tactile/labels/exchange/import_edits.hpp"
#include "tactile/labels/label_edit.hpp"
#include "tactile/labels/recording_span.hpp"

namespace tactile::labels {

/// The labels of a run, on the axis of `origin`.
/// @throws Error  if the run has no labels, they or the recording cannot be read, or the origin is the film and its clock is
/// unknown
LabelsToExport labels_to_export(const RunFolder& run, TimeOrigin origin);

/// The event rate and, if the robot's clock is known, the TCP's height and speed, every millisecond (less often for recordings
/// above 20 s), on the labels' axis. @throws Error  if recording or log cannot be read
LabelSignals signals_of(const RunFolder& run, const LabelsToExport& labels);

/// The effect of an import on one run.
struct ImportedRun {
  RunFolder run;
  std::string file;
  std::string before_version;  ///< of the labels that the effect was computed from
  ImportFile edit;             ///< for `save_edit`, with that version
  EditCounts counts;
  std::vector<std::string> changes;  ///< each in words, as `words_of_changes` has them
  bool looked_at = true;
};

/// Reads files of other tools and computes what they change in the labels of `runs`; writes nothing. The format is `format`,
/// otherwise given by the file's ending. The run is named in the file, otherwise by its name (`fan-01.csv`), otherwise there must
/// be only one run. The origin of times is given in the file, otherwise by `origin`, otherwise it is the first event. If the file
/// does not say when the film begins, the run's video clock does.
/// @throws Error  if a file belongs to none of `runs`, two files belong to the same run, a run has no labels, or a file is
/// invalid
std::vector<ImportedRun> read_edits(std::span<const std::filesystem::path> files, std::optional<ExchangeFormat> format,
                                    std::optional<TimeOrigin> origin, std::span<const RunFolder> runs);

/// "fan-01" for "fan/01": the name of a run's file in a folder of exports.
std::string file_stem_of(const RunFolder& run);

}  // namespace tactile::labels
