#include "tactile/model/inference/temporal_network.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "events/made_recording.hpp"
#include "support/error_of.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/model/inference/temporal_classifier.hpp"

namespace tactile::model {
namespace {

/// All weights 0 but those that are named.
Weights empty_weights(const TemporalOptions& options) {
  Weights weights;
  for (const ParameterShape& shape : temporal_parameters(options)) weights.push_back({shape, std::vector<float>(shape.count())});
  weights[1].values.assign(weights[1].values.size(), 1);
  return weights;
}

Weights random_weights(const TemporalOptions& options) {
  Weights weights = empty_weights(options);
  Random random(2);
  for (std::size_t i = 2; i < weights.size(); ++i) {
    for (float& value : weights[i].values) value = static_cast<float>(random.uniform(-0.5, 0.5));
  }
  return weights;
}

TEST(TemporalNetwork, AddsTheStepsThatLieApartByPowersOfTwo) {
  // One channel: each layer adds both of its values, and the logits are the sum times 1, 2 and 3, plus 0, 0 and 10.
  const TemporalOptions one{.channels = 1};
  Weights weights = empty_weights(one);
  weights[2].values[0] = weights[2].values[1] = 1;  // both taps of the first feature
  for (const std::size_t layer : {4U, 6U, 8U}) weights[layer].values = {1, 1};
  weights[10].values = {1, 2, 3};
  weights[11].values = {0, 0, 10};
  weights[0].values[0] = 1;  // mean
  const TemporalNetwork network(one, weights);
  std::vector<float> features(features::step_values);
  for (std::size_t step = 0; step < features::steps_of_history; ++step)
    features[step * features::features_of_step] = 1 + static_cast<float>(step) / 100;
  const float sum = 120.0F / 100;
  const Logits logits = network.logits(features);
  EXPECT_NEAR(logits[0], sum, 1e-5);
  EXPECT_NEAR(logits[1], 2 * sum, 1e-5);
  EXPECT_NEAR(logits[2], 3 * sum + 10, 1e-5);
}

TEST(TemporalNetwork, LimitsItsInput) {
  const TemporalNetwork network({}, random_weights({}));
  std::vector<float> at_the_limit(features::step_values, largest_step_value), far(features::step_values, 1e30F);
  EXPECT_EQ(network.logits(far), network.logits(at_the_limit));
  std::vector<float> values(2);
  standardise(std::vector<float>{4, -100}, std::vector<float>{2, 0}, std::vector<float>{0.5F, 1}, values);
  EXPECT_EQ(values, (std::vector<float>{1, -10}));
}

TEST(TemporalNetwork, RefusesWeightsOfOtherShapesOrThatLeaveFloat32) {
  Weights weights = random_weights({});
  EXPECT_THROW(TemporalNetwork({.channels = 31}, weights), Error);
  EXPECT_THROW(TemporalNetwork({.channels = 0}, weights), Error);
  for (const std::size_t layer : {2U, 4U, 6U}) {
    for (float& value : weights[layer].values) value *= 1e15F;
  }
  EXPECT_NE(test::error_of([&] { TemporalNetwork({}, weights); }).find("of smaller weights"), std::string::npos);
  const TemporalNetwork network({}, random_weights({}));
  EXPECT_THROW(network.logits(std::vector<float>(191)), Error);
}

TEST(TemporalClassifier, DependsOnTheHistoryAloneNotOnTheTicksBefore) {
  constexpr events::SensorSize sensor{64, 48};
  const auto network = std::make_shared<const TemporalNetwork>(TemporalOptions{}, random_weights({}));
  const std::vector<events::Event> events = test::steady_events(8'000, 0, 20, sensor);
  for (const microseconds tick : {2'000us, 1'000us, 4'000us}) {
    const heatmaps::HeatmapOptions rendering{.history = 40ms, .tick = tick};
    TemporalClassifier every(sensor, rendering, 2ms, network);
    every.add(events);
    for (CameraTime t{0us}; t <= CameraTime{150ms}; t = after(t, tick)) {
      every.move_to(t);
      every.prepare();
      TemporalClassifier one(sensor, rendering, 2ms, network);
      one.add(events);
      one.move_to(t);
      one.prepare();
      ASSERT_EQ(every.classify(), one.classify()) << us_of(t);
      ASSERT_EQ(every.events(), one.events());
    }
    every.restart();
    every.add(events);
    every.move_to(CameraTime{40ms});
    every.prepare();
    for (const float logit : every.classify()) EXPECT_TRUE(std::isfinite(logit));
    EXPECT_EQ(every.events(), 2'000U);
  }
  EXPECT_THROW(TemporalClassifier(sensor, {.history = 30ms, .tick = 2ms}, 2ms, network), Error);
}

}  // namespace
}  // namespace tactile::model
