#include "tactile/experiments/file_step.hpp"

#include "tactile/core/sha256.hpp"

namespace tactile::experiments {

nlohmann::json hash_of_file(const std::filesystem::path& file) {
  return std::filesystem::is_regular_file(file) ? nlohmann::json(sha256_of_file(file)) : nlohmann::json();
}

nlohmann::json truth_hashes(const windows::Dataset& dataset, std::span<const std::uint32_t> runs) {
  nlohmann::json hashes = nlohmann::json::array();
  for (const std::uint32_t run : runs) hashes.push_back(hash_of_file(dataset.run_folder(run) / "truth.json"));
  return hashes;
}

Step file_step(std::string name, nlohmann::json inputs, const std::filesystem::path& file,
               std::function<void(const ProgressCallback&)> work, std::string description) {
  return {.name = std::move(name),
          .command = "",
          .inputs = std::move(inputs),
          .outputs = [file] { return hash_of_file(file); },
          .work = std::move(work),
          .description = std::move(description)};
}

}  // namespace tactile::experiments
