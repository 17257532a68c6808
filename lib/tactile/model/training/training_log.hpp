#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "tactile/model/bundle/training_history.hpp"
#include "tactile/model/training/event_file.hpp"

namespace tactile::model {

/// What a person can follow while a training runs: `history.csv` with a row for each finished epoch, and TensorBoard's scalars.
class TrainingLog {
 public:
  /// @param csv          replaced as a whole after each epoch, so that every row that is there is complete
  /// @param tensorboard  folder for an `EventFile`; empty: none
  TrainingLog(std::filesystem::path csv, std::filesystem::path tensorboard);

  /// Begins with the epochs that an interrupted training finished; none of a new training. Scalars of later epochs, or of an
  /// older training, that the folder has no longer count. Call it before the first `see`.
  void begin(const std::vector<EpochResult>& finished);

  /// Adds the epochs that are not there yet. @throws Error  if a file cannot be written
  void see(const std::vector<EpochResult>& finished);

 private:
  std::filesystem::path csv_, folder_;
  std::optional<EventFile> events_;
  std::size_t seen_ = 0;
};

}  // namespace tactile::model
