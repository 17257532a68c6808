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

namespace tactile {

/// Why a run gives no samples.
struct NoSamples {
  std::string words;     ///< before "in mug/02": "slip-1 is flagged", "the whole run is flagged", "no slip"
  std::string clause;    ///< after "run 02": ", whose slip-1 is flagged", ", which is flagged", ", which has no slip"
  std::string flags;     ///< what the flags say: "its end is only known to within 232 ms"; empty where none is the reason
  bool flagged = false;  ///< a person may lift the flags
};

struct RunWithoutSamples {
  std::string object, run;
  NoSamples reason;
};

/// "no ticks of press": which has, which lacks.
NoSamples has_no(const std::string& what);

/// Why a run with these labels gives no samples: a flag on it, or no press or slip that is not flagged; nothing if there are
/// both.
std::optional<NoSamples> why_no_samples(const Labels& labels, bool include_flagged);

/// Why this run gives the dataset no samples, by its labels as they are now; nothing if it gives some.
std::optional<NoSamples> why_no_samples(const Dataset& dataset, const RunFolder& run);

/// The folder DATA of the dataset's runs.
std::filesystem::path data_folder_of(const Dataset& dataset);

/// The object's run in the dataset's folder DATA, or where the dataset has it. The folder need not be there.
RunFolder run_of(const Dataset& dataset, const std::string& object, const std::string& run);

/// Those of the runs that give the dataset no samples, in their order.
std::vector<RunWithoutSamples> runs_without_samples(const Dataset& dataset, std::span<const RunFolder> runs);

/// The runs of each object of which no run gives the dataset samples, by object, then run. Of an object that has no run in the
/// dataset, only where a flag is a reason: others may have been recorded since.
std::vector<RunWithoutSamples> runs_of_objects_left_out(const Dataset& dataset);

/// "slip-1 is flagged in mug/02, mug/03; no slip in jar/01": by reason, each in the order of the runs.
std::string reasons_of(std::span<const RunWithoutSamples> runs);

/// Objects of which no run has samples: "jar: left out, none of its runs has samples: slip-1 is flagged in jar/01, jar/02". By
/// name.
std::vector<std::string> objects_left_out(std::span<const RunWithoutSamples> runs, const std::set<std::string>& with_samples);

/// What --strict does about them. @throws Error  if there are any
void refuse_objects_left_out(std::span<const std::string> sentences);

/// "3 of 12 runs have no samples: slip-1 is flagged in mug/02, mug/03, jar/01. ", and how to lift the flags, where there are any.
/// @param data  the folder of all runs  @param command  as of `how_to_lift_flags`
std::string sentence_on(std::span<const RunWithoutSamples> runs, std::size_t of_all, const std::filesystem::path& data,
                        const std::string& command);

/// What a person does about flags. @param run  flagged  @param command  that is to be run again, such as "tactile windows"
std::string how_to_lift_flags(const RunFolder& run, const std::string& command);

}  // namespace tactile
