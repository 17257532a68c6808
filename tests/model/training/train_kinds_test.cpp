#include <gtest/gtest.h>

#include "model/small_data.hpp"
#include "support/error_of.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/model/training/fit_stream.hpp"
#include "tactile/model/training/open_classifier.hpp"
#include "tactile/model/training/train_model.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile::model {
namespace {

using test::run_tactile;

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

TEST(TrainStream, RefusesWhatOnlyLeNetHas) {
  const test::TemporaryFolder folder;
  test::make_runs(folder / "data", {"fan", "usb-hub"}, 3);
  const auto trained = run_tactile("train --quiet --kind stream --steps 10 --name small", folder.path());
  ASSERT_EQ(trained.exit_code, 0) << trained.err;
  const std::filesystem::path small = folder / "models/small";
  const Classifier classifier(small, 1);
  EXPECT_NE(
      test::error_of([&] { classifier.classify(std::vector<std::uint8_t>(std::size_t{160} * 120)); }).find("reads no heatmaps"),
      std::string::npos);
  EXPECT_NE(test::error_of([&] {
              open_classifier(small, 1, EngineKind::libtorch);
            }).find("a model of kind stream runs without libtorch; expected --engine fast"),
            std::string::npos);
  EXPECT_NE(test::error_of([&] {
              Classifier(small, 1, EngineOptions{.precision = Precision::int8});
            }).find("a model of kind stream has no precision int8; expected fp32"),
            std::string::npos);
  EXPECT_NE(test::error_of([&] {
              classifier.on_events({320, 240}, classifier.rendering());
            }).find("events of a sensor of 320 x 240 px; expected the events of a sensor of 160 x 120 px"),
            std::string::npos);
  EXPECT_NE(test::error_of([&] {
              starting_point({small}, windows::Dataset(folder / "data/dataset.h5"), {});
            }).find("expected two of kind lenet"),
            std::string::npos);
  const auto error_of = [&](const std::string& options) {
    return run_tactile("train --kind stream " + options, folder.path()).err;
  };
  for (const std::string option : {"--epochs 3", "--lr 0.1", "--pool average", "--augment flip", "--denoise none",
                                   "--validation 0.1", "--engine libtorch", "--from small", "--class-weights balanced"}) {
    const std::string name = option.substr(0, option.find(' '));
    EXPECT_NE(error_of(option).find(name + ": a model of kind stream has none; expected --kind lenet"), std::string::npos)
        << option;
  }
  const auto exported = run_tactile("export --onnx small.onnx", folder.path());
  EXPECT_EQ(exported.exit_code, 0) << exported.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "small.json")) << "its description as a network of one's own";
  const auto weights = run_tactile("export --json --safetensors small.safetensors", folder.path());
  ASSERT_EQ(weights.exit_code, 0) << weights.err;
  EXPECT_EQ(read_weights(folder / "small.safetensors", stream_parameters()), read_bundle_weights({small}, classifier.model()));
}

TEST(TrainStream, RefusesABundleThatSomeoneChanged) {
  const test::TemporaryFolder folder;
  test::make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  const auto trained = run_tactile("train --quiet --kind stream --steps 10 --name small", folder.path());
  ASSERT_EQ(trained.exit_code, 0) << trained.err;
  const ModelBundle bundle{folder / "models/small"};
  const nlohmann::json whole = read_json(bundle.description());
  const auto error_with = [&](const std::function<void(nlohmann::json&)>& change) {
    nlohmann::json json = whole;
    change(json);
    write_json(bundle.description(), json);
    return test::error_of([&] { Classifier(bundle.folder, 1); });
  };
  EXPECT_NE(error_with([](auto& json) { json["network"]["parameters"] = 11; }).find("network.parameters is 11; expected "),
            std::string::npos);
  EXPECT_NE(
      error_with([](auto& json) { json["network"]["steps"] = 0; }).find("steps is 0; expected a whole number from 1 to 100000"),
      std::string::npos);
  EXPECT_NE(error_with([](auto& json) { json["network"]["kind"] = "forest"; }).find("kind of model 'forest' is unknown"),
            std::string::npos);
  EXPECT_NE(error_with([](auto& json) { json["weights_sha256"] = "0"; }).find("its hash differs"), std::string::npos);
}

}  // namespace
}  // namespace tactile::model
