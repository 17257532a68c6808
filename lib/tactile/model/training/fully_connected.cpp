#include "tactile/model/training/fully_connected.hpp"

#include <algorithm>
#include <array>

#include "tactile/core/parallel.hpp"

// Highway compiles what follows once for each kind of processor and takes the best of them at run time.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tactile/model/training/fully_connected.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tactile::model::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Full = hn::ScalableTag<float>;
using One = hn::CappedTag<float, 1>;

/// Rows of a matrix, one after the other.
struct Rows {
  const float* values;
  std::size_t length;
};

/// Adds to sums[a][b] the products of rows `a` and `b`, from column `begin` on in whole vectors of D. @return  the end of these
template <std::size_t A, std::size_t B, class D>
HWY_INLINE std::size_t add_products(D d, const Rows& a, const Rows& b, std::size_t begin,
                                    std::array<std::array<float, B>, A>& sums) {
  const std::size_t lanes = hn::Lanes(d);
  hn::VFromD<D> parts[A][B];
  for (std::size_t i = 0; i < A; ++i) {
    for (std::size_t j = 0; j < B; ++j) parts[i][j] = hn::Zero(d);
  }
  std::size_t k = begin;
  for (; k + lanes <= a.length; k += lanes) {
    hn::VFromD<D> left[A];
    for (std::size_t i = 0; i < A; ++i) left[i] = hn::LoadU(d, a.values + i * a.length + k);
    for (std::size_t j = 0; j < B; ++j) {
      const auto right = hn::LoadU(d, b.values + j * b.length + k);
      for (std::size_t i = 0; i < A; ++i) parts[i][j] = hn::MulAdd(left[i], right, parts[i][j]);
    }
  }
  for (std::size_t i = 0; i < A; ++i) {
    for (std::size_t j = 0; j < B; ++j) sums[i][j] += hn::GetLane(hn::SumOfLanes(d, parts[i][j]));
  }
  return k;
}

/// output[j * stride + i] = bias[i] + row i of `weight` times row j of `input`
template <std::size_t A, std::size_t B>
void multiply_block(const Rows& weight, const Rows& input, const float* bias, float* output, std::size_t stride) {
  std::array<std::array<float, B>, A> sums{};
  add_products<A, B>(One(), weight, input, add_products<A, B>(Full(), weight, input, 0, sums), sums);
  for (std::size_t i = 0; i < A; ++i) {
    for (std::size_t j = 0; j < B; ++j) output[j * stride + i] = bias[i] + sums[i][j];
  }
}

/// All outputs of up to 4 units.
void multiply(const float* weight, std::size_t units, const float* input, std::size_t samples, std::size_t length,
              const float* bias, float* output, std::size_t stride) {
  const auto block = [&]<std::size_t A, std::size_t B>(std::size_t i, std::size_t j) {
    multiply_block<A, B>({weight + i * length, length}, {input + j * length, length}, bias + i, output + j * stride + i, stride);
  };
  std::size_t j = 0;
  for (; j + 4 <= samples; j += 4) {
    if (units == 4) {
      block.template operator()<4, 4>(0, j);
    } else {
      for (std::size_t i = 0; i < units; ++i) block.template operator()<1, 4>(i, j);
    }
  }
  for (; j < samples; ++j) {
    for (std::size_t i = 0; i < units; ++i) block.template operator()<1, 1>(i, j);
  }
}

/// Factors of rows: of row b for result a at values[a * of_result + b * of_row].
struct Factors {
  const float* values;
  std::size_t of_result, of_row;
};

/// result[a][k] = sum over b of factor(a, b) rows[b][k] for A results and the columns from `begin` to `end`, in whole vectors of
/// D.
/// @return  the end of these
template <std::size_t A, class D>
HWY_INLINE std::size_t mix(D d, const Rows& rows, std::size_t count, const Factors& factors, float* result, std::size_t begin,
                           std::size_t end) {
  const std::size_t lanes = hn::Lanes(d);
  std::size_t k = begin;
  for (; k + lanes <= end; k += lanes) {
    hn::VFromD<D> sums[A];
    for (std::size_t a = 0; a < A; ++a) sums[a] = hn::Zero(d);
    for (std::size_t b = 0; b < count; ++b) {
      const auto values = hn::LoadU(d, rows.values + b * rows.length + k);
      for (std::size_t a = 0; a < A; ++a)
        sums[a] = hn::MulAdd(hn::Set(d, factors.values[a * factors.of_result + b * factors.of_row]), values, sums[a]);
    }
    for (std::size_t a = 0; a < A; ++a) hn::StoreU(sums[a], d, result + a * rows.length + k);
  }
  return k;
}

template <std::size_t A>
void mix_block(const Rows& rows, std::size_t count, const Factors& factors, float* result, std::size_t begin, std::size_t end) {
  mix<A>(One(), rows, count, factors, result, mix<A>(Full(), rows, count, factors, result, begin, end), end);
}

/// The same for any number of results, in blocks of 8.
void mix_rows(const float* rows, std::size_t length, std::size_t count, const float* factors, std::size_t of_result,
              std::size_t of_row, float* result, std::size_t results, std::size_t begin, std::size_t end) {
  std::size_t a = 0;
  for (; a + 8 <= results; a += 8)
    mix_block<8>({rows, length}, count, {factors + a * of_result, of_result, of_row}, result + a * length, begin, end);
  for (; a < results; ++a)
    mix_block<1>({rows, length}, count, {factors + a * of_result, of_result, of_row}, result + a * length, begin, end);
}

}  // namespace
}  // namespace tactile::model::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tactile::model {
namespace {

HWY_EXPORT(multiply);
HWY_EXPORT(mix_rows);

constexpr std::size_t block_units = 4, block_samples = 16;
constexpr std::size_t block_inputs = 256;  // columns; 32 samples of these are 32 KiB

std::size_t blocks_of(std::size_t count, std::size_t block) { return (count + block - 1) / block; }

}  // namespace

void FullyConnected::forward(std::span<const float> input, std::span<const float> weight, std::span<const float> bias,
                             std::span<float> output, unsigned threads) const {
  const std::size_t samples = input.size() / inputs_, of_units = blocks_of(units_, block_units);
  parallel_for(of_units * blocks_of(samples, block_samples), threads, [&](std::size_t block) {
    const std::size_t unit = block % of_units * block_units, sample = block / of_units * block_samples;
    HWY_DYNAMIC_DISPATCH(multiply)
    (weight.data() + unit * inputs_, std::min(block_units, units_ - unit), input.data() + sample * inputs_,
     std::min(block_samples, samples - sample), inputs_, bias.data() + unit, output.data() + sample * units_ + unit, units_);
  });
}

void FullyConnected::backward(std::span<const float> input, std::span<const float> weight, std::span<const float> gradient,
                              std::span<float> of_input, std::span<float> of_weight, unsigned threads) const {
  const std::size_t samples = input.size() / inputs_;
  parallel_for(blocks_of(inputs_, block_inputs), threads, [&](std::size_t block) {
    const std::size_t begin = block * block_inputs, end = std::min(inputs_, begin + block_inputs);
    HWY_DYNAMIC_DISPATCH(mix_rows)
    (weight.data(), inputs_, units_, gradient.data(), units_, 1, of_input.data(), samples, begin, end);
    HWY_DYNAMIC_DISPATCH(mix_rows)
    (input.data(), inputs_, samples, gradient.data(), 1, units_, of_weight.data(), units_, begin, end);
  });
}

}  // namespace tactile::model
#endif
