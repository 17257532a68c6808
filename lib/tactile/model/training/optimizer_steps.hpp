#pragma once

#include <cstdint>
#include <span>

#include "tactile/model/definition/training_options.hpp"

namespace tactile::model {

/// A step of an optimizer, equal to libtorch's except for rounding:
///
///   sgd:    m = 0.9 m + g,   w = w - rate * m
///   adam:   m = 0.9 m + 0.1 g,   v = 0.999 v + 0.001 g^2,
///           w = w - rate / (1 - 0.9^step) * m / (sqrt(v / (1 - 0.999^step)) + 1e-8)
///   adamw:  w = (1 - 0.01 rate) w, then as adam
struct OptimizerStep {
  OptimizerKind kind = OptimizerKind::adam;
  double learning_rate = 1e-3;
  std::int64_t step = 1;  ///< this one, > 0
};

/// Some weights, their gradients and moments; all of the same size.
struct WeightSlice {
  std::span<float> weights;
  std::span<const float> gradients;
  std::span<float> first_moment;   ///< m
  std::span<float> second_moment;  ///< v; empty for sgd
};

/// Takes the step in one pass, each weight by itself. So slices give the same result as the whole.
void take_step(const OptimizerStep& step, const WeightSlice& slice);

/// Summed in float32 over up to 4096 values and in float64 over these. It does not depend on the threads.
double sum_of_squares(std::span<const float> values, unsigned threads = 1);

}  // namespace tactile::model
