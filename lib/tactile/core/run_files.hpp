#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/core/run_folder.hpp"

namespace tactile {

/// The member `files` of run.json: {name: {"sha256": 64 hexadecimal digits, "bytes": size}} of each of `files`, by name.
/// @throws Error if one cannot be read
nlohmann::json files_json(std::span<const std::filesystem::path> files);

enum class FileComparison : std::uint8_t { size, contents };  ///< contents: size and SHA-256

/// How a run's files differ from what its run.json says of them, by name.
struct RunFiles {
  bool is_listed = false;  ///< run.json has a member `files`
  std::vector<std::string> as_listed;
  std::vector<std::string> missing;
  std::vector<std::string> changed;     ///< of another size or SHA-256, or not comparable
  std::vector<std::string> not_listed;  ///< files of a run that are there, but not in run.json
  std::vector<std::string> reasons;     ///< a sentence for each that is missing or changed
};

/// Compares what `info` lists under `files` with what is there. `labels.json` and `run.json` change after a run is recorded and
/// are never compared.
/// @param progress  called with the bytes read; may throw to end the comparison
RunFiles check_files(const RunFolder& run, const RunInfo& info, FileComparison comparison, const ProgressCallback& progress = {});

}  // namespace tactile
