#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <utility>

#include "model/small_data.hpp"
#include "support/error_of.hpp"
#include "support/run_command.hpp"
#include "support/settings_file.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/heatmaps/store_heatmaps.hpp"
#include "tactile/model/training/dataset_bundle.hpp"
#include "tactile/model/training/open_classifier.hpp"
#include "tactile/model/training/train_model.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile::model {
namespace {

using test::make_runs;
using test::run_tactile;

nlohmann::json trained(const std::string& arguments, const std::filesystem::path& in) {
  const auto result = run_tactile("train --json --epochs 2 --threads 1 " + arguments, in);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return nlohmann::json::parse(result.out);
}

TEST(TrainCommand, MakesAMissingDatasetAndAWholeBundle) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  const auto result = run_tactile("train --json --epochs 2 --threads 1", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("data/dataset.h5 is missing"), std::string::npos);
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("outcome"), "trained");
  EXPECT_EQ(json.at("dataset_made"), true);
  EXPECT_EQ(json.at("train_runs"), nlohmann::json::parse(R"(["fan/01", "usb-hub/01"])"));
  EXPECT_EQ(json.at("test_runs"), nlohmann::json::parse(R"(["fan/02", "usb-hub/02"])"));
  ASSERT_EQ(json.at("history").size(), 2U);

  const windows::Dataset dataset(folder / "data/dataset.h5");
  const auto model = read_json(folder.path() / json.at("model").get<std::string>() / "model.json");
  EXPECT_EQ(model.at("dataset").at("manifest_hash"), dataset.manifest_hash());
  EXPECT_EQ(model.at("rendering").at("history_us"), 40'000);
  EXPECT_EQ(model.at("network").at("input"), nlohmann::json::parse(R"({"channels": 1, "height": 24, "width": 32})"));
  EXPECT_EQ(model.at("samples"), samples_of_runs(dataset, split_of(dataset, {}).train_runs).size());
  EXPECT_NO_THROW(Classifier(folder.path() / json.at("model").get<std::string>(), 1));
}

TEST(TrainModel, KeepsTheScenesOfItsTrainingRuns) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  windows::write_dataset(folder / "data", folder / "data/dataset.h5", {}, 1);
  const windows::Dataset dataset(folder / "data/dataset.h5");
  ModelSettings settings;
  settings.training.epochs = 1;
  const ModelBundle bundle{folder / "models/small"};
  train_model(dataset, settings, bundle, {.threads = 1});
  const auto scene = read_description(bundle).scene;
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->runs, 2U);
  // An event each 500 us: 39 or 40 in 20 ms.
  EXPECT_NEAR(scene->background_hz.low, (39 + 1.2816 * std::sqrt(39)) / 0.02, 60);
  EXPECT_NEAR(scene->background_hz.high, scene->background_hz.low, 60);

  // Without one of the recordings nothing is kept: the rest may be of another kind.
  std::filesystem::remove(folder / "data/fan/01/events.aedat4");
  train_model(dataset, settings, bundle, {.threads = 1});
  EXPECT_FALSE(read_description(bundle).scene);
}

TEST(TrainModel, RefusesARecordingThatHasChangedSinceTheDataset) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  windows::write_dataset(folder / "data", folder / "data/dataset.h5", {}, 1);
  std::filesystem::remove_all(folder / "data/usb-hub/01");
  test::make_run(folder / "data/usb-hub/01", 2);  // with another seed
  const windows::Dataset dataset(folder / "data/dataset.h5");
  const std::string error =
      test::error_of([&] { train_model(dataset, {}, ModelBundle{folder / "models/small"}, {.threads = 2}); });
  EXPECT_NE(error.find("usb-hub/01/events.aedat4: differs from the recording that"), std::string::npos) << error;
  EXPECT_FALSE(std::filesystem::exists(folder / "models/small"));
}

TEST(TrainCommand, PrintsTheExpectedTimeAfterAnEpoch) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  const auto result = run_tactile("train --json --epochs 3 --batch 8 --threads 1", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::size_t begins = result.err.find("samples, 3 epochs\n"), estimate = result.err.find("epoch 1 of 3 is done: about 0:");
  EXPECT_NE(begins, std::string::npos) << result.err;
  ASSERT_NE(estimate, std::string::npos) << result.err;
  EXPECT_EQ(result.err.find("about"), result.err.find("about", estimate)) << "none before it is measured\n" << result.err;
  EXPECT_EQ(result.err.find("epoch 3 of 3 is done"), std::string::npos) << "nothing is left then\n" << result.err;
}

TEST(TrainCommand, KeepsAnUnchangedModelAndRequiresForceOrANameForAChangedOne) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  const auto first = trained("--name mine", folder.path());
  const std::string description = read_text(folder / "models/mine/model.json");
  EXPECT_EQ(trained("--name mine", folder.path()).at("outcome"), "unchanged");
  EXPECT_EQ(read_text(folder / "models/mine/model.json"), description);

  const auto changed = run_tactile("train --epochs 2 --name mine --seed 2", folder.path());
  EXPECT_EQ(changed.exit_code, 1);
  EXPECT_NE(changed.err.find("--force"), std::string::npos) << changed.err;
  EXPECT_NE(changed.err.find("--name"), std::string::npos) << changed.err;
  EXPECT_EQ(read_text(folder / "models/mine/model.json"), description);

  const auto forced = trained("--name mine --seed 2 --force", folder.path());
  EXPECT_EQ(forced.at("outcome"), "replaced");
  EXPECT_NE(forced.at("weights_sha256"), first.at("weights_sha256"));
  EXPECT_EQ(trained("--name other --seed 1", folder.path()).at("weights_sha256"), first.at("weights_sha256"));
}

TEST(TrainCommand, GivesTheNextNameToAModelOfAnotherDataset) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  const auto first = trained("", folder.path());
  EXPECT_EQ(first.at("name"), "th40-single-1-epochs2");
  EXPECT_EQ(trained("", folder.path()).at("outcome"), "unchanged");
  test::expect_settings_of("models/th40-single-1-epochs2/settings.json", "train --epochs 2 --threads 1", folder.path());

  ASSERT_EQ(run_tactile("windows --seed 2", folder.path()).exit_code, 0);
  const auto second = trained("", folder.path());
  EXPECT_EQ(second.at("name"), "th40-single-1-epochs2-2");
  EXPECT_EQ(second.at("outcome"), "trained");
  EXPECT_EQ(trained("", folder.path()).at("outcome"), "unchanged") << "the second";
  EXPECT_EQ(first.at("weights_sha256"), read_description({folder / "models/th40-single-1-epochs2"}).weights_sha256);
  EXPECT_EQ(read_text(folder / "models/last"), "th40-single-1-epochs2-2\n");
  EXPECT_EQ(trained("--force", folder.path()).at("name"), "th40-single-1-epochs2-2") << "--force replaces no other model";
}

TEST(TrainCommand, WritesItsHistoryWhileItTrainsAndScalarsForTensorBoard) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  windows::write_dataset(folder / "data", folder / "data/dataset.h5", {}, 2);
  ModelSettings settings;
  settings.training.epochs = 3;
  const ModelBundle bundle{folder / "models/mine"};
  const auto while_it_trains = folder / "models/mine.training/history.csv";
  std::vector<std::size_t> rows;
  train_model(windows::Dataset(folder / "data/dataset.h5"), settings, bundle, {.threads = 1}, [&](const Progress&) {
    const std::size_t seen = std::filesystem::exists(while_it_trains) ? read_history(while_it_trains).size() : 0;
    if (rows.empty() || rows.back() != seen) rows.push_back(seen);
  });
  EXPECT_EQ(rows, (std::vector<std::size_t>{0, 1, 2, 3})) << "a row for each finished epoch";
  EXPECT_FALSE(std::filesystem::exists(while_it_trains));
  EXPECT_EQ(read_history(bundle.history()).size(), 3U);

  const auto board = trained("--name board --tensorboard logs", folder.path());
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "logs/board")) files.push_back(entry.path());
  ASSERT_EQ(files.size(), 1U);
  const std::string events = read_text(files.front());
  for (const char* tag : {"train/loss", "train/accuracy", "learning_rate", "gradient_norm", "images_per_s"})
    EXPECT_NE(events.find(tag), std::string::npos) << tag;
  EXPECT_EQ(events.find("validation/"), std::string::npos) << "no validation part";
}

TEST(TrainCommand, PrintsAtMostTenEpochsUnlessAskedForAll) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  const auto epochs_printed = [&](const std::string& options) {
    const auto result = run_tactile("train --quiet --threads 1 " + options, folder.path());
    EXPECT_EQ(result.exit_code, 0) << result.err;
    std::vector<std::string> epochs;
    std::istringstream lines(result.out);
    std::string line;
    for (std::getline(lines, line); std::getline(lines, line) && !line.empty();)
      epochs.push_back(line.substr(0, line.find("  0.")));
    return std::pair(epochs, result.out);
  };
  const auto [ten, text_of_ten] = epochs_printed("--epochs 10 --name ten");
  EXPECT_EQ(ten.size(), 10U) << text_of_ten;
  EXPECT_EQ(text_of_ten.find("--verbose"), std::string::npos);
  const auto [some, text] = epochs_printed("--epochs 40 --name some");
  EXPECT_LE(some.size(), 10U) << text;
  EXPECT_GE(some.size(), 8U) << text;
  EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 18) << text;
  EXPECT_NE(text.find(std::to_string(some.size()) + " of 40 epochs; --verbose prints all"), std::string::npos) << text;
  EXPECT_EQ(epochs_printed("--epochs 40 --name all --verbose").first.size(), 40U);
}

TEST(TrainCommand, RunsWithoutLabelsNameTheCommandThatMakesThem) {
  const test::TemporaryFolder folder;
  test::make_run(folder / "data/fan/01", 1, false);
  const auto result = run_tactile("train --th 40", folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("tactile label"), std::string::npos) << result.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "models"));
}

TEST(TrainCommand, HoldsObjectsOut) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan", "small-box", "usb-hub"}, 2);
  const auto json = trained("--split unseen --held-out fan,small-box --train-run 02", folder.path());
  EXPECT_EQ(json.at("train_runs"), nlohmann::json::parse(R"(["usb-hub/02"])"));
  EXPECT_EQ(json.at("test_runs").size(), 4U);
  const auto typo = run_tactile("train --train-run 09", folder.path());
  EXPECT_EQ(typo.exit_code, 1);
  EXPECT_NE(typo.err.find("--train-run 09: no object has such a run; expected one of 01, 02"), std::string::npos) << typo.err;
  const auto bogus = run_tactile("train --split unseen --held-out bogus", folder.path());
  EXPECT_EQ(bogus.exit_code, 1);
  EXPECT_NE(bogus.err.find("bogus"), std::string::npos);
}

TEST(TrainCommand, RefusesValuesOutOfRangeWithTheRange) {
  for (const char* arguments :
       {"--epochs 0", "--batch 0", "--lr 0", "--split half", "--denoise some", "--factor 2", "--name a/b"}) {
    EXPECT_GE(run_tactile(std::string("train ") + arguments).exit_code, 100) << arguments;
  }
  const auto ticks = run_tactile("train --th 3");
  EXPECT_EQ(ticks.exit_code, 1);
  EXPECT_NE(ticks.err.find("whole number of ticks"), std::string::npos) << ticks.err;
}

TEST(TrainModel, IsTheSameFromStoredHeatmapsAndFromRenderedOnes) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  windows::write_dataset(folder / "data", folder / "data/dataset.h5", {}, 2);
  ModelSettings settings;
  settings.training.epochs = 1;
  const ModelBundle rendered{folder / "rendered"}, stored{folder / "stored"};
  train_model(windows::Dataset(folder / "data/dataset.h5"), settings, rendered, {.threads = 1});
  heatmaps::store_heatmaps(windows::Dataset(folder / "data/dataset.h5"), std::span(&settings.rendering, 1), 1);
  const windows::Dataset dataset(folder / "data/dataset.h5");
  ASSERT_TRUE(dataset.find_heatmaps("th_040").has_value());
  train_model(dataset, settings, stored, {.threads = 1});
  EXPECT_EQ(read_description(stored).weights_sha256, read_description(rendered).weights_sha256);
  EXPECT_EQ(state_of(stored, dataset, settings), BundleState::unchanged);
  settings.training.batch = 8;
  EXPECT_EQ(state_of(stored, dataset, settings), BundleState::changed);
  EXPECT_EQ(state_of({folder / "missing"}, dataset, settings), BundleState::missing);
}

TEST(TrainCommand, StartsFromAnotherModelsWeights) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  const auto first = trained("--name first", folder.path());
  const auto second = trained("--name second --from first --lr 1e-12", folder.path());
  EXPECT_EQ(second.at("settings").at("training").at("from"),
            nlohmann::json({{"name", "first"}, {"weights_sha256", first.at("weights_sha256")}}));
  const auto weights_of = [&](const char* name) {
    const ModelBundle bundle{folder / "models" / name};
    return read_bundle_weights(bundle, read_description(bundle));
  };
  const Weights a = weights_of("first"), b = weights_of("second");
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t k = 0; k < a[i].values.size(); ++k) ASSERT_NEAR(a[i].values[k], b[i].values[k], 1e-6);
  }

  for (const char* other : {"--th 20", "--denoise none", "--pool average", "--activation tanh"}) {
    const auto refused = run_tactile(std::string("train --epochs 1 --name third --from models/first ") + other, folder.path());
    EXPECT_EQ(refused.exit_code, 1) << other;
    EXPECT_NE(refused.err.find("models/first"), std::string::npos) << refused.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "models/third"));
  }
  EXPECT_EQ(run_tactile("train --from nobody", folder.path()).exit_code, 1);
}

TEST(TrainCommand, TakesEveryOptionAndItsModelAnswersByThem) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  const std::string options =
      "--optimizer sgd --lr 0.05 --schedule step --activation tanh --pool average --augment flip --class-weights 1,2,1 "
      "--validation 0.25 --early-stop 5 --name all";
  const auto json = trained(options, folder.path());
  EXPECT_GT(json.at("validation_samples"), 0);
  EXPECT_TRUE(json.at("history").at(0).at("validation_loss").is_number());
  const ModelBundle bundle{folder / "models/all"};
  const ModelDescription model = read_description(bundle);
  EXPECT_EQ(model.settings.network, (LeNetOptions{Activation::tanh, Pooling::average}));
  EXPECT_EQ(model.settings.training.class_weights.given, (std::array{1.0, 2.0, 1.0}));
  EXPECT_EQ(trained(options, folder.path()).at("outcome"), "unchanged");

  // The options of the network in the bundle are used.
  const windows::Dataset dataset(folder / "data/dataset.h5");
  const std::vector<std::uint32_t> samples{0, 1, 2, 3};
  const auto heatmaps = sample_heatmaps(dataset, model.settings.rendering, samples, 1);
  const LeNet network(model.input, read_bundle_weights(bundle, model), model.settings.network);
  EXPECT_THROW(Classifier(bundle.folder, 1), Error);  // the fast engine does not know such layers
  EXPECT_EQ(open_classifier(bundle.folder, 1, EngineKind::libtorch).classify(heatmaps), network.logits(heatmaps, 1));
  EXPECT_NE(open_classifier(bundle.folder, 1, EngineKind::libtorch).classify(heatmaps),
            LeNet(model.input, network.weights()).logits(heatmaps, 1));
  const auto metadata = read_metadata(bundle.weights());
  EXPECT_EQ(nlohmann::json::parse(metadata.at("classes")), nlohmann::json::parse(R"(["none", "press", "slip"])"));
  EXPECT_EQ(nlohmann::json::parse(metadata.at("rendering")), nlohmann::json(model.settings.rendering));
}

TEST(TrainCommand, EitherEnginesModelsAreNamedApartAndUsedByAll) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  const auto fast = trained("", folder.path()), libtorch = trained("--engine libtorch", folder.path());
  EXPECT_EQ(fast.at("name"), "th40-single-1-epochs2");
  EXPECT_EQ(libtorch.at("name"), "th40-single-1-engine-libtorch-epochs2");
  EXPECT_EQ(libtorch.at("settings").at("training").at("engine").get<std::string>(), "libtorch");
  EXPECT_NEAR(fast.at("history").back().at("loss").get<double>(), libtorch.at("history").back().at("loss").get<double>(), 0.05);
  EXPECT_EQ(trained("--engine libtorch", folder.path()).at("outcome"), "unchanged");
  const auto gone_on = trained("--name other --engine libtorch --from " + fast.at("name").get<std::string>(), folder.path());
  EXPECT_EQ(gone_on.at("outcome"), "trained");
}

TEST(TrainCommand, ReportsWrongOptions) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan"}, 2);
  for (const auto& [arguments, word] : {std::pair("--class-weights 1,2", "--class-weights: class weights '1,2'; expected"),
                                        std::pair("--validation 0 --early-stop 2", "early stop"),
                                        std::pair("--augment none,flip", "--augment: augmentation 'none,flip' is unknown")}) {
    const auto refused = run_tactile(std::string("train ") + arguments, folder.path());
    EXPECT_NE(refused.exit_code, 0) << arguments;
    EXPECT_NE(refused.err.find(word), std::string::npos) << refused.err;
  }
}

TEST(TrainModel, KeepsTheOldModelWhereTheLossIsNoLongerFinite) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  windows::write_dataset(folder / "data", folder / "data/dataset.h5", {}, 2);
  const windows::Dataset dataset(folder / "data/dataset.h5");
  ModelSettings settings;
  settings.training.epochs = 1;
  const ModelBundle bundle{folder / "mine"};
  train_model(dataset, settings, bundle, {.threads = 1});
  const std::string description = read_text(bundle.description());
  settings.training.learning_rate = 1e30;
  EXPECT_THROW(train_model(dataset, settings, bundle, {.threads = 1}), Error);
  EXPECT_EQ(read_text(bundle.description()), description);
  EXPECT_NO_THROW(Classifier(bundle.folder, 1));
}

TEST(TrainModel, KeepsTheLastGoodStateOfATrainingThatDiverges) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  windows::write_dataset(folder / "data", folder / "data/dataset.h5", {}, 2);
  const windows::Dataset dataset(folder / "data/dataset.h5");
  ModelSettings settings;
  settings.training = {.epochs = 3, .batch = 65'536, .learning_rate = 1e25};  // one batch an epoch: the second one sees the harm
  const ModelBundle bundle{folder / "mine"};
  EXPECT_THROW(train_model(dataset, settings, bundle, {.threads = 1, .save_every = std::chrono::duration<double>(0)}), Error);
  EXPECT_FALSE(std::filesystem::exists(bundle.folder));
  const auto kept = CheckpointFolder::beside(bundle.folder);
  ASSERT_TRUE(CheckpointFolder::holds_state(kept));
  const auto task = task_of_checkpoint(kept);
  const LeNetLayers layers = lenet_layers(heatmaps::heatmap_size(dataset.sensor(), settings.rendering.factor));
  const auto state = CheckpointFolder(kept).load(*task, layers, settings.training.optimizer);  // refuses what is not finite
  ASSERT_TRUE(state);
  EXPECT_EQ(state->epoch, 2U) << "the end of the first";
  EXPECT_EQ(state->history.size(), 1U);
  // A repetition gives the same output, and nothing is lost.
  EXPECT_THROW(train_model(dataset, settings, bundle, {.threads = 1, .resume = true}), Error);
  EXPECT_TRUE(CheckpointFolder::holds_state(kept));
}

TEST(TrainCommand, ReportsALearningRateThatDivergesOrIsTooLow) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  const auto diverges = run_tactile("train --lr 10 --epochs 2 --name far", folder.path());
  EXPECT_EQ(diverges.exit_code, 1);
  EXPECT_NE(diverges.err.find("training: the "), std::string::npos) << diverges.err;
  EXPECT_NE(diverges.err.find("in epoch 1, after "), std::string::npos) << diverges.err;
  EXPECT_NE(diverges.err.find("(try a smaller --lr than 10)"), std::string::npos) << diverges.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "models/far"));
  const auto nothing = run_tactile("train --lr 1e-12 --epochs 1 --name still", folder.path());
  EXPECT_EQ(nothing.exit_code, 0) << nothing.err;
  EXPECT_NE(nothing.err.find("models/still: has learned nothing"), std::string::npos) << nothing.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "models/still/model.json"));
}

TEST(SplitOfADataset, SharesNoRunBetweenTrainingAndTest) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", test::six_objects, 2);
  windows::write_dataset(folder / "data", folder / "data/dataset.h5", {}, 2);
  const windows::Dataset dataset(folder / "data/dataset.h5");
  const windows::Split split = split_of(dataset, {});
  const auto train = samples_of_runs(dataset, split.train_runs), test = samples_of_runs(dataset, split.test_runs);
  EXPECT_EQ(train.size() + test.size(), dataset.samples().size());
  for (const std::uint32_t sample : train) EXPECT_EQ(dataset.runs()[dataset.samples()[sample].run_index].run, "01");
}

}  // namespace
}  // namespace tactile::model
