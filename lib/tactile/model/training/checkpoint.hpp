#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "tactile/model/training/training.hpp"

namespace tactile::model {

/// The saved state of a training, next to its bundle until that is complete: the folder `models/<name>.training/`.
///
///   last.safetensors       weights, the optimizer's moments ("optimizer.…"), and the state in the metadata
///   best-0003.safetensors  the weights of the best epoch so far
///
/// Each file is replaced in one step, and the best before the last, which refers to it. So a killed training can be resumed.
class CheckpointFolder {
 public:
  /// Locks the folder for this process. @throws Error  if another process has locked it, or it cannot be made
  explicit CheckpointFolder(std::filesystem::path folder);
  ~CheckpointFolder();
  CheckpointFolder(const CheckpointFolder&) = delete;
  CheckpointFolder& operator=(const CheckpointFolder&) = delete;

  static std::filesystem::path beside(const std::filesystem::path& bundle);  ///< "models/mine" -> "models/mine.training"
  static bool holds_state(const std::filesystem::path& folder);
  static std::filesystem::path best_weights(const std::filesystem::path& folder, unsigned epoch);

  /// @param task  identifies the training; a state is only loaded by the same training
  void save(const nlohmann::json& task, const TrainingState& state);

  /// The last saved state; nothing if there is none.
  /// @throws Error  if it belongs to another task, or is damaged
  std::optional<TrainingState> load(const nlohmann::json& task, const LeNetLayers& layers, OptimizerKind optimizer) const;

  void clear();   ///< removes the saved state, the file that refers to others first
  void remove();  ///< removes the folder

 private:
  std::filesystem::path folder_;
  int lock_ = -1;
};

/// The task of a saved state; nothing if there is none. @throws Error  if it is damaged
std::optional<nlohmann::json> task_of_checkpoint(const std::filesystem::path& folder);

}  // namespace tactile::model
