#include "tactile/model/definition/model_settings.hpp"

#include <gtest/gtest.h>

#include <regex>

namespace tactile::model {
namespace {

TEST(DefaultName, HasHistorySplitAndSeedAndARunThatIsNotTheFirst) {
  ModelSettings settings;
  EXPECT_EQ(default_name(settings), "th40-single-1");
  settings.training.seed = 7;
  EXPECT_EQ(default_name(settings), "th40-single-7");
  settings.split.kind = windows::SplitKind::unseen;
  settings.split.held_out = windows::default_held_out();
  settings.split.train_run = "03";
  settings.rendering.history = 2500us;
  EXPECT_EQ(default_name(settings), "th2.5-unseen-run03-7");
}

TEST(DefaultName, SaysUpToThreeSettingsOffTheirDefaultInWords) {
  ModelSettings settings;
  settings.training.epochs = 3;
  EXPECT_EQ(default_name(settings), "th40-single-1-epochs3");
  settings.rendering.denoise = heatmaps::Denoise::none;
  EXPECT_EQ(default_name(settings), "th40-single-1-denoise-none-epochs3");
  settings.training.learning_rate = 0.01;
  EXPECT_EQ(default_name(settings), "th40-single-1-denoise-none-epochs3-lr0.01");
  settings.training.batch = 16;
  EXPECT_TRUE(std::regex_match(default_name(settings), std::regex("th40-single-1-[0-9a-f]{8}"))) << default_name(settings);
  ModelSettings without;
  without.split = {.kind = windows::SplitKind::unseen, .train_run = "01", .held_out = {"fan"}};
  EXPECT_EQ(default_name(without), "th40-unseen-1-without-fan");
}

TEST(DefaultName, EndsWithAHashOfSettingsThatAreNoWord) {
  const std::regex hashed("th40-single-1-[0-9a-f]{8}");
  ModelSettings mask, other_mask, weights, from;
  mask.rendering.mask = {{1, 2}};
  other_mask.rendering.mask = {{2, 1}};
  weights.training.class_weights = class_weights_named("1,2,1");
  from.from = StartingPoint{"other", "abc"};
  for (const ModelSettings& settings : {mask, other_mask, weights, from})
    EXPECT_TRUE(std::regex_match(default_name(settings), hashed)) << default_name(settings);
  EXPECT_NE(default_name(mask), default_name(other_mask));
}

TEST(DefaultName, BeginsWithAKindOtherThanLeNet) {
  ModelSettings settings;
  settings.kind = ModelKind::stream;
  EXPECT_EQ(default_name(settings), "stream-single-1");
  settings.training.epochs = 3;  // has no meaning for a stream
  EXPECT_EQ(default_name(settings), "stream-single-1");
  settings.stream.steps = 300;
  EXPECT_EQ(default_name(settings), "stream-single-1-steps300");
}

/// Records of studies that began with version 0.1.0 have these names.
TEST(FullName, IsThatOfTheFirstVersion) {
  ModelSettings settings;
  EXPECT_EQ(full_name(settings), "th040-single-run-01-s1");
  settings.training.epochs = 1;
  settings.training.engine = EngineKind::libtorch;
  const std::regex hashed("th040-single-run-01-s1-[0-9a-f]{8}");
  EXPECT_TRUE(std::regex_match(full_name(settings), hashed)) << full_name(settings);
  ModelSettings unseen;
  unseen.kind = ModelKind::stream;
  unseen.split = {.kind = windows::SplitKind::unseen, .train_run = "03", .held_out = windows::default_held_out()};
  unseen.training.seed = 12;
  unseen.rendering.history = 2ms;
  EXPECT_EQ(full_name(unseen), "stream-th002-unseen-03-s12");
  ModelSettings between;
  between.rendering.history = 40'500us;
  between.rendering.tick = 500us;
  EXPECT_TRUE(std::regex_match(full_name(between), hashed)) << full_name(between);
}

TEST(ModelSettings, WithoutAKindAreOfLeNetAndStayAsTheyWere) {
  const nlohmann::json lenet = ModelSettings{};
  EXPECT_FALSE(lenet.at("network").contains("kind"));
  EXPECT_EQ(lenet.get<ModelSettings>().kind, ModelKind::lenet);
  ModelSettings stream;
  stream.kind = ModelKind::stream;
  stream.stream.steps = 70;
  stream.training.seed = 9;
  const auto read = nlohmann::json(stream).get<ModelSettings>();
  EXPECT_EQ(read.kind, ModelKind::stream);
  EXPECT_EQ(read.stream, stream.stream);
  EXPECT_EQ(read.training.seed, 9U);
  EXPECT_TRUE(same_settings(read, stream));
  EXPECT_FALSE(same_settings(read, {}));
}

TEST(DefaultName, DoesNotDependOnTheOrderOfHeldOutObjectsNorOnThemWhereNoneIsHeldOut) {
  ModelSettings settings;
  settings.split.held_out = {"fan"};
  EXPECT_EQ(default_name(settings), "th40-single-1");
  settings.split.kind = windows::SplitKind::unseen;
  settings.split.held_out = {"sprayer", "small-box", "fan", "plastic-container", "textured-box"};
  EXPECT_EQ(default_name(settings), "th40-unseen-1");
  settings.split.held_out = {"fan"};
  EXPECT_NE(default_name(settings), "th40-unseen-1");
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
