#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::windows {

/// Why a run has no samples.
struct NoSamples {
  std::string words;     ///< before "in mug/02": "slip-1 is flagged", "the whole run is flagged", "no slip"
  std::string clause;    ///< after "run 02": ", whose slip-1 is flagged", ", which is flagged", ", which has no slip"
  std::string flags;     ///< the flags' reasons: "its end is only known to within 232 ms"; empty if no flag is the reason
  bool flagged = false;  ///< a person may lift the flags
  bool unreadable = false;
};

struct RunWithoutSamples {
  std::string object, run;
  NoSamples reason;
};

/// "no ticks of press" as words and clause.
NoSamples has_no(const std::string& what);

/// Why a run with these labels has no samples: it is flagged, or it has no unflagged press or slip. Nothing if it has both.
std::optional<NoSamples> why_no_samples(const labels::Labels& labels, bool include_flagged);

/// Why this run has no samples in the dataset, according to its present labels; nothing if it has some.
std::optional<NoSamples> why_no_samples(const Dataset& dataset, const RunFolder& run);

/// The folder DATA of the dataset's runs.
std::filesystem::path data_folder_of(const Dataset& dataset);

/// The folder of an object's run: as the dataset has it, otherwise in its folder DATA. It need not exist.
RunFolder run_of(const Dataset& dataset, const std::string& object, const std::string& run);

/// The runs without samples in the dataset, in their order.
std::vector<RunWithoutSamples> runs_without_samples(const Dataset& dataset, std::span<const RunFolder> runs);

/// The runs of all objects without samples in the dataset, by object, then run. Objects without a run in the dataset count only
/// if a flag is a reason: others may have been recorded later.
std::vector<RunWithoutSamples> runs_of_objects_left_out(const Dataset& dataset);

/// "slip-1 is flagged in mug/02, mug/03; no slip in jar/01": grouped by reason.
std::string reasons_of(std::span<const RunWithoutSamples> runs);

/// A sentence for each object without samples, by name: "jar: left out, none of its runs has samples: slip-1 is flagged in
/// jar/01".
std::vector<std::string> objects_left_out(std::span<const RunWithoutSamples> runs, const std::set<std::string>& with_samples);

/// Implements --strict. @throws Error  if there are any sentences
void refuse_objects_left_out(std::span<const std::string> sentences);

/// "3 of 12 runs have no samples: slip-1 is flagged in mug/02, mug/03, jar/01. ", and how to lift the flags, if there are any.
/// @param data  the folder of all runs  @param command  as of `how_to_lift_flags`
std::string sentence_on(std::span<const RunWithoutSamples> runs, std::size_t of_all, const std::filesystem::path& data,
                        const std::string& command);

/// How a person lifts flags. @param run  a flagged run  @param command  to run again, such as "tactile windows"
std::string how_to_lift_flags(const RunFolder& run, const std::string& command);

}  // namespace tactile::windows
