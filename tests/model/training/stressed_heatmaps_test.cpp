#include "tactile/model/training/stressed_heatmaps.hpp"

#include <gtest/gtest.h>

#include <map>

#include "model/small_data.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/heatmaps/render_samples.hpp"
#include "tactile/model/training/train_model.hpp"
#include "tactile/recipes/recipe_stream.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile::model {
namespace {

using test::make_runs;

TEST(DrawnStress, LeavesHalfOfTheRunsAndDrawsSeveritiesUpToTheGivenOne) {
  const std::vector recipes{recipes::parse_recipe("loss:60"), recipes::parse_recipe("mirror-x:1")};
  std::map<std::string, int> counts;
  double sum = 0;
  for (unsigned epoch = 1; epoch <= 4000; ++epoch) {
    const auto drawn = drawn_stress(recipes, 1, epoch, "fan/01");
    ++counts[drawn ? drawn->name : "none"];
    if (drawn && drawn->name == "loss") {
      EXPECT_GT(drawn->severity, 0);
      EXPECT_LE(drawn->severity, 60);
      sum += drawn->severity;
    } else if (drawn) {
      EXPECT_EQ(drawn->severity, 1) << "only whole ones";
    }
  }
  EXPECT_NEAR(counts["none"], 2000, 130);
  EXPECT_NEAR(counts["loss"], 1000, 120);
  EXPECT_NEAR(sum / counts["loss"], 30, 2.5);
  EXPECT_EQ(drawn_stress(recipes, 1, 3, "fan/01"), drawn_stress(recipes, 1, 3, "fan/01"));
  EXPECT_FALSE(drawn_stress({}, 1, 3, "fan/01"));
}

TEST(StressedHeatmaps, AreRenderedFromTheWorsenedEventsAndTheOthersAreKept) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan", "usb-hub"}, 1);
  windows::write_dataset(folder / "data", folder / "data/dataset.h5", {}, 1);
  const windows::Dataset dataset(folder / "data/dataset.h5");
  ModelSettings settings;
  settings.training.augmentation = augmentation_named("stress:late:50,stress:noise:200,stress:jitter:5000");
  const std::vector<std::uint32_t> samples = samples_of_runs(dataset, std::vector<std::uint32_t>{0, 1});
  const auto clean = heatmaps::render_samples(dataset, settings.rendering, samples, 1);
  StressedHeatmaps stressed(dataset, settings, samples, clean, 2);
  const std::size_t length = clean.size() / samples.size();
  int changed = 0;
  for (unsigned epoch = 1; epoch <= 6; ++epoch) {
    const auto ours = stressed.of_epoch(epoch);
    ASSERT_EQ(ours.size(), clean.size());
    for (std::uint32_t run = 0; run < 2; ++run) {
      const auto recipe = drawn_stress(settings.training.augmentation.stress, 1, epoch, windows::name_of(dataset.runs()[run]));
      // Slowly: all worsened events of the run, and a new renderer for each sample.
      const auto events = recipe ? recipes::worsened(dataset.events(run), {&*recipe, 1}, dataset.sensor()) : dataset.events(run);
      changed += recipe ? 1 : 0;
      for (std::size_t i = 0; i < samples.size(); ++i) {
        const windows::Sample& sample = dataset.samples()[samples[i]];
        if (sample.run_index != run) continue;
        heatmaps::HeatmapRenderer renderer(dataset.sensor(), settings.rendering);
        renderer.add(events);
        renderer.move_to(sample.t);
        std::vector<std::uint8_t> expected(length);
        renderer.render(expected);
        ASSERT_TRUE(std::ranges::equal(ours.subspan(i * length, length), expected)) << "epoch " << epoch << ", sample " << i;
      }
    }
  }
  EXPECT_GT(changed, 0);
}

TEST(TrainModel, UnderStressGivesTheSameWeightsWhenItIsInterruptedAndResumed) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  windows::write_dataset(folder / "data", folder / "data/dataset.h5", {}, 1);
  const windows::Dataset dataset(folder / "data/dataset.h5");
  for (const EngineKind engine : {EngineKind::fast, EngineKind::libtorch}) {
    ModelSettings settings;
    settings.training.epochs = 4;
    settings.training.batch = 8;
    settings.training.engine = engine;
    settings.training.augmentation = augmentation_named("flip,stress:noise:200,stress:loss:60");
    const auto name = std::string(name_of(engine));
    const ModelBundle whole{folder / (name + "-whole")}, parted{folder / (name + "-parted")}, plain{folder / (name + "-plain")};
    train_model(dataset, settings, whole, {.threads = 1});
    int batches = 0;
    EXPECT_THROW(train_model(dataset, settings, parted, {.threads = 1, .save_every = std::chrono::seconds{0}},
                             [&](const Progress& progress) {
                               if (progress.what.starts_with("epoch 3") && ++batches == 2) throw Error("interrupted");
                             }),
                 Error);
    train_model(dataset, settings, parted, {.threads = 1, .resume = true});
    EXPECT_EQ(read_description(parted).weights_sha256, read_description(whole).weights_sha256) << name;
    settings.training.augmentation.stress.clear();
    train_model(dataset, settings, plain, {.threads = 1});
    EXPECT_NE(read_description(plain).weights_sha256, read_description(whole).weights_sha256) << name;
  }
}

TEST(Augmentation, WithStressIsKeptInTheSettings) {
  ModelSettings settings;
  settings.training.augmentation = augmentation_named("stress:noise,shift,stress:vibration:2:hz=120");
  EXPECT_EQ(text_of(settings.training.augmentation), "shift,stress:noise:200,stress:vibration:2:hz=120");
  const auto back = nlohmann::json(settings).get<ModelSettings>();
  EXPECT_EQ(back.training, settings.training);
  EXPECT_NE(default_name(settings), default_name({}));
  for (const char* wrong : {"stress", "stress:", "stress:nose:3", "stress:loss:200"})
    EXPECT_THROW(augmentation_named(wrong), Error) << wrong;
}

TEST(TrainCommand, TakesStressAndNamesTheNearestRecipe) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  const auto result =
      test::run_tactile("train --json --epochs 1 --threads 1 --augment flip,stress:loss:50,stress:hot-pixels", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("settings").at("training").at("augment"), "flip,stress:loss:50,stress:hot-pixels:100");
  const auto refused = test::run_tactile("train --augment stress:nose", folder.path());
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_NE(refused.err.find("'noise'"), std::string::npos) << refused.err;
}

}  // namespace
}  // namespace tactile::model
