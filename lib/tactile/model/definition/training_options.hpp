#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "tactile/core/touch.hpp"
#include "tactile/model/definition/engine_kind.hpp"

namespace tactile {

/// What moves the weights: Adam (betas 0.9 and 0.999, epsilon 1e-8), AdamW (the same with a weight decay of 0.01), or stochastic
/// gradient descent with a momentum of 0.9.
enum class OptimizerKind : std::uint8_t { adam, adamw, sgd };

/// How the learning rate goes over a training's steps: as it is; down a half cosine to 0; or a tenth of it from half of the
/// epochs on and a hundredth from three quarters on.
enum class Schedule : std::uint8_t { constant, cosine, step };

/// What is done at random to each heatmap each time it is learned from.
struct Augmentation {
  bool flip = false;   ///< mirrored left to right, and top to bottom, half of the times each
  bool shift = false;  ///< moved by up to 4 cells each way; what comes in is empty

  friend bool operator==(const Augmentation&, const Augmentation&) = default;
};

/// How much a sample of a class counts in the loss.
struct ClassWeights {
  bool balanced = false;                                 ///< each class alike: samples / (classes * samples of the class)
  std::array<double, touch_count> given{1.0, 1.0, 1.0};  ///< else these, > 0

  friend bool operator==(const ClassWeights&, const ClassWeights&) = default;
};

struct TrainingOptions {
  std::uint64_t seed = 1;       ///< of the first weights, of the order of samples and of what is done to them
  unsigned epochs = 10;         ///< passes over all samples, > 0
  unsigned batch = 32;          ///< samples to a step, > 0; the last of an epoch may be smaller
  double learning_rate = 1e-3;  ///< > 0
  OptimizerKind optimizer = OptimizerKind::adam;
  Schedule schedule = Schedule::constant;
  Augmentation augmentation{};
  ClassWeights class_weights{};

  /// What works out a step, with results that agree but for rounding. fast: convolution, ReLU and max-pool in one pass and the
  /// optimizer's step in one, other layers being libtorch's; libtorch: its layers and optimizers one by one.
  EngineKind engine = EngineKind::fast;
  double validation_share = 0;  ///< of the training runs' samples, the last of each class in time; in [0, 0.5]
  unsigned early_stop = 0;      ///< epochs without a smaller validation loss that end it; 0: never, else validation_share > 0

  friend bool operator==(const TrainingOptions&, const TrainingOptions&) = default;
};

std::string_view name_of(OptimizerKind optimizer);        ///< "adam", "adamw", "sgd"
std::string_view name_of(Schedule schedule);              ///< "constant", "cosine", "step"
OptimizerKind optimizer_named(std::string_view name);     ///< @throws Error
Schedule schedule_named(std::string_view name);           ///< @throws Error
Augmentation augmentation_named(std::string_view names);  ///< "none", "flip", "shift" or "flip,shift". @throws Error
ClassWeights class_weights_named(std::string_view text);  ///< "none", "balanced", or a weight each: "1,2,1". @throws Error
std::string text_of(const Augmentation& augmentation);    ///< as `augmentation_named` reads it
std::string text_of(const ClassWeights& weights);         ///< as `class_weights_named` reads it

void to_json(nlohmann::json& json, const TrainingOptions& options);
/// Settings without an engine are older than the fast one: libtorch's. @throws Error
void from_json(const nlohmann::json& json, TrainingOptions& options);

/// @throws Error  if an option is out of its range
void check(const TrainingOptions& options);

/// The learning rate of a step, by its schedule.
/// @param step  from 0, of the `steps` that all epochs have together
double learning_rate_at(const TrainingOptions& options, std::uint64_t step, std::uint64_t steps);

}  // namespace tactile
