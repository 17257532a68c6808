#include "tactile/experiments/file_step.hpp"

#include "tactile/core/sha256.hpp"

namespace tactile::experiments {

nlohmann::json hash_of_file(const std::filesystem::path& file) {
  return std::filesystem::is_regular_file(file) ? nlohmann::json(sha256_of_file(file)) : nlohmann::json();
}

nlohmann::json truth_hashes(const std::vector<RunFolder>& runs) {
  nlohmann::json hashes = nlohmann::json::array();
  for (const RunFolder& run : runs) hashes.push_back(hash_of_file(run.truth()));
  return hashes;
}

nlohmann::json hashes_of_runs(const std::vector<RunFolder>& runs) {
  nlohmann::json hashes = nlohmann::json::object();
  for (const RunFolder& run : runs)
    hashes[run.name()] = {hash_of_file(run.events()), hash_of_file(run.labels()), hash_of_file(run.truth())};
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
