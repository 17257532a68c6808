#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tactile {

/// One pass over the samples, as it went: each batch is judged by the weights that it was about to move, the validation part by
/// those at the epoch's end.
struct EpochResult {
  unsigned epoch = 0;   ///< from 1
  double loss = 0;      ///< mean cross-entropy over the samples, each weighted by its class
  double accuracy = 0;  ///< share said right, in [0, 1]
  std::optional<double> validation_loss, validation_accuracy;
  double learning_rate = 0;  ///< of the last step
  double gradient_norm = 0;  ///< the largest of all steps
  double images_per_s = 0;
  double seconds = 0;
};

/// How a training went.
struct TrainingSummary {
  std::vector<EpochResult> history;
  std::size_t samples = 0, validation_samples = 0;
  double seconds = 0;
  unsigned best_epoch = 0;  ///< the one with the smallest loss, validation's where there is such a part
  bool stopped_early = false;
};

void to_json(nlohmann::json& json, const EpochResult& epoch);
void from_json(const nlohmann::json& json, EpochResult& epoch);  ///< @throws Error

/// Columns epoch, loss, accuracy, ..., a row an epoch; what was not measured is empty.
std::string history_csv(const std::vector<EpochResult>& history);

/// What `history_csv` wrote to a file. @throws Error  if it cannot be read or a row is not of these columns
std::vector<EpochResult> read_history(const std::filesystem::path& file);

}  // namespace tactile
