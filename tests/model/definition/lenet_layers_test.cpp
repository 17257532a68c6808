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
}

}  // namespace
}  // namespace tactile::model
