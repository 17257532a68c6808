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

TEST(TrainOptions, AreThoseOffTheirDefaults) {
  const auto words_of = [](const ModelSettings& settings) {
    std::string words;
    for (const OptionValue& option : train_options(settings)) words += option.name + " " + option.text + " ";
    return words;
  };
  EXPECT_EQ(words_of({}), "--th 40 ");
  ModelSettings settings;
  settings.split = {.kind = windows::SplitKind::unseen, .train_run = "02", .held_out = {"fan", "usb-hub"}};
  settings.rendering = {.history = 2'500us, .tick = 500us, .resize = heatmaps::Resize::linear};
  settings.network.pooling = Pooling::average;
  settings.training = {.seed = 7, .learning_rate = 0.0005, .augmentation = {.flip = true, .shift = true}, .early_stop = 3};
  EXPECT_EQ(words_of(settings),
            "--th 2.5 --split unseen --held-out fan,usb-hub --train-run 02 --resize linear --tick-us 500 --pool average --seed 7 "
            "--lr 0.0005 --augment flip,shift --early-stop 3 --validation 0 ");
  settings.training.validation_share = usual_validation_share;
  EXPECT_EQ(words_of(settings).find("--validation"), std::string::npos) << "that of an early stop";
  settings = {};
  settings.split = {.kind = windows::SplitKind::unseen, .held_out = windows::default_held_out()};
  settings.stream.steps = 80;
  EXPECT_EQ(words_of(settings), "--th 40 --split unseen ") << "a LeNet has no steps";
  ModelSettings stream;
  stream.kind = ModelKind::stream;
  stream.stream.steps = 80;
  stream.training.epochs = 3;
  stream.rendering.history = stream.rendering.tick = 1ms;
  EXPECT_EQ(words_of(stream), "--kind stream --tick-us 1000 --steps 80 ");
}

TEST(IdleOptions, HaveNoMeaningForTheKind) {
  ModelSettings lenet;
  lenet.training.learning_rate = 0.1;
  EXPECT_TRUE(idle_options(lenet).empty());
  lenet.stream.steps = 10;
  EXPECT_EQ(idle_options(lenet), std::vector<std::string>{"--steps"});
  ModelSettings stream;
  stream.kind = ModelKind::stream;
  stream.stream.steps = 10;
  stream.training.seed = 3;
  stream.rendering.history = stream.rendering.tick = 1ms;
  EXPECT_TRUE(idle_options(stream).empty());
  stream.training.epochs = 4;
  stream.training.validation_share = 0.1;
  stream.network.activation = Activation::tanh;
  stream.rendering.factor = 0.1;
  stream.from.emplace();
  EXPECT_EQ(idle_options(stream), (std::vector<std::string>{"--epochs", "--activation", "--factor", "--validation", "--from"}));
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
