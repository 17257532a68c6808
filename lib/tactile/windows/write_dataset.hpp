#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/windows/sample.hpp"

namespace tactile {

struct WindowsOptions {
  SamplingOptions sampling{};
  bool mix = false;              ///< simulated and real runs in one dataset; else the real ones where there are both
  bool include_flagged = false;  ///< flags stand in nobody's way
  bool strict = false;           ///< an object of which no run has samples is an error
};

/// What became of one run.
struct WindowedRun {
  std::string object;
  std::string run;
  bool in_dataset = false;
  std::array<std::uint64_t, touch_count> samples{};  ///< by the value of Touch
  std::string remark;  ///< why it is left out or gives no samples, what of it is left out; empty if nothing
};

struct DatasetSummary {
  enum class Outcome { written, replaced, moved, unchanged };  ///< moved: the same, but its runs lie elsewhere now
  Outcome outcome = Outcome::written;
  bool was_damaged = false;           ///< the dataset that was replaced could not be read
  std::vector<WindowedRun> runs;      ///< every run found, by object, then run
  std::vector<std::string> warnings;  ///< what a person should know, a sentence each
  std::vector<std::string> errors;    ///< what kept runs from being read, a sentence each; they are left out
  std::string manifest_hash;
  bool simulated = false;
  std::uint64_t samples = 0;
  std::uint64_t events = 0;
};

/// Draws balanced samples from the labelled runs below `data` and writes them, with the events of their histories, to `file` and
/// to the file of its events beside it.
///
/// A dataset that is there with the same manifest is kept with its histories; where its runs have moved it is told so. One with
/// another manifest is replaced whole: at every moment `file` is either the old dataset or the new one, with the events that
/// belong to it; the old one's histories are removed last.
///
/// Runs without labels, with files that cannot be read or are not what they should be, flagged runs, and simulated ones where
/// real ones are too, are left out and named; a run that lacks a class is in the dataset but gives no samples, and is named with
/// its reason. Without run.json a run is what its folder and its recording say.
///
/// @param threads  0: as many as the machine has cores; the bytes do not depend on it
/// @throws Error  if no run has labels or samples, no run of an object has samples and `strict` is set, recordings differ in
///                sensor size, or `file` is there and no dataset
DatasetSummary write_dataset(const std::filesystem::path& data, const std::filesystem::path& file,
                             const WindowsOptions& options = {}, unsigned threads = 0, const ProgressCallback& progress = {});

}  // namespace tactile
