#include "tactile/model/training/fully_connected.hpp"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "tactile/core/random.hpp"

namespace tactile::model {
namespace {

/// A layer with values for a batch.
struct Layer {
  std::size_t samples, inputs, units;
  std::vector<float> input, weight, bias, gradient;

  Layer(std::size_t n, std::size_t k, std::size_t u) : samples(n), inputs(k), units(u) {
    Random random(n + 100 * k + 10'000 * u);
    const auto drawn = [&](std::size_t count) {
      std::vector<float> values(count);
      for (float& value : values) value = static_cast<float>(random.below(20'001)) / 10'000.0F - 1.0F;
      return values;
    };
    input = drawn(n * k), weight = drawn(u * k), bias = drawn(u), gradient = drawn(n * u);
  }
};

struct Results {
  std::vector<float> output, of_input, of_weight;
  bool operator==(const Results&) const = default;
};

Results results_of(const Layer& layer, unsigned threads) {
  const float untouched = std::numeric_limits<float>::quiet_NaN();
  Results results{std::vector(layer.samples * layer.units, untouched), std::vector(layer.input.size(), untouched),
                  std::vector(layer.weight.size(), untouched)};
  const FullyConnected connected(layer.inputs, layer.units);
  connected.forward(layer.input, layer.weight, layer.bias, results.output, threads);
  connected.backward(layer.input, layer.weight, layer.gradient, results.of_input, results.of_weight, threads);
  return results;
}

/// Each value's error by the sum of the absolute products, from plain sums of long double.
void expect_exact(const Layer& layer, const Results& results) {
  const std::size_t samples = layer.samples, inputs = layer.inputs, units = layer.units;
  const auto expect = [](float value, long double sum, long double largest, const char* what) {
    EXPECT_LE(std::abs(static_cast<long double>(value) - sum), 3e-7L * std::max(largest, 1e-3L)) << what;
  };
  const auto sum_over = [&](std::size_t count, const auto& product, long double& sum, long double& largest) {
    for (std::size_t i = 0; i < count; ++i) {
      const long double term = product(i);
      sum += term;
      largest += std::abs(term);
    }
  };
  const auto at = [](const std::vector<float>& values, std::size_t i) { return static_cast<long double>(values[i]); };
  for (std::size_t n = 0; n < samples; ++n) {
    for (std::size_t u = 0; u < units; ++u) {
      long double sum = at(layer.bias, u), largest = std::abs(sum);
      sum_over(
          inputs, [&](std::size_t k) { return at(layer.input, n * inputs + k) * at(layer.weight, u * inputs + k); }, sum,
          largest);
      expect(results.output[n * units + u], sum, largest, "output");
    }
    for (std::size_t k = 0; k < inputs; ++k) {
      long double sum = 0, largest = 0;
      sum_over(
          units, [&](std::size_t u) { return at(layer.gradient, n * units + u) * at(layer.weight, u * inputs + k); }, sum,
          largest);
      expect(results.of_input[n * inputs + k], sum, largest, "of_input");
    }
  }
  for (std::size_t u = 0; u < units; ++u) {
    for (std::size_t k = 0; k < inputs; ++k) {
      long double sum = 0, largest = 0;
      sum_over(
          samples, [&](std::size_t n) { return at(layer.gradient, n * units + u) * at(layer.input, n * inputs + k); }, sum,
          largest);
      expect(results.of_weight[u * inputs + k], sum, largest, "of_weight");
    }
  }
}

TEST(FullyConnected, IsThatOfLongDoubleOnEveryKindOfProcessor) {
  int targets = 0;
  for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1, ++targets) {
    hwy::SetSupportedTargetsForTest(left & -left);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    SCOPED_TRACE(hwy::TargetName(hwy::SupportedTargets()));
    for (const Layer& layer : {Layer(1, 1, 1), Layer(5, 7, 3), Layer(3, 300, 30), Layer(33, 517, 121), Layer(17, 256, 8)})
      expect_exact(layer, results_of(layer, 2));
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  EXPECT_GE(targets, 1);
}

TEST(FullyConnected, DependsNotOnTheThreadsToTheBit) {
  const Layer layer(31, 2500, 117);
  const Results one = results_of(layer, 1);
  for (const unsigned threads : {2U, 3U, 8U, 16U, 64U}) EXPECT_EQ(results_of(layer, threads), one) << threads;
}

TEST(FullyConnected, OneSampleIsTheSameInEveryBatch) {
  const Layer layer(37, 999, 30);
  const Results all = results_of(layer, 1);
  Layer last(1, 999, 30);
  last.weight = layer.weight, last.bias = layer.bias;
  last.input.assign(layer.input.end() - 999, layer.input.end());
  const Results alone = results_of(last, 1);
  EXPECT_EQ(alone.output, std::vector<float>(all.output.end() - 30, all.output.end()));
}

TEST(FullyConnected, PassesOnWhatIsNotANumber) {
  Layer layer(4, 64, 8);
  layer.input[64] = std::numeric_limits<float>::quiet_NaN();  // of the second sample
  const Results results = results_of(layer, 1);
  for (std::size_t i = 0; i < results.output.size(); ++i) EXPECT_EQ(std::isnan(results.output[i]), i / 8 == 1) << i;
}

}  // namespace
}  // namespace tactile::model
