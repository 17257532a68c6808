#include <gtest/gtest.h>

#include "model/small_data.hpp"
#include "support/error_of.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/features/step_features.hpp"
#include "tactile/model/training/calibrate_model.hpp"
#include "tactile/model/training/dataset_bundle.hpp"
#include "tactile/model/training/fit_stream.hpp"
#include "tactile/model/training/fit_temporal.hpp"
#include "tactile/model/training/fit_trees.hpp"
#include "tactile/model/training/open_classifier.hpp"
#include "tactile/model/training/sample_features.hpp"
#include "tactile/model/training/sample_logits.hpp"
#include "tactile/model/training/train_model.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile::model {
namespace {

using test::run_tactile;

/// A data folder of small runs, its dataset, and trees that learned from it.
struct TrainedTrees {
  test::TemporaryFolder folder;
  std::filesystem::path file = folder / "data/dataset.h5";
  ModelBundle bundle{folder / "models/trees"};
  ModelSettings settings;
  TrainingSummary summary;

  TrainedTrees() {
    test::make_runs(folder / "data", {"fan", "usb-hub"}, 2);
    windows::write_dataset(folder / "data", file, {}, 2);
    settings.kind = ModelKind::trees;
    settings.trees = {.rounds = 12, .depth = 3};
    settings.training.seed = 5;
    summary = train_model(windows::Dataset(file), settings, bundle);
  }
};

TEST(TrainTrees, WritesTheTreesThatFitTheSamples) {
  const TrainedTrees trained;
  const windows::Dataset dataset(trained.file);
  const ModelDescription model = read_description(trained.bundle);
  EXPECT_EQ(model.settings.kind, ModelKind::trees);
  EXPECT_EQ(model.settings.trees, (TreesOptions{.rounds = 12, .depth = 3}));
  EXPECT_EQ(model.input, test::small_sensor);
  EXPECT_TRUE(model.gate);
  EXPECT_TRUE(model.transitions);
  EXPECT_EQ(state_of(trained.bundle, dataset, trained.settings), BundleState::unchanged);
  ModelSettings other = trained.settings;
  other.trees.rounds = 13;
  EXPECT_EQ(state_of(trained.bundle, dataset, other), BundleState::changed);
  EXPECT_FALSE(std::filesystem::exists(CheckpointFolder::beside(trained.bundle.folder)));

  const auto samples = samples_of_runs(dataset, split_of(dataset, {}).train_runs);
  std::vector<float> features;
  std::vector<Touch> truth;
  truth.reserve(samples.size());
  for (const std::uint32_t run : split_of(dataset, {}).train_runs) {
    const auto of_run = samples_of_runs(dataset, {&run, 1});
    const auto more = sample_features(dataset, run, of_run, {});
    features.insert(features.end(), more.begin(), more.end());
  }
  for (const std::uint32_t sample : samples) truth.push_back(dataset.samples()[sample].touch);
  const BoostedTrees trees = fit_trees(features, truth, trained.settings.trees, 5);
  EXPECT_EQ(read_bundle_weights(trained.bundle, model), trees.weights());

  const Classifier classifier(trained.bundle.folder, 1);
  const auto logits = sample_logits(dataset, classifier, samples, 1);
  ASSERT_EQ(logits.size(), samples.size());
  std::size_t right = 0;
  for (std::size_t i = 0; i < logits.size(); ++i) {
    ASSERT_EQ(logits[i], trees.logits(std::span(features).subspan(i * trees.features(), trees.features()))) << i;
    right += verdict_of(logits[i]) == truth[i] ? 1 : 0;
  }
  ASSERT_EQ(trained.summary.history.size(), 1U);
  EXPECT_EQ(trained.summary.history.front().accuracy, static_cast<double>(right) / static_cast<double>(logits.size()));
  EXPECT_EQ(trained.summary.history.front().loss, loss_at(logits, truth, 1));
  EXPECT_GT(trained.summary.history.front().accuracy, 0.95);
}

TEST(TrainTrees, RefuseWhatOnlyANetworkHas) {
  const TrainedTrees trained;
  const windows::Dataset dataset(trained.file);
  const Classifier classifier(trained.bundle.folder, 1);
  EXPECT_NE(
      test::error_of([&] { classifier.classify(std::vector<std::uint8_t>(std::size_t{160} * 120)); }).find("reads no heatmaps"),
      std::string::npos);
  EXPECT_NE(test::error_of([&] {
              open_classifier(trained.bundle.folder, 1, EngineKind::libtorch);
            }).find("a model of kind trees runs without libtorch; expected --engine fast"),
            std::string::npos);
  EXPECT_NE(test::error_of([&] {
              Classifier(trained.bundle.folder, 1, EngineOptions{.precision = Precision::int8});
            }).find("a model of kind trees has no precision int8; expected fp32"),
            std::string::npos);
  EXPECT_NE(test::error_of([&] {
              classifier.on_events({320, 240}, classifier.rendering());
            }).find("events of a sensor of 320 x 240 px; expected the events of a sensor of 160 x 120 px"),
            std::string::npos);
  EXPECT_NE(test::error_of([&] {
              classifier.on_events(test::small_sensor, {.history = 50ms, .tick = 3us});
            }).find("has no features; expected a multiple of 4 us"),
            std::string::npos);
  EXPECT_NE(test::error_of([&] { starting_point(trained.bundle, dataset, {}); }).find("expected two of kind lenet"),
            std::string::npos);
}

TEST(TrainTrees, RefuseABundleThatSomeoneChanged) {
  const TrainedTrees trained;
  const nlohmann::json whole = read_json(trained.bundle.description());
  const auto error_with = [&](const std::function<void(nlohmann::json&)>& change) {
    nlohmann::json json = whole;
    change(json);
    write_json(trained.bundle.description(), json);
    return test::error_of([&] { Classifier(trained.bundle.folder, 1); });
  };
  EXPECT_NO_THROW(Classifier(trained.bundle.folder, 1));
  EXPECT_NE(error_with([](auto& json) { json["network"]["input"]["features"] = 85; }).find("reads 85 features; expected 84"),
            std::string::npos);
  EXPECT_NE(error_with([](auto& json) { json["network"]["rounds"] = 11; }).find("network.parameters is 792; expected 726"),
            std::string::npos);
  EXPECT_NE(error_with([](auto& json) { json["network"]["depth"] = 9; }).find("expected 1 to 10000, 1 to 8"), std::string::npos);
  EXPECT_NE(error_with([](auto& json) { json["network"]["kind"] = "forest"; }).find("kind of model 'forest' is unknown"),
            std::string::npos);
  EXPECT_NE(error_with([](auto& json) { json["weights_sha256"] = "0"; }).find("its hash differs"), std::string::npos);
}

TEST(TrainTemporal, WritesTheNetworkThatFitsTheSamples) {
  const TrainedTrees trained;  // for its dataset
  const windows::Dataset dataset(trained.file);
  const ModelBundle bundle{trained.folder / "models/temporal"};
  ModelSettings settings;
  settings.kind = ModelKind::temporal;
  settings.temporal.channels = 16;
  settings.training.seed = 5;
  settings.training.epochs = 40;
  const TrainingSummary summary = train_model(dataset, settings, bundle);
  ASSERT_EQ(summary.history.size(), 40U);
  EXPECT_GT(summary.history.back().accuracy, 0.9);
  const ModelDescription model = read_description(bundle);
  EXPECT_EQ(model.settings.kind, ModelKind::temporal);
  EXPECT_EQ(model.settings.temporal.channels, 16U);
  EXPECT_EQ(model.settings.training, settings.training);
  EXPECT_EQ(model.epoch, 40U);
  EXPECT_EQ(state_of(bundle, dataset, settings), BundleState::unchanged);

  const auto samples = samples_of_runs(dataset, split_of(dataset, {}).train_runs);
  std::vector<float> steps;
  std::vector<Touch> truth;
  truth.reserve(samples.size());
  for (const std::uint32_t run : split_of(dataset, {}).train_runs) {
    const auto more = sample_steps(dataset, run, samples_of_runs(dataset, {&run, 1}), {});
    steps.insert(steps.end(), more.begin(), more.end());
  }
  for (const std::uint32_t sample : samples) truth.push_back(dataset.samples()[sample].touch);
  EXPECT_EQ(read_bundle_weights(bundle, model), fit_temporal(steps, truth, settings.temporal, settings.training).weights);
  const Classifier classifier(bundle.folder, 1);
  const auto logits = sample_logits(dataset, classifier, samples, 1);
  const TemporalNetwork network(settings.temporal, read_bundle_weights(bundle, model));
  for (std::size_t i = 0; i < samples.size(); ++i)
    ASSERT_EQ(logits[i], network.logits(std::span(steps).subspan(i * features::step_values, features::step_values))) << i;

  settings.rendering.history = 20ms;
  EXPECT_NE(test::error_of([&] {
              train_model(dataset, settings, {trained.folder / "models/short"});
            }).find("expected one longer than 15 steps"),
            std::string::npos);
  nlohmann::json json = read_json(bundle.description());
  json["network"]["input"]["steps"] = 15;
  write_json(bundle.description(), json);
  EXPECT_NE(test::error_of([&] { Classifier(bundle.folder, 1); }).find("reads 15 x 12 features; expected 16 x 12"),
            std::string::npos);
}

TEST(TrainCommand, TrainsAStream) {
  const test::TemporaryFolder folder;
  test::make_runs(folder / "data", {"fan", "usb-hub"}, 3);
  const auto trained = run_tactile("train --json --kind stream --steps 110 --calibrate 02", folder.path());
  ASSERT_EQ(trained.exit_code, 0) << trained.err;
  const auto json = nlohmann::json::parse(trained.out);
  EXPECT_EQ(json.at("name"), "stream-single-1-steps110");
  EXPECT_EQ(json.at("settings").at("network"), nlohmann::json::parse(R"({"kind": "stream", "steps": 110})"));
  EXPECT_EQ(json.at("settings").at("training"), nlohmann::json::parse(R"({"seed": 1, "from": null})"));
  EXPECT_EQ(json.at("settings").at("rendering").at("history_us"), 2'000);
  EXPECT_EQ(json.at("history").size(), 2U);
  EXPECT_GT(json.at("temperature").at("value").get<double>(), 0);
  const ModelBundle bundle{folder / "models/stream-single-1-steps110"};
  const windows::Dataset dataset(folder / "data/dataset.h5");
  const ModelDescription model = read_description(bundle);
  EXPECT_EQ(model.train_runs, (std::vector<std::string>{"fan/01", "usb-hub/01"}));

  // The same weights as those of the whole runs, read and fitted by themselves.
  const std::vector<std::uint32_t> runs = split_of(dataset, {}).train_runs;
  const StreamGrid grid = grid_of_runs(dataset, runs, {});
  const std::vector<StreamRun> whole = stream_runs(dataset, runs, grid, model.settings.rendering, 1);
  std::uint64_t ticks = 0;
  for (const StreamRun& run : whole) ticks += run.ticks;
  EXPECT_EQ(model.samples, ticks);
  EXPECT_EQ(read_bundle_weights(bundle, model), fit_stream(whole, grid, {.steps = 110}).weights);

  const Classifier classifier(bundle.folder, 1);
  EXPECT_NE(test::error_of([&] {
              classifier.on_events(dataset.sensor(), {.history = 2ms, .tick = 1ms});
            }).find("a tick of 1000 us; expected the 2000 us"),
            std::string::npos);
  nlohmann::json changed = read_json(bundle.description());
  changed["network"]["input"]["places"] = 10;
  write_json(bundle.description(), changed);
  EXPECT_NE(test::error_of([&] { Classifier(bundle.folder, 1); }).find("reads 10 x 145 features; expected 9 x 145"),
            std::string::npos);
  const auto error_of = [&](const std::string& options) { return run_tactile("train " + options, folder.path()).err; };
  EXPECT_NE(error_of("--kind stream --epochs 3").find("--epochs: a model of kind stream has none; expected --kind lenet"),
            std::string::npos);
  EXPECT_NE(error_of("--steps 3").find("--steps: a model of kind lenet has none; expected --kind stream"), std::string::npos);
}

TEST(StreamRuns, WeighEachTickByWhatTheLabelsSay) {
  const test::TemporaryFolder folder;
  test::make_runs(folder / "data", {"fan"}, 2);
  const std::filesystem::path file = folder / "data/dataset.h5";
  windows::write_dataset(folder / "data", file, {}, 2);
  const windows::Dataset dataset(file);
  const std::uint32_t index = 0;
  const StreamRun run = stream_runs(dataset, {&index, 1}, grid_of_runs(dataset, {&index, 1}, {}), {.history = 2ms}, 1).front();
  EXPECT_EQ(run.name, "fan/01");
  ASSERT_EQ(run.truth.size(), run.ticks);
  EXPECT_EQ(run.counts.size(), run.ticks * StreamImage::size);
  ASSERT_EQ(run.touches.size(), 2U);
  for (const TickSpan& touch : run.touches) {
    EXPECT_EQ(run.truth[touch.begin], touch.touch);
    EXPECT_NE(run.truth[touch.begin - 1], touch.touch);
    EXPECT_EQ(run.weights[touch.begin], 3) << "the first 40 ms";
    EXPECT_EQ(run.weights[touch.begin + 19], 3);
    EXPECT_EQ(run.weights[touch.begin + 20], 1);
    EXPECT_EQ(run.weights[touch.end - 1], 0) << "near its end";
    EXPECT_EQ(run.weights[touch.end + 20], 0);
    EXPECT_EQ(run.weights[touch.begin - 5], 1);
  }
}

TEST(TrainCommand, TrainsATemporalConvolution) {
  const test::TemporaryFolder folder;
  test::make_runs(folder / "data", {"fan", "usb-hub"}, 3);
  const auto trained = run_tactile("train --json --kind temporal --epochs 3 --calibrate 02", folder.path());
  ASSERT_EQ(trained.exit_code, 0) << trained.err;
  EXPECT_NE(trained.err.find("samples, 3 epochs"), std::string::npos) << trained.err;
  const auto json = nlohmann::json::parse(trained.out);
  EXPECT_EQ(json.at("name"), "temporal-th40-single-1-epochs3");
  EXPECT_EQ(json.at("settings").at("network"), nlohmann::json::parse(R"({"kind": "temporal", "channels": 32})"));
  EXPECT_FALSE(json.at("settings").at("training").contains("augment"));
  EXPECT_EQ(json.at("history").size(), 3U);
  EXPECT_GT(json.at("temperature").at("value").get<double>(), 0);
  const auto error_of = [&](const std::string& options) { return run_tactile("train " + options, folder.path()).err; };
  EXPECT_NE(error_of("--kind temporal --validation 0.1").find("--validation: a model of kind temporal has none"),
            std::string::npos);
  EXPECT_NE(error_of("--kind temporal --rounds 3").find("--rounds: a model of kind temporal has none; expected --kind trees"),
            std::string::npos);
  EXPECT_NE(error_of("--channels 3").find("--channels: a model of kind lenet has none; expected --kind temporal"),
            std::string::npos);
}

TEST(TrainCommand, TrainsTreesAndRefusesOptionsWithoutMeaning) {
  const test::TemporaryFolder folder;
  test::make_runs(folder / "data", {"fan", "usb-hub"}, 3);
  const auto trained = run_tactile("train --json --kind trees --rounds 5 --depth 2 --calibrate 02", folder.path());
  ASSERT_EQ(trained.exit_code, 0) << trained.err;
  EXPECT_NE(trained.err.find("samples, 5 rounds of trees"), std::string::npos) << trained.err;
  const auto json = nlohmann::json::parse(trained.out);
  EXPECT_EQ(json.at("name"), "trees-th40-single-1-depth2-rounds5");
  EXPECT_EQ(json.at("settings").at("network"),
            nlohmann::json::parse(R"({"kind": "trees", "rounds": 5, "depth": 2, "learning_rate": 0.1})"));
  EXPECT_EQ(json.at("settings").at("training"), nlohmann::json::parse(R"({"seed": 1, "from": null})"));
  EXPECT_GT(json.at("temperature").at("value").get<double>(), 0);
  EXPECT_LE(json.at("temperature").at("loss_after"), json.at("temperature").at("loss_before"));
  const auto again = run_tactile("train --json --kind trees --rounds 5 --depth 2", folder.path());
  EXPECT_EQ(nlohmann::json::parse(again.out).at("outcome"), "unchanged") << again.err;
  const auto usual = run_tactile("train --json --kind trees", folder.path());
  EXPECT_EQ(nlohmann::json::parse(usual.out).at("name"), "trees-th40-single-1");

  const auto error_of = [&](const std::string& options) { return run_tactile("train " + options, folder.path()).err; };
  for (const std::string option :
       {"--epochs 3", "--lr 0.1", "--width 0.5", "--augment flip", "--denoise none", "--validation 0.1", "--engine libtorch",
        "--from trees-th40-single-1", "--class-weights balanced"}) {
    const std::string name = option.substr(0, option.find(' '));
    EXPECT_NE(error_of("--kind trees " + option).find(name + ": a model of kind trees has none; expected --kind lenet"),
              std::string::npos)
        << option;
  }
  EXPECT_NE(error_of("--rounds 3").find("--rounds: a model of kind lenet has none; expected --kind trees"), std::string::npos);

  const auto exported = run_tactile("export --onnx trees.onnx", folder.path());
  EXPECT_EQ(exported.exit_code, 1);
  EXPECT_NE(exported.err.find("is of kind trees, which reads features of events"), std::string::npos) << exported.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "trees.onnx"));
  const auto weights = run_tactile("export --json --safetensors trees.safetensors", folder.path());
  ASSERT_EQ(weights.exit_code, 0) << weights.err;
  const std::string name = nlohmann::json::parse(weights.out).at("name");
  EXPECT_EQ(read_weights(folder / "trees.safetensors", tree_parameters({})),
            read_bundle_weights({folder / "models" / name}, read_description({folder / "models" / name})));
}

}  // namespace
}  // namespace tactile::model
