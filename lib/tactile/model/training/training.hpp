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

namespace tactile {

/// Heatmaps and what each shows.
struct LabelledHeatmaps {
  std::span<const std::uint8_t> heatmaps;  ///< [truth.size(), height, width], one after the other
  std::span<const Touch> truth;
};

/// An epoch's weights that no other's beat.
struct BestEpoch {
  unsigned epoch = 0;
  double loss = 0;  ///< validation's, or training's where nothing is kept to judge by
  Weights weights;
};

/// All that the rest of a training depends on, between two batches.
struct TrainingState {
  unsigned epoch = 1;           ///< that is under way; options.epochs + 1 at the end
  std::uint64_t done = 0;       ///< samples of it
  double loss = 0, weight = 0;  ///< sums over them
  std::uint64_t correct = 0;
  double gradient_norm = 0;
  double epoch_seconds = 0;
  std::vector<EpochResult> history;  ///< of the epochs before
  double seconds = 0;                ///< all that was worked so far
  Weights weights;
  OptimizerState optimizer;
  std::optional<BestEpoch> best;
};

struct TrainedNetwork {
  LeNet network;  ///< the last epoch's, or the best's where an early stop was asked for
  Weights other;  ///< of the other one of these two; empty where they are the same epoch's
  TrainingSummary summary;
};

/// What is to be learned, and how.
struct TrainingTask {
  SensorSize size;  ///< of a heatmap
  LabelledHeatmaps training;
  LabelledHeatmaps validation{};  ///< to judge by; may be empty without an early stop
  TrainingOptions options{};
  LeNetOptions network{};
  const Weights* from = nullptr;  ///< first weights; drawn by the seed if null
  unsigned threads = 0;           ///< 0: as many as the machine has cores
  bool float64 = false;           ///< as TrainerOptions; not to be broken off then, a state is rounded
};

/// How a training is watched, kept and gone on with.
struct TrainingControl {
  ProgressCallback progress{};                       ///< after each batch: samples done of epochs * samples; may throw to end it
  std::function<void(const TrainingState&)> save{};  ///< at each epoch's end, every `save_every`, and when `progress` throws
  std::chrono::duration<double> save_every{30};      ///< >= 0
  const TrainingState* resumed = nullptr;            ///< a state that `save` was given by the same task
};

/// Trains a network. The same task gives the same weights and history to the last bit, however often it was broken off and gone
/// on with; times apart.
///
/// @throws Error  if there is no sample or not one heatmap for each, a touch has no sample, an option is out of its range, the
///                state resumed is of another task, or the loss, the slope or a weight is no longer finite, or the slope's norm
///                is above `largest_gradient_norm`
TrainedNetwork train_lenet(const TrainingTask& task, const TrainingControl& control = {});

/// How much a sample of each class counts. @throws Error  if a class to be balanced has no sample
std::array<double, touch_count> weights_of_classes(const ClassWeights& weights, std::span<const Touch> truth);

}  // namespace tactile
