#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/core/fields.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/model/definition/engine_kind.hpp"
#include "tactile/recipes/recipe.hpp"

namespace tactile::model {

/// The optimizer: Adam (betas 0.9 and 0.999, epsilon 1e-8), AdamW (the same with a weight decay of 0.01), or stochastic
/// gradient descent with a momentum of 0.9.
enum class OptimizerKind : std::uint8_t { adam, adamw, sgd };
inline constexpr std::array<std::string_view, 3> optimizer_names{"adam", "adamw", "sgd"};
constexpr std::string_view name_of(OptimizerKind optimizer) { return optimizer_names.at(static_cast<std::size_t>(optimizer)); }

/// The learning rate over the steps of a training: constant; along a half cosine down to 0; or a tenth from half of the epochs on
/// and a hundredth from three quarters on.
enum class Schedule : std::uint8_t { constant, cosine, step };
inline constexpr std::array<std::string_view, 3> schedule_names{"constant", "cosine", "step"};

/// Random changes of each heatmap, each time it is used for training, and of the runs' events in each epoch.
struct Augmentation {
  bool flip = false;   ///< mirrored horizontally and vertically, each with probability 1/2
  bool shift = false;  ///< moved by up to 4 cells in each direction; new cells are empty
  /// In each epoch, half of the runs stay as they are. Each other one gets a recipe of these, at a severity up to its own, before
  /// its heatmaps are rendered. Their seeds have no effect.
  std::vector<recipes::Recipe> stress{};

  friend bool operator==(const Augmentation&, const Augmentation&) = default;
};

/// The weight of the samples of each class in the loss.
struct ClassWeights {
  bool balanced = false;  ///< equal weight for all classes: samples / (classes * samples of the class)
  std::array<double, touch_count> given{1.0, 1.0, 1.0};  ///< otherwise these, > 0

  friend bool operator==(const ClassWeights&, const ClassWeights&) = default;
};

struct TrainingOptions {
  std::uint64_t seed = 1;       ///< of the initial weights, the order of samples and the augmentation
  unsigned epochs = 10;         ///< passes over all samples, > 0
  unsigned batch = 32;          ///< samples per step, > 0; the last batch of an epoch may be smaller
  double learning_rate = 1e-3;  ///< > 0
  OptimizerKind optimizer = OptimizerKind::adam;
  Schedule schedule = Schedule::constant;
  Augmentation augmentation{};
  ClassWeights class_weights{};

  /// The engine that computes a step; the results agree except for rounding. fast: convolution, ReLU and max-pool in one pass,
  /// the optimizer's step in one, other layers by libtorch. libtorch: its layers and optimizers one by one.
  EngineKind engine = EngineKind::fast;
  double validation_share = 0;  ///< share of the training runs' samples, the last of each class in time; in [0, 0.5]
  unsigned early_stop = 0;      ///< epochs without a smaller validation loss that end it; 0: never; needs validation_share > 0

  friend bool operator==(const TrainingOptions&, const TrainingOptions&) = default;
};

Augmentation augmentation_named(std::string_view names);  ///< "none", or "flip,shift,stress:noise:100". @throws Error
ClassWeights class_weights_named(std::string_view text);  ///< "none", "balanced", or three weights: "1,2,1". @throws Error
std::string text_of(const Augmentation& augmentation);    ///< as `augmentation_named` reads it
std::string text_of(const ClassWeights& weights);         ///< as `class_weights_named` reads it

template <class Fields>
void list_fields(Fields& fields, TrainingOptions& o) {
  fields("seed", o.seed, {"seed", "Seed of the initial weights and of the sample order"});
  fields("epochs", o.epochs, 1, 100'000, {"epochs", "Training epochs"});
  fields("batch", o.batch, 1, 65'536, {"batch", "Batch size"});
  fields("learning_rate", o.learning_rate, 1e-12, 10, {"lr", "Learning rate"});
  fields("schedule", o.schedule, schedule_names,
         {"schedule", "Learning rate schedule: constant, cosine (down to 0) or step (to a tenth, then a hundredth)"});
  fields("optimizer", o.optimizer, optimizer_names,
         {"optimizer", "Optimizer: adam, adamw (with weight decay) or sgd (with momentum)"});
  fields("engine", o.engine, training_engines,
         {"engine", "Training engine: fast (tactile's own) or libtorch; their results differ only by rounding"});
  fields("augment", o.augmentation, augmentation_named,
         {"augment", "Random augmentation: none, or flip, shift and stress:RECIPE[:SEVERITY] of 'convert', separated by commas",
          "NAME,..."});
  fields("class_weights", o.class_weights, class_weights_named,
         {"class-weights",
          "Weights of the classes: none (equal samples), balanced (equal classes), or three numbers such as 1,2,1"});
  fields("validation_share", o.validation_share, 0, 0.5);
  fields("early_stop", o.early_stop, 0, 100'000,
         {"early-stop", "Stop after this many epochs without a lower validation loss, and keep the best weights; 0: never"});
}

/// What a training needs at least; the ranges of the fields are those of options and files, which are narrower.
/// @throws Error  if there is nothing to train with: no epoch, an early stop without validation, ...
void check(const TrainingOptions& options);

/// The learning rate of a step according to the schedule.
/// @param step  from 0, below `steps`, the number in all epochs
double learning_rate_at(const TrainingOptions& options, std::uint64_t step, std::uint64_t steps);

}  // namespace tactile::model
