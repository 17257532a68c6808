#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "tactile/characterise/scene.hpp"
#include "tactile/model/bundle/model_bundle.hpp"

namespace tactile::evaluation {

/// A run that is judged.
struct WatchedRun {
  std::string name;  ///< "fan/02"
  std::filesystem::path recording;
};

/// A sentence on the runs whose scene leaves that of the model's training runs (`characterise::departures`); empty if none does,
/// or if the bundle does not know its training runs' scenes. Names three runs at most. @param threads  > 0
/// @throws Error  if a recording cannot be read
std::string scene_remark(const model::ModelDescription& model, std::span<const WatchedRun> runs, unsigned threads);

}  // namespace tactile::evaluation
