#include "tactile/results/study.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/results/experiment_file.hpp"

namespace tactile::results {

const StudiedSetting* Study::find(const std::string& setting) const {
  const auto place =
      std::find_if(results.begin(), results.end(), [&](const StudiedSetting& one) { return one.setting == setting; });
  return place == results.end() ? nullptr : &*place;
}

Study read_study(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "study.json";
  auto study = read_experiment<Study>(file);
  for (const StudiedModel& model : study.models) {
    if (model.world >= study.worlds.size())
      throw Error(fmt::format("{}: the model {} is of world {}; expected one of its {} worlds", file.string(), model.name,
                              model.world, study.worlds.size()));
  }
  return study;
}

}  // namespace tactile::results
