#include "tactile/model/definition/model_settings.hpp"

#include <gtest/gtest.h>

#include <regex>

namespace tactile::model {
namespace {

TEST(DefaultName, HasHistorySplitRunAndSeed) {
  ModelSettings settings;
  EXPECT_EQ(default_name(settings), "th040-single-run-01-s1");
  settings.split.kind = windows::SplitKind::unseen;
  settings.split.train_run = "03";
  settings.training.seed = 12;
  settings.rendering.history = 2ms;
  EXPECT_EQ(default_name(settings), "th002-unseen-03-s12");
}

TEST(DefaultName, AppendsAHashOfSettingsOffTheirDefault) {
  const std::regex hashed("th040-single-run-01-s1-[0-9a-f]{8}");
  ModelSettings epochs, other_epochs, denoise, history, mask;
  epochs.training.epochs = 3;
  other_epochs.training.epochs = 4;
  denoise.rendering.denoise = heatmaps::Denoise::none;
  history.rendering.history = 40'500us;
  history.rendering.tick = 500us;
  mask.rendering.mask = {{1, 2}};
  for (const ModelSettings& settings : {epochs, other_epochs, denoise, history, mask}) {
    EXPECT_TRUE(std::regex_match(default_name(settings), hashed)) << default_name(settings);
  }
  EXPECT_NE(default_name(epochs), default_name(other_epochs));
  EXPECT_NE(default_name(epochs), default_name(denoise));
}

TEST(DefaultName, BeginsWithAKindOtherThanLeNet) {
  ModelSettings settings;
  settings.kind = ModelKind::trees;
  EXPECT_EQ(default_name(settings), "trees-th040-single-run-01-s1");
  settings.training.epochs = 3;  // has no meaning for trees
  EXPECT_EQ(default_name(settings), "trees-th040-single-run-01-s1");
  settings.trees.depth = 3;
  EXPECT_TRUE(std::regex_match(default_name(settings), std::regex("trees-th040-single-run-01-s1-[0-9a-f]{8}")));
}

TEST(ModelSettings, WithoutAKindAreOfLeNetAndStayAsTheyWere) {
  const nlohmann::json lenet = ModelSettings{};
  EXPECT_FALSE(lenet.at("network").contains("kind"));
  EXPECT_EQ(lenet.get<ModelSettings>().kind, ModelKind::lenet);
  ModelSettings trees;
  trees.kind = ModelKind::trees;
  trees.trees = {.rounds = 7, .depth = 2, .learning_rate = 0.3};
  trees.training.seed = 9;
  const auto read = nlohmann::json(trees).get<ModelSettings>();
  EXPECT_EQ(read.kind, ModelKind::trees);
  EXPECT_EQ(read.trees, trees.trees);
  EXPECT_EQ(read.training.seed, 9U);
  EXPECT_TRUE(same_settings(read, trees));
  EXPECT_FALSE(same_settings(read, {}));
}

TEST(DefaultName, DoesNotDependOnTheOrderOfHeldOutObjectsNorOnThemWhereNoneIsHeldOut) {
  ModelSettings settings;
  settings.split.held_out = {"fan"};
  EXPECT_EQ(default_name(settings), "th040-single-run-01-s1");
  settings.split.kind = windows::SplitKind::unseen;
  settings.split.held_out = {"sprayer", "small-box", "fan", "plastic-container", "textured-box"};
  EXPECT_EQ(default_name(settings), "th040-unseen-01-s1");
  settings.split.held_out = {"fan"};
  EXPECT_NE(default_name(settings), "th040-unseen-01-s1");
}

TEST(ModelSettings, ComeBackFromJson) {
  ModelSettings settings;
  settings.rendering.resize = heatmaps::Resize::linear;
  settings.split = {.kind = windows::SplitKind::unseen, .train_run = "02", .held_out = {"fan", "sprayer"}};
  settings.training.learning_rate = 0.0123;
  EXPECT_TRUE(same_settings(nlohmann::json(settings).get<ModelSettings>(), settings));
  EXPECT_FALSE(same_settings(settings, {}));
}

}  // namespace
}  // namespace tactile::model
