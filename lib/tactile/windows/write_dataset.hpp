#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/windows/sample.hpp"

namespace tactile::windows {

struct WindowsOptions {
  SamplingOptions sampling{};
  bool mix = false;              ///< use simulated and real runs together; otherwise only the real ones if there are both
  bool include_flagged = false;  ///< use flagged labels too
  bool strict = false;           ///< an object without samples is an error
};

/// The outcome of one run.
struct WindowedRun {
  std::string object;
  std::string run;
  bool in_dataset = false;
  std::array<std::uint64_t, touch_count> samples{};  ///< by the value of Touch
  std::string remark;  ///< why it is left out or has no samples, or what of it is left out; may be empty
};

/// What a dataset took from the one that it replaced: names of runs, "fan/01".
struct DatasetChanges {
  std::vector<std::string> added;
  std::vector<std::string> changed;  ///< other recording, labels or samples
  std::vector<std::string> dropped;  ///< no longer in the dataset
  std::vector<std::string> kept;     ///< not read, nor stored again
};

struct DatasetSummary {
  enum class Outcome { written, replaced, moved, unchanged };  ///< moved: the same, but its runs lie elsewhere
  Outcome outcome = Outcome::written;
  bool was_damaged = false;               ///< the replaced dataset could not be read
  std::optional<DatasetChanges> changes;  ///< if an older dataset was replaced, and its runs could be kept
  std::vector<std::string> read_runs;     ///< whose recordings were read, by name
  std::vector<WindowedRun> runs;          ///< every run found, by object, then run
  std::vector<std::string> misnamed;      ///< a sentence for each folder that is left out for its name
  std::vector<std::string> warnings;      ///< a sentence each; those of `misnamed` too
  std::vector<std::string> errors;        ///< why runs cannot be read, a sentence each; they are left out
  std::string manifest_hash;
  bool simulated = false;
  std::uint64_t samples = 0;
  std::uint64_t events = 0;
};

/// Draws balanced samples from the labelled runs below `data` and writes them, with the events of their histories, to `file`
/// and to the file of its events next to it.
///
/// An existing dataset with the same manifest is kept, with its histories. If its runs have moved, their folders are updated. A
/// dataset with another manifest is replaced: at every moment `file` is either the old or the new dataset, with its events.
/// Recordings that the old dataset knows by their hash are not read again: their events are copied from it. The bytes are those
/// of a dataset that is made at once. Old histories remain as files if `store_heatmaps` can take a run from them.
///
/// Left out, and listed in the summary: runs without labels, with unreadable files or with flags, and simulated runs if there are
/// real ones. A run that lacks a class is in the dataset without samples, and is listed with the reason. Without run.json, the
/// folder and the recording describe a run.
///
/// @param threads  0: one per core; the result does not depend on it
/// @throws Error  if no run has labels or samples, an object has no samples and `strict` is set, recordings differ in sensor
///                size, or `file` exists and is not a dataset
DatasetSummary write_dataset(const std::filesystem::path& data, const std::filesystem::path& file,
                             const WindowsOptions& options = {}, unsigned threads = 0, const ProgressCallback& progress = {});

}  // namespace tactile::windows
