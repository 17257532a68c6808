#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "tactile/experiments/step_runner.hpp"

namespace tactile::experiments {

/// {"name", "version", "revision", "libtorch"} of this program.
nlohmann::json software_json();

/// {"cpu", "system", "cores", "memory_bytes", "threads"}: this machine, and how many threads were used.
nlohmann::json machine_json(unsigned threads);

/// {"name", "command", "seconds", "finished_at"} of each; "command" is null where there is none.
nlohmann::json steps_json(std::span<const StepRecord> steps);

/// `path` relative to the folder of an experiment. Neither has to exist.
std::string from_folder(const std::filesystem::path& path, const std::filesystem::path& folder);

}  // namespace tactile::experiments
