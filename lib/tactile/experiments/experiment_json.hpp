#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace tactile::experiments {

/// {"name", "version", "revision", "libtorch"} of this program.
nlohmann::json software_json();

/// {"cpu", "system", "cores", "memory_bytes", "threads"}: this machine, and how many threads were used.
nlohmann::json machine_json(unsigned threads);

/// `path` relative to the folder of an experiment. Neither has to exist.
std::string from_folder(const std::filesystem::path& path, const std::filesystem::path& folder);

}  // namespace tactile::experiments
