#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/model/lenet.hpp"

namespace tactile {

struct TrainingOptions {
  std::uint64_t seed = 1;       ///< of the first weights and of the order of samples
  unsigned epochs = 10;         ///< passes over all samples, > 0
  unsigned batch = 32;          ///< samples to a step, > 0; the last of an epoch may be smaller
  double learning_rate = 1e-3;  ///< Adam's, > 0

  friend bool operator==(const TrainingOptions&, const TrainingOptions&) = default;
};

void to_json(nlohmann::json& json, const TrainingOptions& options);
void from_json(const nlohmann::json& json, TrainingOptions& options);  ///< @throws Error

/// @throws Error  if an option is out of its range
void check(const TrainingOptions& options);

/// One pass over the samples, as it went: each batch is judged by the weights that it was about to move.
struct EpochResult {
  unsigned epoch = 0;   ///< from 1
  double loss = 0;      ///< mean cross-entropy over the samples
  double accuracy = 0;  ///< share said right, in [0, 1]
  double images_per_s = 0;
  double seconds = 0;
};

struct TrainingSummary {
  std::vector<EpochResult> history;
  std::size_t samples = 0;
  double seconds = 0;
};

struct TrainedNetwork {
  LeNet network;
  TrainingSummary summary;
};

/// Trains a network from its first weights. The same options and threads give the same weights to the last bit.
///
/// @param heatmaps  [truth.size(), height, width], one after the other
/// @param threads   0: as many as the machine has cores
/// @param progress  told after each batch: samples done of epochs * samples
/// @throws Error  if there is no sample or not one heatmap for each, a touch has no sample, an option is out of its range, or the
/// loss or a
///                weight is no longer finite
TrainedNetwork train_lenet(SensorSize size, std::span<const std::uint8_t> heatmaps, std::span<const Touch> truth,
                           const TrainingOptions& options, unsigned threads = 0, const ProgressCallback& progress = {});

}  // namespace tactile
