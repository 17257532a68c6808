#include "tactile/model/definition/lenet_layers.hpp"

#include <gtest/gtest.h>

#include "tactile/core/error.hpp"

namespace tactile::model {
namespace {

TEST(LeNetLayers, OfThePapersHeatmapFlattenTo9744) {
  // 128 x 96 -> 124 x 92 -> 62 x 46 -> 58 x 42 -> 29 x 21, times 16 channels.
  const LeNetLayers layers = lenet_layers({128, 96});
  EXPECT_EQ(layers.first_pooled, (events::SensorSize{62, 46}));
  EXPECT_EQ(layers.second_pooled, (events::SensorSize{29, 21}));
  EXPECT_EQ(layers.flat, 9744U);
  // 6*25+6, 16*150+16, 9744*120+120, 120*84+84, 84*3+3
  EXPECT_EQ(layers.parameter_count(), 156U + 2416U + 1'169'400U + 10'164U + 255U);
}

TEST(LeNetLayers, OfSmallerNetworksHaveFewerChannelsUnitsAndWeights) {
  const auto sizes_of = [](const LeNetOptions& options) {
    const LeNetLayers layers = lenet_layers({128, 96}, options);
    return std::vector<std::size_t>{layers.first_channels, layers.second_channels,  layers.first_hidden, layers.second_hidden,
                                    layers.flat,           layers.parameter_count()};
  };
  using Sizes = std::vector<std::size_t>;
  EXPECT_EQ(sizes_of({.width = 0.5}), (Sizes{3, 8, 60, 42, 4872, 78 + 608 + 292'380 + 2562 + 129}));
  EXPECT_EQ(sizes_of({.width = 0.25}), (Sizes{2, 4, 30, 21, 2436, 52 + 204 + 73'110 + 651 + 66}));
  // 29 x 21 -> 14 x 10, times 16 channels
  EXPECT_EQ(sizes_of({.last_pool = 4}), (Sizes{6, 16, 120, 84, 2240, 156 + 2416 + 268'920 + 10'164 + 255}));
}

TEST(LeNetLayers, OfADefaultSizeAreDescribedAsBefore) {
  EXPECT_EQ(nlohmann::json(LeNetOptions{}), (nlohmann::json{{"activation", "relu"}, {"pool", "max"}}));
  const LeNetOptions smaller{.width = 0.25, .last_pool = 4};
  EXPECT_EQ(nlohmann::json(smaller).get<LeNetOptions>(), smaller);
  EXPECT_EQ(json_of(lenet_layers({64, 48}, smaller), smaller).at("layers").at(5), "max-pool 4");
  for (const auto& wrong : {nlohmann::json{{"width", 0.3}}, nlohmann::json{{"last_pool", 3}}}) {
    nlohmann::json json(LeNetOptions{});
    json.update(wrong);
    EXPECT_THROW(json.get<LeNetOptions>(), Error) << wrong;
  }
}

TEST(LeNetLayers, ParametersComeWeightBeforeBias) {
  const auto parameters = lenet_layers({128, 96}).parameters();
  ASSERT_EQ(parameters.size(), 10U);
  EXPECT_EQ(parameters[0], (ParameterShape{"conv1.weight", {6, 1, 5, 5}}));
  EXPECT_EQ(parameters[3], (ParameterShape{"conv2.bias", {16}}));
  EXPECT_EQ(parameters[4], (ParameterShape{"fc1.weight", {120, 9744}}));
  EXPECT_EQ(parameters[9], (ParameterShape{"fc3.bias", {3}}));
}

TEST(LeNetLayers, PoolingRoundsDown) {
  // 17 -> 13 -> 6 -> 2 -> 1 and 19 -> 15 -> 7 -> 3 -> 1.
  EXPECT_EQ(lenet_layers({17, 19}).second_pooled, (events::SensorSize{1, 1}));
}

TEST(LeNetLayers, RefuseHeatmapsThatDoNotSurviveThem) {
  EXPECT_EQ(lenet_layers({16, 16}).flat, 16U);
  EXPECT_THROW(lenet_layers({15, 96}), Error);
  EXPECT_THROW(lenet_layers({128, 15}), Error);
  EXPECT_THROW(lenet_layers({0, 0}), Error);
  EXPECT_THROW(lenet_layers({5000, 96}), Error);
  EXPECT_EQ(lenet_layers({20, 20}, {.last_pool = 4}).flat, 16U);
  EXPECT_THROW(lenet_layers({19, 20}, {.last_pool = 4}), Error);
}

}  // namespace
}  // namespace tactile::model
