#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/core/run_folder.hpp"

namespace tactile {

/// What lies below a folder of runs. Hidden folders and discarded runs, `<run>.discarded-<k>`, are no part of it.
struct RunsBelow {
  std::vector<RunFolder> runs;  ///< that hold an `events.aedat4`, by object, then run

  /// A sentence for each folder that holds a recording and is left out for its name or place, with the one that it needs.
  std::vector<std::string> misnamed;

  /// A sentence for each object or run that cannot be read; the others are in `runs`.
  std::vector<std::string> unreadable;

  /// Folders that have the place and the name of a run, but no recording, under any name.
  std::vector<std::filesystem::path> without_recording;
};

/// @throws Error if `data` is no folder
RunsBelow look_for_runs(const std::filesystem::path& data);

/// One sentence that names them all; empty if there are none.
std::string sentence_on_missing_recordings(const std::vector<std::filesystem::path>& without_recording);

/// The name that a folder of an object's runs needs instead of `name`: lower-case, with hyphens for what is neither letter nor
/// digit. Empty if `name` holds neither.
std::string needed_object_name(std::string_view name);

/// Why `name` is not one of an object, with one that is; empty if it is.
std::string why_not_an_object_name(std::string_view name);

/// Why the run in `folder` is left out wherever runs are looked for: a sentence with the name that it, or the folder above it,
/// needs. Empty if both are named well, and for a discarded run.
/// @throws Error  if there is no such folder
std::string what_is_misnamed(const std::filesystem::path& folder);

/// As `run_folder_at`. @throws Error too where `what_is_misnamed` has a sentence
RunFolder named_run_at(const std::filesystem::path& folder);

/// Whether something has this name. Also true if that cannot be found out: an attempt to open it then gives the reason.
bool is_there(const std::filesystem::path& path);

/// Whether it is a file, by itself or by a link.
bool is_file(const std::filesystem::path& path);

}  // namespace tactile
