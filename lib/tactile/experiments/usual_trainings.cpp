#include "tactile/experiments/usual_trainings.hpp"

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tactile/core/json.hpp"
#include "tactile/core/run_folder.hpp"

namespace tactile::experiments {
namespace {

constexpr unsigned of_tiny_data = 2, of_other_data = 5;

/// Whether all runs were simulated with the preset of the smallest ones.
bool is_tiny(const windows::Dataset& dataset) {
  for (std::uint32_t run = 0; run < dataset.runs().size(); ++run) {
    const std::filesystem::path file = RunFolder{dataset.run_folder(run), "", ""}.info();
    if (!dataset.simulated() || !std::filesystem::exists(file)) return false;
    const nlohmann::json json = read_json(file);
    if (json.value(nlohmann::json::json_pointer("/simulation/preset"), "") != "tiny") return false;
  }
  return true;
}

}  // namespace

unsigned usual_trainings(const windows::Dataset& dataset) { return is_tiny(dataset) ? of_tiny_data : of_other_data; }

}  // namespace tactile::experiments
