#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/experiments/step_runner.hpp"

namespace tactile::experiments {

constexpr std::size_t largest_step_file = std::size_t{1} << 30;  ///< [B] of a JSON file that a step keeps

/// SHA-256 of a file; null if it is missing.
nlohmann::json hash_of_file(const std::filesystem::path& file);

/// SHA-256 of the truth.json of each run, in order; null where there is none. Detection delays depend on them.
nlohmann::json truth_hashes(const std::vector<RunFolder>& runs);

/// {"fan/03": SHA-256 of its recording, labels.json and truth.json} of each run; null where a file is missing.
nlohmann::json hashes_of_runs(const std::vector<RunFolder>& runs);

/// A step without a command, whose only output is `file`.
/// @param work         writes `file`
/// @param description  as of `Step`
Step file_step(std::string name, nlohmann::json inputs, const std::filesystem::path& file,
               std::function<void(const ProgressCallback&)> work, std::string description = {});

}  // namespace tactile::experiments
