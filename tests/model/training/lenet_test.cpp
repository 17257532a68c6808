#include "tactile/model/training/lenet.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "model/noise_heatmaps.hpp"
#include "tactile/core/error.hpp"

namespace tactile::model {
namespace {

using test::noise_heatmaps;

/// Channels of a picture, [channels][height][width] in one row.
struct Picture {
  int channels = 0, height = 0, width = 0;
  std::vector<double> values;

  double& at(int c, int y, int x) { return values[static_cast<std::size_t>((c * height + y) * width + x)]; }
};

Picture blank(int channels, int height, int width) {
  return {channels, height, width, std::vector<double>(static_cast<std::size_t>(channels * height * width))};
}

/// Convolution as machine learning means it (no flip), ReLU, then the largest of each 2 x 2 block.
Picture convolved_and_pooled(Picture in, const std::vector<float>& weight, const std::vector<float>& bias) {
  const int channels = static_cast<int>(bias.size());
  Picture convolved = blank(channels, in.height - 4, in.width - 4);
  for (int c = 0; c < channels; ++c) {
    for (int y = 0; y < convolved.height; ++y) {
      for (int x = 0; x < convolved.width; ++x) {
        double sum = bias[static_cast<std::size_t>(c)];
        for (int k = 0; k < in.channels; ++k) {
          for (int dy = 0; dy < 5; ++dy) {
            for (int dx = 0; dx < 5; ++dx) {
              sum += static_cast<double>(weight[static_cast<std::size_t>(((c * in.channels + k) * 5 + dy) * 5 + dx)]) *
                     in.at(k, y + dy, x + dx);
            }
          }
        }
        convolved.at(c, y, x) = std::max(sum, 0.0);
      }
    }
  }
  Picture pooled = blank(channels, convolved.height / 2, convolved.width / 2);
  for (int c = 0; c < channels; ++c) {
    for (int y = 0; y < pooled.height; ++y) {
      for (int x = 0; x < pooled.width; ++x) {
        pooled.at(c, y, x) = std::max(std::max(convolved.at(c, 2 * y, 2 * x), convolved.at(c, 2 * y, 2 * x + 1)),
                                      std::max(convolved.at(c, 2 * y + 1, 2 * x), convolved.at(c, 2 * y + 1, 2 * x + 1)));
      }
    }
  }
  return pooled;
}

std::vector<double> connected(const std::vector<double>& in, const std::vector<float>& weight, const std::vector<float>& bias,
                              bool relu) {
  std::vector<double> out(bias.begin(), bias.end());
  for (std::size_t i = 0; i < out.size(); ++i) {
    for (std::size_t j = 0; j < in.size(); ++j) out[i] += static_cast<double>(weight[i * in.size() + j]) * in[j];
    if (relu) out[i] = std::max(out[i], 0.0);
  }
  return out;
}

/// The whole network, written out from its definition.
std::vector<double> plain_logits(const Weights& weights, const std::uint8_t* heatmap, events::SensorSize size) {
  std::map<std::string, std::vector<float>> values;
  for (const Parameter& parameter : weights) values[parameter.shape.name] = parameter.values;
  Picture picture = blank(1, size.height, size.width);
  for (std::size_t i = 0; i < picture.values.size(); ++i) picture.values[i] = heatmap[i] / 255.0;
  picture = convolved_and_pooled(picture, values["conv1.weight"], values["conv1.bias"]);
  picture = convolved_and_pooled(picture, values["conv2.weight"], values["conv2.bias"]);
  auto x = connected(picture.values, values["fc1.weight"], values["fc1.bias"], true);
  x = connected(x, values["fc2.weight"], values["fc2.bias"], true);
  return connected(x, values["fc3.weight"], values["fc3.bias"], false);
}

void expect_plain_logits(events::SensorSize size) {
  const auto noise = noise_heatmaps(3, size, 5);
  const LeNet network(size, 1);
  const auto logits = network.logits(noise.heatmaps, 1);
  ASSERT_EQ(logits.size(), 3U);
  const std::size_t cells = noise.heatmaps.size() / 3;
  for (std::size_t n = 0; n < logits.size(); ++n) {
    const auto expected = plain_logits(network.weights(), noise.heatmaps.data() + n * cells, size);
    double scale = 0;
    for (const double value : expected) scale = std::max(scale, std::abs(value));
    for (std::size_t k = 0; k < touch_count; ++k)
      EXPECT_NEAR(logits[n][k], expected[k], 1e-4 * scale) << "heatmap " << n << ", logit " << k;
  }
}

TEST(LeNet, LogitsAreThoseOfAPlainForwardPass) { expect_plain_logits({128, 96}); }

TEST(LeNet, LogitsAreThoseOfAPlainForwardPassForOddSizesToo) { expect_plain_logits({31, 22}); }

TEST(LeNet, FirstWeightsDependOnTheSeedAlone) {
  EXPECT_EQ(LeNet({32, 24}, 7).weights(), LeNet({32, 24}, 7).weights());
  EXPECT_NE(LeNet({32, 24}, 7).weights(), LeNet({32, 24}, 8).weights());
}

TEST(LeNet, FirstWeightsLieWithinTheBoundsOfLibtorchsDefault) {
  // Both weight and bias are uniform within 1 / sqrt(inputs of a unit).
  const std::map<std::string, double> inputs{{"conv1", 25}, {"conv2", 150}, {"fc1", 9744}, {"fc2", 120}, {"fc3", 84}};
  for (const Parameter& parameter : LeNet({128, 96}, 1).weights()) {
    const double bound = 1 / std::sqrt(inputs.at(parameter.shape.name.substr(0, parameter.shape.name.find('.'))));
    double largest = 0;
    for (const float value : parameter.values) largest = std::max(largest, std::abs(static_cast<double>(value)));
    EXPECT_LE(largest, bound * (1 + 1e-6)) << parameter.shape.name;
    EXPECT_GT(largest, bound * 0.4) << parameter.shape.name;
  }
}

TEST(LeNet, BuiltFromWeightsIsTheSameNetwork) {
  const auto noise = noise_heatmaps(4, {32, 24}, 2);
  const LeNet network({32, 24}, 3);
  EXPECT_EQ(LeNet({32, 24}, network.weights()).logits(noise.heatmaps, 1), network.logits(noise.heatmaps, 1));
}

TEST(LeNet, RefusesWeightsOfAnotherNetwork) {
  const Weights weights = LeNet({32, 24}, 3).weights();
  EXPECT_THROW(LeNet({40, 24}, weights), Error);
  EXPECT_THROW(LeNet({32, 24}, Weights(weights.begin(), weights.end() - 1)), Error);
}

TEST(LeNet, LogitsDependNeitherOnThreadsNorOnTheOtherHeatmapsOfACall) {
  const auto noise = noise_heatmaps(100, {128, 96}, 9);
  const LeNet network({128, 96}, 1);
  const auto one = network.logits(noise.heatmaps, 1);
  EXPECT_EQ(network.logits(noise.heatmaps, 2), one);
  EXPECT_EQ(network.logits(noise.heatmaps, 5), one);
}

TEST(LeNet, RefusesHalfAHeatmap) {
  const LeNet network({32, 24}, 1);
  EXPECT_THROW(network.logits(std::vector<std::uint8_t>(32 * 24 + 1), 1), Error);
  EXPECT_TRUE(network.logits({}, 1).empty());
}

TEST(LeNet, RefusesLogitsThatLeaveFloat32) {
  constexpr events::SensorSize size{32, 24};
  const auto noise = test::noise_heatmaps(3, size, 1);
  Weights weights = LeNet(size, 4).weights();
  for (Parameter& parameter : weights) {
    for (float& value : parameter.values) value *= 1e30F;
  }
  try {
    LeNet(size, weights).logits(noise.heatmaps, 1);
    ADD_FAILURE() << "a verdict of infinite sums";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("the logits of heatmap 1 of 3 are "), std::string::npos) << e.what();
  }
}

TEST(LeNet, DistinguishesHeatmapsWithTinyLogits) {
  // Only the last layer is small: nothing underflows, and the verdicts are those of before.
  constexpr events::SensorSize size{32, 24};
  const auto noise = test::noise_heatmaps(8, size, 1);
  Weights weights = LeNet(size, 4).weights();
  const auto before = LeNet(size, weights).logits(noise.heatmaps, 1);
  for (std::size_t i : {8U, 9U}) {
    for (float& value : weights[i].values) value *= 1e-30F;
  }
  const auto tiny = LeNet(size, weights).logits(noise.heatmaps, 1);
  for (std::size_t i = 0; i < tiny.size(); ++i) {
    EXPECT_EQ(verdict_of(tiny[i]), verdict_of(before[i]));
    EXPECT_LT(std::abs(tiny[i][0]), 1e-28F);
    for (const float p : probabilities_of(tiny[i])) EXPECT_NEAR(p, 1.0F / 3, 1e-6F) << "and all are uncertain";
  }
}

TEST(VerdictOf, IsTheLargestLogitAndTheEarlierOfEquals) {
  EXPECT_EQ(verdict_of({-1, -2, -0.5F}), Touch::slip);
  EXPECT_EQ(verdict_of({1, 3, 2}), Touch::press);
  EXPECT_EQ(verdict_of({0, 2, 2}), Touch::press);
  EXPECT_EQ(verdict_of({2, 2, 2}), Touch::none);
}

}  // namespace
}  // namespace tactile::model
