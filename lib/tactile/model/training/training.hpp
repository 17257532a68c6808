#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/model/bundle/training_history.hpp"
#include "tactile/model/definition/training_options.hpp"
#include "tactile/model/training/lenet.hpp"

namespace tactile::model {

/// Heatmaps and their classes.
struct LabelledHeatmaps {
  std::span<const std::uint8_t> heatmaps;  ///< [truth.size(), height, width]
  std::span<const Touch> truth;
};

/// The weights of the best epoch.
struct BestEpoch {
  unsigned epoch = 0;
  double loss = 0;  ///< of the validation, or of the training without a validation part
  Weights weights;
};

/// The complete state of a training between two batches.
struct TrainingState {
  unsigned epoch = 1;           ///< current one; options.epochs + 1 at the end
  std::uint64_t done = 0;       ///< finished samples of it
  double loss = 0, weight = 0;  ///< sums over them
  std::uint64_t correct = 0;
  double gradient_norm = 0;
  double epoch_seconds = 0;
  std::vector<EpochResult> history;  ///< of the finished epochs
  double seconds = 0;                ///< total computing time so far
  Weights weights;
  OptimizerState optimizer;
  std::optional<BestEpoch> best;
};

struct TrainedNetwork {
  LeNet network;  ///< of the last epoch; of the best epoch with early stop
  Weights other;  ///< of the other of these two epochs; empty if they are the same
  TrainingSummary summary;
};

/// The data and settings of a training.
struct TrainingTask {
  events::SensorSize size;  ///< of a heatmap
  LabelledHeatmaps training;
  /// The training heatmaps of an epoch, from 1, valid until the next call; `training` in every epoch if empty.
  std::function<std::span<const std::uint8_t>(unsigned epoch)> heatmaps_of_epoch{};
  LabelledHeatmaps validation{};  ///< may be empty without early stop
  TrainingOptions options{};
  LeNetOptions network{};
  const Weights* from = nullptr;  ///< initial weights; drawn by the seed if null
  unsigned threads = 0;           ///< 0: one per core
  bool float64 = false;           ///< as TrainerOptions; cannot be resumed, because a state is rounded
};

/// Progress, saving and resuming of a training.
struct TrainingControl {
  ProgressCallback progress{};  ///< after each batch: finished samples of epochs * samples; may throw to stop
  std::function<void(const TrainingState&)> save{};  ///< at each epoch's end, every `save_every`, and when `progress` throws
  std::chrono::duration<double> save_every{30};      ///< >= 0
  const TrainingState* resumed = nullptr;            ///< a state saved by the same task
};

/// Trains a network. The same task gives bit-identical weights and history, except times, even if it was interrupted and resumed.
///
/// @throws Error  if there is no sample or not one heatmap per sample, a class has no sample, an option is out of its range, the
///                resumed state belongs to another task, the loss, the gradient or a weight is not finite, or the gradient's norm
///                exceeds `largest_gradient_norm`
TrainedNetwork train_lenet(const TrainingTask& task, const TrainingControl& control = {});

/// The weight of the samples of each class. @throws Error  if a class to be balanced has no sample
std::array<double, touch_count> weights_of_classes(const ClassWeights& weights, std::span<const Touch> truth);

}  // namespace tactile::model
