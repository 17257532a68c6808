#include "tactile/model/training/optimizer_steps.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "tactile/core/parallel.hpp"

// Highway compiles what follows once for each kind of processor and takes the best of them at run time.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tactile/model/training/optimizer_steps.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tactile::model::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Full = hn::ScalableTag<float>;
using One = hn::CappedTag<float, 1>;

struct AdamFactors {
  explicit AdamFactors(const OptimizerStep& step) {
    constexpr double beta_1 = 0.9, beta_2 = 0.999, decay = 0.01;
    const auto steps = static_cast<double>(step.step);
    keep_weight = static_cast<float>(step.kind == OptimizerKind::adamw ? 1 - step.learning_rate * decay : 1.0);
    keep_first = static_cast<float>(beta_1);
    add_first = static_cast<float>(1 - beta_1);
    keep_second = static_cast<float>(beta_2);
    add_second = static_cast<float>(1 - beta_2);
    to_root = static_cast<float>(1 / std::sqrt(1 - std::pow(beta_2, steps)));
    move = static_cast<float>(step.learning_rate / (1 - std::pow(beta_1, steps)));
  }

  float keep_weight, keep_first, add_first, keep_second, add_second, to_root, move, epsilon = 1e-8F;
};

/// @return values done, from `begin`, in whole vectors of D
template <class D>
HWY_INLINE std::size_t take_adam(D d, const AdamFactors& by, const WeightSlice& slice, std::size_t begin) {
  const std::size_t lanes = hn::Lanes(d), count = slice.weights.size();
  std::size_t i = begin;
  for (; i + lanes <= count; i += lanes) {
    const auto gradient = hn::LoadU(d, slice.gradients.data() + i);
    const auto first = hn::MulAdd(gradient, hn::Set(d, by.add_first),
                                  hn::Mul(hn::LoadU(d, slice.first_moment.data() + i), hn::Set(d, by.keep_first)));
    const auto second = hn::MulAdd(hn::Mul(gradient, gradient), hn::Set(d, by.add_second),
                                   hn::Mul(hn::LoadU(d, slice.second_moment.data() + i), hn::Set(d, by.keep_second)));
    hn::StoreU(first, d, slice.first_moment.data() + i);
    hn::StoreU(second, d, slice.second_moment.data() + i);
    const auto below = hn::MulAdd(hn::Sqrt(second), hn::Set(d, by.to_root), hn::Set(d, by.epsilon));
    const auto weight = hn::Mul(hn::LoadU(d, slice.weights.data() + i), hn::Set(d, by.keep_weight));
    hn::StoreU(hn::Sub(weight, hn::Div(hn::Mul(first, hn::Set(d, by.move)), below)), d, slice.weights.data() + i);
  }
  return i;
}

void step_adam(const OptimizerStep& step, const WeightSlice& slice) {
  const AdamFactors by(step);
  take_adam(One(), by, slice, take_adam(Full(), by, slice, 0));
}

template <class D>
HWY_INLINE std::size_t take_sgd(D d, float momentum, float rate, const WeightSlice& slice, std::size_t begin) {
  const std::size_t lanes = hn::Lanes(d), count = slice.weights.size();
  std::size_t i = begin;
  for (; i + lanes <= count; i += lanes) {
    const auto first =
        hn::MulAdd(hn::LoadU(d, slice.first_moment.data() + i), hn::Set(d, momentum), hn::LoadU(d, slice.gradients.data() + i));
    hn::StoreU(first, d, slice.first_moment.data() + i);
    hn::StoreU(hn::NegMulAdd(first, hn::Set(d, rate), hn::LoadU(d, slice.weights.data() + i)), d, slice.weights.data() + i);
  }
  return i;
}

void step_sgd(const OptimizerStep& step, const WeightSlice& slice) {
  constexpr float momentum = 0.9F;
  const auto rate = static_cast<float>(step.learning_rate);
  take_sgd(One(), momentum, rate, slice, take_sgd(Full(), momentum, rate, slice, 0));
}

float squares_of(std::span<const float> values) {
  const Full d;
  const std::size_t lanes = hn::Lanes(d);
  auto sum = hn::Zero(d), other = hn::Zero(d);
  std::size_t i = 0;
  for (; i + 2 * lanes <= values.size(); i += 2 * lanes) {
    const auto a = hn::LoadU(d, values.data() + i), b = hn::LoadU(d, values.data() + i + lanes);
    sum = hn::MulAdd(a, a, sum);
    other = hn::MulAdd(b, b, other);
  }
  float total = hn::GetLane(hn::SumOfLanes(d, hn::Add(sum, other)));
  for (; i < values.size(); ++i) total += values[i] * values[i];
  return total;
}

}  // namespace
}  // namespace tactile::model::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tactile::model {
namespace {

HWY_EXPORT(step_adam);
HWY_EXPORT(step_sgd);
HWY_EXPORT(squares_of);

}  // namespace

void take_step(const OptimizerStep& step, const WeightSlice& slice) {
  if (step.kind == OptimizerKind::sgd)
    HWY_DYNAMIC_DISPATCH(step_sgd)(step, slice);
  else
    HWY_DYNAMIC_DISPATCH(step_adam)(step, slice);
}

double sum_of_squares(std::span<const float> values, unsigned threads) {
  constexpr std::size_t block = 4096, blocks_of_piece = 16;
  std::vector<float> sums((values.size() + block - 1) / block);
  parallel_for((sums.size() + blocks_of_piece - 1) / blocks_of_piece, threads, [&](std::size_t piece) {
    for (std::size_t i = piece * blocks_of_piece; i < std::min(sums.size(), (piece + 1) * blocks_of_piece); ++i)
      sums[i] = HWY_DYNAMIC_DISPATCH(squares_of)(values.subspan(i * block, std::min(block, values.size() - i * block)));
  });
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

}  // namespace tactile::model
#endif
