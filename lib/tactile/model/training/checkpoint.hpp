#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "tactile/model/training/training.hpp"

namespace tactile {

/// What a training has come to, kept beside the place of its bundle until that is whole: the folder `models/<name>.training/`.
///
///   last.safetensors       weights, the optimizer's moments ("optimizer.…"), and the state in the metadata
///   best-0003.safetensors  the weights of the best epoch so far
///
/// Each is written whole or not at all, the best before the last that tells of it, so a kill leaves a state to go on from.
class CheckpointFolder {
 public:
  /// Takes the folder for this process, until it goes. @throws Error  if another process has it, or it cannot be made
  explicit CheckpointFolder(std::filesystem::path folder);
  ~CheckpointFolder();
  CheckpointFolder(const CheckpointFolder&) = delete;
  CheckpointFolder& operator=(const CheckpointFolder&) = delete;

  static std::filesystem::path beside(const std::filesystem::path& bundle);  ///< "models/mine" -> "models/mine.training"
  static bool holds_state(const std::filesystem::path& folder);

  /// @param task  what tells this training from others; a state is only given back to the same
  void save(const nlohmann::json& task, const TrainingState& state);

  /// What was saved last; nothing if nothing was.
  /// @throws Error  if it is of another task, or damaged
  std::optional<TrainingState> load(const nlohmann::json& task, const LeNetLayers& layers, OptimizerKind optimizer) const;

  void clear();   ///< forgets what was saved
  void remove();  ///< with all that lies in it

 private:
  std::filesystem::path folder_;
  int lock_ = -1;
};

/// The task of the state that a folder holds, as `save` was given it; nothing if it holds none. @throws Error  if it is damaged
std::optional<nlohmann::json> task_of_checkpoint(const std::filesystem::path& folder);

}  // namespace tactile
