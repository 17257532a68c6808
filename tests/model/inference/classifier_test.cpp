#include "tactile/model/inference/classifier.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "model/noise_heatmaps.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/model/training/lenet.hpp"
#include "tactile/model/training/open_classifier.hpp"

namespace tactile::model {
namespace {

/// A bundle of an untrained network for heatmaps of 32 x 24.
ModelBundle small_bundle(const test::TemporaryFolder& folder, const std::string& name = "small", std::uint64_t seed = 3,
                         const std::string& trained_at = "2024-01-01T00:00:00.000000Z") {
  ModelBundle bundle{folder / name};
  ModelDescription description;
  description.input = {32, 24};
  description.manifest_hash = "abc";
  description.trained_at = trained_at;
  description.settings.training.seed = seed;
  TrainingSummary summary;
  summary.history = {{1, 0.5, 0.9, {}, {}, 0.001, 2.5, 321.5, 1.0}, {2, 0.4, 0.95, 0.75, 0.5, 0.001, 2.5, 123.5, 1.0}};
  summary.best_epoch = 2;
  write_bundle(bundle, description, {LeNet({32, 24}, seed).weights(), {}}, summary);
  return bundle;
}

TEST(Classifier, FollowsEventsAsItClassifiesHeatmaps) {
  const test::TemporaryFolder folder;
  const ModelBundle bundle = small_bundle(folder);
  const events::SensorSize sensor{160, 120};
  std::vector<events::Event> events;
  events.reserve(3'000);
  for (int i = 0; i < 3'000; ++i)
    events.push_back(
        {CameraTime{microseconds{i * 30}}, static_cast<std::int16_t>(i * 37 % 160), static_cast<std::int16_t>(i * i % 120), 1});
  for (const EngineKind engine : {EngineKind::fast, EngineKind::libtorch}) {
    const Classifier classifier = open_classifier(bundle.folder, 1, engine);
    const auto model = classifier.on_events(sensor, classifier.rendering());
    heatmaps::HeatmapRenderer renderer(sensor, classifier.rendering());
    std::vector<std::uint8_t> heatmap(std::size_t{32} * 24);
    model->add(events), renderer.add(events);
    for (const std::int64_t ms : {40, 42, 60, 90}) {
      const CameraTime t{microseconds{1000 * ms}};
      model->move_to(t), renderer.move_to(t);
      model->prepare(), renderer.render(std::span(heatmap));
      EXPECT_EQ(model->classify(), classifier.classify(heatmap).front()) << ms;
      EXPECT_EQ(model->events(), renderer.events());
    }
    EXPECT_THROW(classifier.on_events({320, 240}, classifier.rendering()), Error);
  }
}

std::string error_of(const ModelBundle& bundle) {
  try {
    const Classifier classifier(bundle.folder, 1);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(Classifier, PredictsLikeTheWrittenNetwork) {
  const test::TemporaryFolder folder;
  const ModelBundle bundle = small_bundle(folder);
  const Classifier classifier(bundle.folder, 2);
  const auto noise = test::noise_heatmaps(40, {32, 24}, 1);
  const auto logits = LeNet({32, 24}, 3).logits(noise.heatmaps, 1);
  EXPECT_EQ(open_classifier(bundle.folder, 2, EngineKind::libtorch).classify(noise.heatmaps), logits);
  const auto own = classifier.classify(noise.heatmaps);
  ASSERT_EQ(own.size(), logits.size());
  for (std::size_t i = 0; i < logits.size(); ++i) {
    for (std::size_t k = 0; k < touch_count; ++k) EXPECT_NEAR(own[i][k], logits[i][k], 1e-6);
  }
  const auto verdicts = classifier.verdicts(noise.heatmaps);
  for (std::size_t i = 0; i < logits.size(); ++i) EXPECT_EQ(verdicts[i], verdict_of(logits[i]));
  EXPECT_EQ(classifier.input_size(), (events::SensorSize{32, 24}));
  EXPECT_EQ(classifier.rendering(), heatmaps::HeatmapOptions{});
  EXPECT_EQ(classifier.description().at("classes"), nlohmann::json::parse(R"(["none", "press", "slip"])"));
}

TEST(Classifier, RefusesAFolderWithoutAModel) {
  const test::TemporaryFolder folder;
  EXPECT_NE(error_of(ModelBundle{folder / "nothing"}).find("tactile train"), std::string::npos);
}

/// Replaces a bundle's weights, and their hash.
void write_weights_of(const ModelBundle& bundle, const Weights& weights) {
  write_weights(bundle.weights(), weights);
  nlohmann::json json = read_json(bundle.description());
  json["weights_sha256"] = sha256_of_file(bundle.weights());
  write_json(bundle.description(), json);
}

TEST(Classifier, RefusesWeightsThatTheHashDoesNotName) {
  const test::TemporaryFolder folder;
  const ModelBundle bundle = small_bundle(folder);
  std::string text = read_text(bundle.weights());
  text.back() = static_cast<char>(text.back() ^ 1);
  write_whole(bundle.weights(), text);
  EXPECT_NE(error_of(bundle).find("hash"), std::string::npos);
  std::filesystem::remove(bundle.weights());
  EXPECT_NE(error_of(bundle).find("missing"), std::string::npos);
}

TEST(Classifier, RefusesWeightsThatAreNotFinite) {
  const test::TemporaryFolder folder;
  const ModelBundle bundle = small_bundle(folder);
  Weights weights = LeNet({32, 24}, 3).weights();
  weights[4].values[7] = std::numeric_limits<float>::quiet_NaN();
  write_weights_of(bundle, weights);
  EXPECT_EQ(error_of(bundle), bundle.weights().string() + ": fc1.weight[0,7] is nan; expected finite weights");
}

TEST(Classifier, RefusesWeightsBeyondTheLargest) {
  const test::TemporaryFolder folder;
  const ModelBundle bundle = small_bundle(folder);
  Weights weights = LeNet({32, 24}, 3).weights();
  weights[4].values[7] = -largest_weight;
  write_weights_of(bundle, weights);
  EXPECT_EQ(error_of(bundle).find("expected finite"), std::string::npos) << error_of(bundle);
  weights[4].values[7] = -1e20F;
  write_weights_of(bundle, weights);
  EXPECT_EQ(error_of(bundle),
            bundle.weights().string() + ": fc1.weight[0,7] is -1e+20; expected finite weights of at most 1e+09");
}

TEST(Classifier, TakesDenormalWeightsForZero) {
  const test::TemporaryFolder folder;
  const ModelBundle bundle = small_bundle(folder);
  Weights tiny = LeNet({32, 24}, 3).weights();
  for (Parameter& parameter : tiny) {
    for (float& value : parameter.values) value *= 1e-38F;
  }
  write_weights_of(bundle, tiny);
  const std::vector<std::uint8_t> heatmaps = test::noise_heatmaps(3, {32, 24}, 1).heatmaps;
  for (const EngineKind engine : {EngineKind::fast, EngineKind::libtorch}) {
    for (const Logits& logits : open_classifier(bundle.folder, 1, engine).classify(heatmaps)) {
      for (const float logit : logits) EXPECT_EQ(logit, 0) << name_of(engine);
    }
  }
}

TEST(Classifier, GivesNoVerdictOfWeightsWhoseSumsLeaveFloat32) {
  const test::TemporaryFolder folder;
  const ModelBundle bundle = small_bundle(folder);
  Weights weights = LeNet({32, 24}, 3).weights();
  for (Parameter& parameter : weights) {
    for (float& value : parameter.values) value *= 1e9F;
  }
  write_weights_of(bundle, weights);
  EXPECT_NE(error_of(bundle).find("so large that sums may exceed float32"), std::string::npos) << error_of(bundle);
  const Classifier libtorch = open_classifier(bundle.folder, 1, EngineKind::libtorch);
  const auto noise = test::noise_heatmaps(3, {32, 24}, 1);
  try {
    libtorch.verdicts(noise.heatmaps);
    ADD_FAILURE() << "a verdict of infinite sums";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find(bundle.folder.string() + ": the logits of heatmap 1 of 3 are "), std::string::npos)
        << e.what();
  }
}

TEST(Classifier, RefusesADescriptionOfAnotherNetworkThanThatOfItsWeights) {
  const test::TemporaryFolder folder;
  const ModelBundle bundle = small_bundle(folder);
  const nlohmann::json whole = read_json(bundle.description());
  struct Case {
    const char* member;
    nlohmann::json value;
    std::string message;
  };
  const std::vector<Case> cases{{"/input/channels", 7, "network.input.channels is 7; expected 1"},
                                {"/layers/0", "conv 6@3x3", "network.layers.0 is \"conv 6@3x3\"; expected \"conv 6@5x5\""},
                                {"/layers/12", "linear 3", "network.layers.12 is \"linear 3\"; expected null"},
                                {"/layers", nlohmann::json::array(), "network.layers.0 is null; expected \"conv 6@5x5\""},
                                {"/name", "vgg", "network.name is \"vgg\"; expected \"lenet-5\""}};
  for (const Case& one : cases) {
    nlohmann::json json = whole;
    json["network"][nlohmann::json::json_pointer(one.member)] = one.value;
    write_json(bundle.description(), json);
    EXPECT_EQ(error_of(bundle), bundle.folder.string() + ": model.json: " + one.message + ", as in the network of its weights");
  }
  nlohmann::json older = whole;
  older["network"].erase("layers");
  older["network"]["input"].erase("channels");
  write_json(bundle.description(), older);
  EXPECT_EQ(error_of(bundle), "");
}

TEST(Classifier, RefusesAnInputSizeThatTheWeightsAreNotOf) {
  const test::TemporaryFolder folder;
  const ModelBundle bundle = small_bundle(folder);
  nlohmann::json json = read_json(bundle.description());
  json["network"]["input"]["width"] = 48;
  write_json(bundle.description(), json);
  EXPECT_NE(error_of(bundle), "");
  json["network"]["input"]["width"] = 2'000'000'000;
  write_json(bundle.description(), json);
  EXPECT_NE(error_of(bundle), "");
}

TEST(Classifier, RefusesAnotherFormatAndMissingKeys) {
  const test::TemporaryFolder folder;
  const ModelBundle bundle = small_bundle(folder);
  const nlohmann::json whole = read_json(bundle.description());
  nlohmann::json json = whole;
  json["format"] = 99;
  write_json(bundle.description(), json);
  EXPECT_NE(error_of(bundle).find("format 99"), std::string::npos);
  for (const char* key : {"rendering", "split", "training", "classes", "network", "dataset", "weights_sha256"}) {
    json = whole;
    json.erase(key);
    write_json(bundle.description(), json);
    EXPECT_NE(error_of(bundle).find(key), std::string::npos) << key;
  }
}

TEST(ModelBundle, ReplacesTheOneThatWasThereWhole) {
  const test::TemporaryFolder folder;
  const ModelBundle bundle = small_bundle(folder);
  write_whole(bundle.evaluation(), "{}");
  small_bundle(folder, "small", 4);
  EXPECT_EQ(read_bundle_weights(bundle, read_description(bundle)), LeNet({32, 24}, 4).weights());
  EXPECT_FALSE(std::filesystem::exists(bundle.evaluation()));
  std::size_t entries = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder.path())) ++entries;
  EXPECT_EQ(entries, 1U);
}

TEST(ModelBundle, KeepsTheHistory) {
  const test::TemporaryFolder folder;
  const ModelBundle bundle = small_bundle(folder);
  EXPECT_EQ(read_text(bundle.history()),
            "epoch,loss,accuracy,validation_loss,validation_accuracy,learning_rate,gradient_norm,images_per_s,seconds\n"
            "1,0.5,0.9,,,0.001,2.5,321.5,1.000\n2,0.4,0.95,0.75,0.5,0.001,2.5,123.5,1.000\n");
  const auto history = read_history(bundle.history());
  ASSERT_EQ(history.size(), 2U);
  EXPECT_EQ(history[0].validation_loss, std::nullopt);
  EXPECT_EQ(history[1].validation_loss, 0.75);
  EXPECT_EQ(history[1].validation_accuracy, 0.5);
  EXPECT_EQ(history[1].gradient_norm, 2.5);
  EXPECT_EQ(history[1].images_per_s, 123.5);
}

TEST(ModelBundle, ThatNoTrainingWritesIsRefusedAsItIsLoaded) {
  const test::TemporaryFolder folder;
  const ModelBundle bundle = small_bundle(folder);
  const auto whole = read_json(bundle.description());
  const std::vector<std::tuple<std::string, nlohmann::json, std::string>> cases{
      {"/rendering/factor", 0, "model.json: heatmap settings: factor is 0; expected 0.001 to 1"},
      {"/rendering/tick_us", -5, "model.json: heatmap settings: tick_us is -5; expected"},
      {"/rendering/history_us", 1'000'000'000'000'000, "model.json: heatmap settings: history_us is 1000000000000000; expected"},
      {"/network/input/width", 0, "model.json: network.input: 0 x "},
      {"/network/input/height", 40'000, "x 40000; expected"},
      {"/training/epochs", 0, "model.json: training settings: epochs is 0; expected"},
      {"/training/batch", 0, "model.json: training settings: batch is 0; expected"},
      {"/threads", 0, "model.json: threads: 0; expected at least 1"},
      {"/rendering", nlohmann::json::array({1}), "model.json: 'rendering' is a list; expected an object"},
      {"/split", nullptr, "model.json: 'split' is null; expected an object"},
      {"/scene", 5, "model.json: 'scene' is a number; expected an object"},
      {"/learned_from", {"fan/01"}, "model.json: an entry of 'learned_from' is a text; expected an object"}};
  for (const auto& [member, value, sentence] : cases) {
    nlohmann::json json = whole;
    const nlohmann::json::json_pointer place(member);
    ASSERT_TRUE(json.contains(place)) << member;
    json[place] = value;
    write_json(bundle.description(), json);
    try {
      read_description(bundle);
      ADD_FAILURE() << member << ": no error";
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find(sentence), std::string::npos) << e.what();
      EXPECT_NE(std::string(e.what()).find(bundle.folder.string()), std::string::npos) << e.what();
    }
  }
  write_json(bundle.description(), whole);
  EXPECT_NO_THROW(read_description(bundle));
}

TEST(NewestBundle, IsTheLastTrainedOfTheAcceptedOnes) {
  const test::TemporaryFolder folder;
  small_bundle(folder, "a", 1, "2024-01-02T00:00:00.000000Z");
  small_bundle(folder, "b", 2, "2024-01-03T00:00:00.000000Z");
  small_bundle(folder, "c", 3, "2024-01-01T00:00:00.000000Z");
  write_whole(folder / "damaged/model.json", "{");
  const auto any = [](const ModelDescription&) { return true; };
  EXPECT_EQ(newest_bundle(folder.path(), any)->name(), "b");
  EXPECT_EQ(newest_bundle(folder.path(), [](const ModelDescription& m) { return m.settings.training.seed != 2; })->name(), "a");
  EXPECT_FALSE(newest_bundle(folder.path(), [](const ModelDescription& m) { return m.manifest_hash != "abc"; }).has_value());
  EXPECT_FALSE(newest_bundle(folder / "missing", any).has_value());
}

}  // namespace
}  // namespace tactile::model
