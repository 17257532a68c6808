#include "tactile/experiments/experiment_json.hpp"

#include <thread>

#include "tactile/core/machine.hpp"
#include "tactile/core/version.hpp"
#include "tactile/model/training/torch_version.hpp"

namespace tactile::experiments {

nlohmann::json software_json() {
  return {{"name", "tactile"}, {"version", version()}, {"revision", revision()}, {"libtorch", model::torch_version()}};
}

nlohmann::json machine_json(unsigned threads) {
  return {{"cpu", cpu_name()},
          {"system", system_name()},
          {"cores", std::thread::hardware_concurrency()},
          {"memory_bytes", memory_bytes()},
          {"threads", threads}};
}

std::string from_folder(const std::filesystem::path& path, const std::filesystem::path& folder) {
  // weakly_canonical leaves a relative path as it is until its first part exists, so both become absolute first.
  const auto whole = [](const std::filesystem::path& any) {
    return std::filesystem::weakly_canonical(std::filesystem::absolute(any));
  };
  return whole(path).lexically_relative(whole(folder)).generic_string();
}

}  // namespace tactile::experiments
