#include <gtest/gtest.h>
#include <onnx/onnx_pb.h>

#include <algorithm>
#include <map>
#include <string>

#include "model/stream_data.hpp"
#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/model/training/lenet.hpp"

namespace tactile::model {
namespace {

namespace fs = std::filesystem;

constexpr events::SensorSize small{32, 24};

/// A folder with models/<name>: an untrained network for heatmaps of 32 x 24.
class Export : public testing::Test {
 protected:
  ModelBundle make_bundle(const std::string& name, std::uint64_t seed = 3, const std::string& trained_at = "2024-01-01T00:00:00Z",
                          const LeNetOptions& network = {}) const {
    ModelBundle bundle{folder / "models" / name};
    ModelDescription description;
    description.input = small;
    description.manifest_hash = "abc";
    description.simulated = true;
    description.trained_at = trained_at;
    description.settings.network = network;
    TrainingSummary summary;
    summary.history = {{1, 0.5, 0.9, {}, {}, 0.001, 2.5, 321.5, 1.0}};
    summary.best_epoch = 1;
    write_bundle(bundle, description, {LeNet(small, seed, network).weights(), {}}, summary);
    return bundle;
  }

  test::CommandResult run(const std::string& arguments) const { return test::run_tactile("export " + arguments, folder.path()); }

  onnx::ModelProto onnx_in(const std::string& file) const {
    onnx::ModelProto model;
    EXPECT_TRUE(model.ParseFromString(read_text(folder / file)));
    return model;
  }

  std::size_t files_beside_models() const {
    std::size_t count = 0;
    for (const auto& entry : fs::directory_iterator(folder.path())) count += entry.path().filename() == "models" ? 0 : 1;
    return count;
  }

  test::TemporaryFolder folder;
};

TEST_F(Export, WritesBothFormatsWithTheirMetadata) {
  const ModelBundle bundle = make_bundle("mine", 3, "2024-01-01T00:00:00Z", {Activation::tanh, Pooling::average});
  const auto result = run("--model mine --onnx out/model.onnx --safetensors out/model.safetensors --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const ModelDescription model = read_description(bundle);

  const auto metadata = read_metadata(folder / "out/model.safetensors");
  auto expected = weights_metadata(model);
  expected["model"] = "mine";
  expected["temperature"] = "1";
  EXPECT_EQ(metadata, expected);
  for (const char* key : {"split", "learned_from"}) EXPECT_TRUE(expected.contains(key)) << key;
  EXPECT_EQ(read_weights(folder / "out/model.safetensors", lenet_layers(small).parameters()), read_bundle_weights(bundle, model));

  std::map<std::string, std::string> of_onnx;
  const onnx::ModelProto onnx = onnx_in("out/model.onnx");
  for (const auto& entry : onnx.metadata_props()) of_onnx[entry.key()] = entry.value();
  EXPECT_EQ(nlohmann::json::parse(of_onnx.at("classes")), nlohmann::json::parse(R"(["none", "press", "slip"])"));
  EXPECT_EQ(nlohmann::json::parse(of_onnx.at("input")).at("shape"), nlohmann::json::parse("[1, 24, 32]"));
  EXPECT_EQ(nlohmann::json::parse(of_onnx.at("input")).at("scale").get<std::string>(), "heatmap / 255, in [0, 1]");
  EXPECT_EQ(nlohmann::json::parse(of_onnx.at("rendering")).get<heatmaps::HeatmapOptions>(), heatmaps::HeatmapOptions{});
  EXPECT_EQ(nlohmann::json::parse(of_onnx.at("network")).at("activation").get<std::string>(), "tanh");
  EXPECT_EQ(of_onnx.at("weights_sha256"), model.weights_sha256);
  EXPECT_EQ(onnx.graph().node(1).op_type(), "Tanh");
  EXPECT_EQ(onnx.graph().node(2).op_type(), "AveragePool");

  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("name").get<std::string>(), "mine");
  ASSERT_EQ(json.at("files").size(), 3U);
  for (const auto& file : json.at("files")) {
    const fs::path path = folder / file.at("file").get<std::string>();
    EXPECT_EQ(file.at("bytes").get<std::uint64_t>(), fs::file_size(path));
    EXPECT_EQ(file.at("sha256").get<std::string>(), sha256_of_file(path));
  }
  EXPECT_EQ(json.at("onnx").at("opset").get<int>(), 13);
  const OwnDescription described = read_own_description(folder / "out/model.onnx");
  EXPECT_EQ(described.input_shape(), (std::vector<std::int64_t>{1, 1, 24, 32}));
  EXPECT_EQ(described.rendering, heatmaps::HeatmapOptions{});
}

TEST_F(Export, WritesAStreamWithItsStates) {
  const ModelBundle bundle{folder / "models/mine"};
  ModelDescription description;
  description.settings.kind = ModelKind::stream;
  description.settings.rendering.history = description.settings.rendering.tick;
  description.input = {160, 120};
  description.learned_from = {{"fan/01", "abc", ""}};
  write_bundle(bundle, description, {test::stream_weights(), {}}, {});
  const auto result = run("--onnx m.onnx --safetensors m.safetensors --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("onnx").at("input").get<std::string>(), "counts");
  EXPECT_EQ(json.at("onnx").at("states").size(), 4U);
  EXPECT_EQ(read_weights(folder / "m.safetensors", stream_parameters()), test::stream_weights());
  const nlohmann::json beside = read_json(folder / "m.json");
  std::map<std::string, std::string> of_onnx;
  const onnx::ModelProto onnx = onnx_in("m.onnx");
  for (const auto& entry : onnx.metadata_props()) of_onnx[entry.key()] = entry.value();
  for (const char* key : {"input", "states", "grid"}) EXPECT_EQ(nlohmann::json::parse(of_onnx.at(key)), beside.at(key)) << key;
  const OwnDescription described = own_description_in(beside, "m.json");
  EXPECT_EQ(described.sensor, (events::SensorSize{160, 120}));
  EXPECT_EQ(described.grid, (std::array<double, 4>{0, 0, 160, 120}));
  EXPECT_EQ(described.learned_from.at(0).at("run").get<std::string>(), "fan/01");
}

TEST_F(Export, TakesTheModelTrainedLast) {
  make_bundle("a", 1, "2024-01-03T00:00:00Z");
  make_bundle("b", 2, "2024-01-02T00:00:00Z");
  const auto result = run("--safetensors w.safetensors --json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out).at("model").get<std::string>(), "models/a");
  EXPECT_EQ(read_weights(folder / "w.safetensors", lenet_layers(small).parameters()), LeNet(small, 1).weights());
  EXPECT_TRUE(nlohmann::json::parse(result.out).at("onnx").is_null());
}

TEST_F(Export, ReplacesOnlyByForce) {
  make_bundle("mine");
  write_whole(folder / "w.safetensors", "something dear");
  const auto refused = run("--onnx m.onnx --safetensors w.safetensors");
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("w.safetensors: exists already; expected a new name, or --force"), std::string::npos) << refused.err;
  EXPECT_EQ(read_text(folder / "w.safetensors"), "something dear");
  EXPECT_FALSE(fs::exists(folder / "m.onnx"));  // neither the one that could have been written

  ASSERT_EQ(run("--onnx m.onnx --safetensors w.safetensors --force").exit_code, 0);
  EXPECT_EQ(read_weights(folder / "w.safetensors", lenet_layers(small).parameters()), LeNet(small, 3).weights());
  const std::string before = read_text(folder / "m.onnx");
  ASSERT_EQ(run("--onnx m.onnx --force").exit_code, 0);
  EXPECT_EQ(read_text(folder / "m.onnx"), before);
  EXPECT_EQ(files_beside_models(), 3U);
}

TEST_F(Export, ReportsWhatIsWrong) {
  const auto expect_refused = [&](const std::string& arguments, const std::string& part) {
    const auto result = run(arguments);
    EXPECT_EQ(result.exit_code, 1) << arguments;
    EXPECT_NE(result.err.find(part), std::string::npos) << arguments << ": " << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_EQ(files_beside_models(), 0U) << arguments;
  };
  expect_refused("--onnx m.onnx", "run 'tactile train' first");
  const ModelBundle bundle = make_bundle("mine");
  expect_refused("", "no output is given; expected --onnx FILE, --safetensors FILE");
  expect_refused("--model yours --onnx m.onnx", "models/yours: no model");
  expect_refused("--model mine --onnx m --safetensors ./m", "m: is given for both formats");
  expect_refused("--model mine --onnx m.json", "m.json: is the file that says what the ONNX model reads");
  expect_refused("--model mine --onnx m.onnx --safetensors m.json", "expected another name");
  expect_refused("--model mine --onnx models", "models: is a folder");
  expect_refused("--model mine --onnx models/mine/model.json/m.onnx", "the folder cannot be created");
  write_weights(bundle.weights(), LeNet(small, 99).weights());
  expect_refused("--model mine --onnx m.onnx --quiet", "its hash differs from model.json");
}

TEST_F(Export, NeedsNoLibtorch) {
  const fs::path program = fs::path(test::tactile_binary).parent_path() / "tactile-all";
  make_bundle("mine");
  EXPECT_EQ(
      test::run_shell("LD_DEBUG=files '" + program.string() + "' export --onnx m.onnx 2>loaded.txt", folder.path()).exit_code, 0);
  const std::string loaded = test::text_in_file(folder / "loaded.txt");
  EXPECT_NE(loaded.find("libonnx_proto"), std::string::npos);
  EXPECT_EQ(loaded.find("libtorch"), std::string::npos);
  const auto libraries = test::run_shell("ldd '" + program.string() + "'");
  ASSERT_EQ(libraries.exit_code, 0);
  EXPECT_NE(libraries.out.find("libonnx_proto"), std::string::npos);
  EXPECT_EQ(libraries.out.find("libtorch"), std::string::npos);
}

}  // namespace
}  // namespace tactile::model
