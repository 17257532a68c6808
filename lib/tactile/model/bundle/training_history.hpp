#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tactile::model {

/// The result of one epoch: each batch is evaluated with the weights before its step, the validation part with those at the end
/// of the epoch.
struct EpochResult {
  unsigned epoch = 0;   ///< from 1
  double loss = 0;      ///< mean cross-entropy over the samples, each weighted by its class
  double accuracy = 0;  ///< share of correct predictions, in [0, 1]
  std::optional<double> validation_loss, validation_accuracy;
  double learning_rate = 0;  ///< of the last step
  double gradient_norm = 0;  ///< the largest of all steps
  double images_per_s = 0;
  double seconds = 0;
};

/// The course of a training.
struct TrainingSummary {
  std::vector<EpochResult> history;
  std::size_t samples = 0, validation_samples = 0;
  double seconds = 0;
  unsigned best_epoch = 0;  ///< with the smallest validation loss; training loss without a validation part
  bool stopped_early = false;
};

void to_json(nlohmann::json& json, const EpochResult& epoch);
void from_json(const nlohmann::json& json, EpochResult& epoch);  ///< @throws Error

/// Columns epoch, loss, accuracy, ..., one row per epoch; values that were not measured are empty.
std::string history_csv(const std::vector<EpochResult>& history);

/// Reads the output of `history_csv` from a file. @throws Error  if it cannot be read or a row has other columns
std::vector<EpochResult> read_history(const std::filesystem::path& file);

}  // namespace tactile::model
