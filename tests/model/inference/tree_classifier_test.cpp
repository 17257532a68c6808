#include "tactile/model/inference/tree_classifier.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "events/made_recording.hpp"
#include "support/error_of.hpp"
#include "tactile/core/error.hpp"
#include "tactile/model/inference/heatmap_classifier.hpp"

namespace tactile::model {
namespace {

constexpr events::SensorSize tree_sensor{64, 48};
const heatmaps::HeatmapOptions rendering{.history = 8ms, .tick = 2ms};

/// A round of depth 1: the classes compare the number of events in the last quarter, its mean x and its mean y.
std::shared_ptr<const BoostedTrees> trees() {
  constexpr std::uint32_t last = 3 * features::features_of_window;
  return std::make_shared<const BoostedTrees>(features::feature_count, 1,
                                              std::vector<BoostedTrees::Node>{{last, 1}, {last + 2, 0.5F}, {last + 3, 0.5F}},
                                              std::vector<float>{1, -1, 2, -2, 3, -3});
}

TEST(TreeClassifier, ReadsTheFeaturesOfTheHistory) {
  TreeClassifier classifier(tree_sensor, rendering, trees());
  classifier.move_to(CameraTime{8ms});
  classifier.prepare();
  EXPECT_EQ(classifier.classify(), (Logits{1, -2, -3})) << "without events the means are in the middle, which goes right";
  EXPECT_EQ(classifier.events(), 0U);

  const std::vector<events::Event> events{
      {CameraTime{9ms}, 3, 40, 1}, {CameraTime{10ms}, 5, 40, 0}, {CameraTime{17ms}, 60, 2, 0}};
  classifier.add(events);
  classifier.move_to(CameraTime{10ms});
  classifier.prepare();
  // ln 2 events are fewer than 1; they lie on the left and below.
  EXPECT_EQ(classifier.classify(), (Logits{1, 2, -3}));
  EXPECT_EQ(classifier.events(), 1U);
  classifier.move_to(CameraTime{18ms});
  EXPECT_EQ(classifier.classify(), (Logits{1, 2, -3})) << "the input that was prepared last";
  classifier.prepare();
  EXPECT_EQ(classifier.classify(), (Logits{1, -2, 3}));
  EXPECT_EQ(classifier.events(), 2U);

  classifier.restart();
  EXPECT_EQ(classifier.events(), 0U);
  classifier.add(events);  // earlier than the last tick
  classifier.move_to(CameraTime{10ms});
  classifier.prepare();
  EXPECT_EQ(classifier.classify(), (Logits{1, 2, -3}));
}

TEST(TreeClassifier, DependsOnTheHistoryAloneNotOnTheTicksBefore) {
  const std::vector<events::Event> events = test::steady_events(4'000, 0, 20, tree_sensor);
  TreeClassifier every(tree_sensor, rendering, trees());
  every.add(events);
  for (std::int64_t ms = 8; ms <= 80; ms += 2) {
    every.move_to(CameraTime{microseconds{1000 * ms}});
    every.prepare();
    if (ms % 6 != 0) continue;
    TreeClassifier one(tree_sensor, rendering, trees());
    one.add(events);
    one.move_to(CameraTime{microseconds{1000 * ms}});
    one.prepare();
    ASSERT_EQ(every.classify(), one.classify()) << ms;
    ASSERT_EQ(every.events(), one.events()) << ms;
  }
}

TEST(TreeClassifier, CountsEventsAsTheRendererDoes) {
  std::vector<events::Event> events = test::steady_events(2'000, 0, 20, tree_sensor);
  heatmaps::HeatmapOptions masked = rendering;
  masked.mask = {{events[3].x, events[3].y}};
  HeatmapClassifier heatmap(tree_sensor, masked, [](std::span<const std::uint8_t>) { return Logits{}; });
  TreeClassifier tree(tree_sensor, masked, trees());
  heatmap.add(events), tree.add(events);
  for (std::int64_t ms = 2; ms <= 44; ms += 2) {
    heatmap.move_to(CameraTime{microseconds{1000 * ms}}), tree.move_to(CameraTime{microseconds{1000 * ms}});
    ASSERT_EQ(tree.events(), heatmap.events()) << ms;
  }
}

TEST(TreeClassifier, IsFiniteForEveryEventAtOnePixelAndForSaturation) {
  TreeClassifier classifier(tree_sensor, rendering, trees());
  for (const bool everywhere : {false, true}) {
    classifier.restart();
    std::vector<events::Event> events;
    for (std::int32_t i = 0; i < 200'000; ++i) {
      events::Event event{CameraTime{microseconds{i / 30}}, 63, 47, 1};
      if (everywhere)
        event.x = static_cast<std::int16_t>(i % 64), event.y = static_cast<std::int16_t>(i / 64 % 48),
        event.on = i % 2 == 0 ? 1 : 0;
      events.push_back(event);
    }
    classifier.add(events);
    classifier.move_to(CameraTime{8ms});
    classifier.prepare();
    for (const float logit : classifier.classify()) EXPECT_TRUE(std::isfinite(logit));
    EXPECT_EQ(classifier.events(), 200'000U);
  }
}

TEST(TreeClassifier, RefusesEventsThatGoBackOrLieOutside) {
  TreeClassifier classifier(tree_sensor, rendering, trees());
  const std::vector<events::Event> outside{{CameraTime{1ms}, 64, 0, 1}}, good{{CameraTime{1ms}, 63, 0, 1}};
  EXPECT_THROW(classifier.add(outside), Error);
  classifier.add(good);
  EXPECT_THROW(classifier.add(std::vector<events::Event>{{CameraTime{500us}, 0, 0, 1}}), Error);
  classifier.move_to(CameraTime{2ms});
  EXPECT_EQ(classifier.events(), 1U);
  const auto other =
      std::make_shared<const BoostedTrees>(2, 1, std::vector<BoostedTrees::Node>{{0, 0}, {0, 0}, {0, 0}}, std::vector<float>(6));
  EXPECT_NE(
      test::error_of([&] { TreeClassifier(tree_sensor, rendering, other); }).find("trees that read 2 features; expected 84"),
      std::string::npos);
}

TEST(BoostedTrees, ReadWhatTheyWrite) {
  const BoostedTrees two(2, 1, {{0, 1}, {1, 2}, {0, 3}, {1, 0}, {0, 0}, {1, 5}}, {1, 2, 3, 4, 5, 6, 10, 20, 30, 40, 50, 60});
  const TreesOptions options{.rounds = 2, .depth = 1};
  Weights weights = two.weights();
  const BoostedTrees again(2, options, weights);
  EXPECT_EQ(again.logits(std::vector<float>{0.5F, 2}), two.logits(std::vector<float>{0.5F, 2}));
  EXPECT_EQ(again.weights(), weights);
  for (const float wrong : {-1.0F, 0.5F, 2.0F, 1e9F, std::numeric_limits<float>::quiet_NaN()}) {
    Weights damaged = weights;
    damaged[0].values[3] = wrong;
    EXPECT_THROW(BoostedTrees(2, options, damaged), Error) << wrong;
  }
  weights.pop_back();
  EXPECT_THROW(BoostedTrees(2, options, weights), Error);
}

}  // namespace
}  // namespace tactile::model
