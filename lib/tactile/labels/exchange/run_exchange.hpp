#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/labels/exchange/exchanged_labels.hpp"
#include "tactile/labels/exchange/import_edits.hpp"

namespace tactile {

/// The first and the last event of a run's recording.
struct RecordingSpan {
  CameraTime first{}, last{};
};

/// @throws Error  if the recording cannot be read or has no event
RecordingSpan span_of_events(const RunFolder& run);

/// The labels that a run has, on the axis of `origin`; without one on the film's where `prefer_film`, its clock is known and no
/// label lies before it, else from the first event on.
/// @throws Error  if there are none, they or the recording cannot be read, or the origin is the film and its clock is unknown
LabelsToExport labels_to_export(const RunFolder& run, std::optional<TimeOrigin> origin, bool prefer_film);

/// Events a second, and where a robot log's clock is known the TCP's height and speed, each millisecond (more for recordings of
/// more than 20 s), on the labels' axis. @throws Error if recording or log cannot be read
LabelSignals signals_of(const RunFolder& run, const LabelsToExport& labels);

/// What an import does to one run.
struct ImportedRun {
  RunFolder run;
  std::string file;
  Labels labels;
  EditCounts counts;
  bool looked_at = true;
};

/// Reads files of other tools, `format` or what their endings say, and works out what they do to the labels of `runs`; writes
/// nothing. Which run a file is of it says itself, else its name does (`fan-01.txt`), else there must be but one run. What its
/// times count from it says itself too, else `origin`, else the first event.
/// @throws Error  if a file is of no run or of none of `runs`, two are of one, a run has no labels, or anything in them cannot be
/// used
std::vector<ImportedRun> read_edits(std::span<const std::filesystem::path> files, std::optional<ExchangeFormat> format,
                                    std::optional<TimeOrigin> origin, std::span<const RunFolder> runs);

/// "fan-01" of "fan/01": the name of its file in a folder of exports.
std::string file_stem_of(const RunFolder& run);

}  // namespace tactile
