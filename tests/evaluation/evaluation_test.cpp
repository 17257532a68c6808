#include "tactile/evaluation/evaluation.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <set>

#include "model/small_data.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/evaluation/full_run.hpp"
#include "tactile/model/train_model.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile {
namespace {

using test::make_runs;
using test::run_tactile;

/// A data folder of small runs, its dataset, and a model of it.
struct Trained {
  test::TemporaryFolder folder;
  std::filesystem::path file = folder / "data/dataset.h5";
  ModelBundle bundle{folder / "models/small"};

  explicit Trained(const std::vector<std::string>& objects = {"fan", "usb-hub"}, int runs = 2) {
    make_runs(folder / "data", objects, runs);
    write_dataset(folder / "data", file, {}, 2);
    ModelSettings settings;
    settings.training.epochs = 4;
    train_model(Dataset(file), settings, bundle, 1);
  }
};

std::vector<std::uint32_t> test_runs(const Dataset& dataset) { return split_of(dataset, {}).test_runs; }

TEST(FullRun, SaysAtASamplesTickWhatTheDatasetsHeatmapSays) {
  const Trained trained;
  const Dataset dataset(trained.file);
  const Classifier classifier(trained.bundle.folder, 1);
  const std::uint32_t run = 1;
  const FullRun full = classify_full_run(dataset.run_folder(run) / "events.aedat4", classifier, 1);
  // Events from 5 s to 6.2 s: ticks from 5.04 s to 6.2 s.
  EXPECT_EQ(full.ticks.first, camera_time(5'040'000));
  EXPECT_EQ(full.ticks.count, 581);
  ASSERT_EQ(full.verdicts.size(), 581U);
  EXPECT_EQ(expected_ticks(dataset.run_folder(run) / "events.aedat4", classifier.rendering()), 581U);
  const auto samples = samples_of_runs(dataset, {&run, 1});
  ASSERT_FALSE(samples.empty());
  const auto said = classifier.verdicts(sample_heatmaps(dataset, classifier.rendering(), samples, 1));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto place = (dataset.samples()[samples[i]].t - full.ticks.first) / full.ticks.tick;
    EXPECT_EQ(full.verdicts[static_cast<std::size_t>(place)], said[i]);
  }
}

TEST(Evaluation, LearnsWhatIsEasyAndKnowsTheTrivialDetectors) {
  const Trained trained({"fan", "small-box", "usb-hub"});
  const Dataset dataset(trained.file);
  const Evaluation evaluation = evaluate(dataset, Classifier(trained.bundle.folder, 2), test_runs(dataset), {.threads = 2});
  EXPECT_GT(evaluation.accuracy.mean.value, 0.9);
  EXPECT_EQ(evaluation.accuracy.objects.size(), 3U);
  EXPECT_EQ(evaluation.confusion.samples(), samples_of_runs(dataset, test_runs(dataset)).size());
  ASSERT_EQ(evaluation.baselines.size(), 4U);
  EXPECT_NEAR(evaluation.baselines[0].accuracy.mean.value, 1.0 / 3, 1e-12);
  EXPECT_GT(evaluation.baselines[2].accuracy.mean.value, 0.9);  // left or right is told by the centre
  EXPECT_EQ(evaluation.network.press.all.intervals, 3U);
  EXPECT_EQ(evaluation.network.slip.all.intervals, 3U);
  EXPECT_EQ(evaluation.trivial.at("always_press").press.all.early, 3U);
  EXPECT_EQ(evaluation.trivial.at("always_press").slip.all.misses, 3U);
  EXPECT_EQ(evaluation.trivial.at("always_slip").slip.all.early, 3U);
  EXPECT_EQ(evaluation.trivial.at("always_slip").press.all.misses, 3U);
  EXPECT_EQ(evaluation.trivial.at("random").press.all.misses, 0U);
  EXPECT_GT(evaluation.trivial.at("random").false_alarms.total.alarms, 100U);
  // Labels are the truth here; gross slip begins 20 ms later.
  ASSERT_TRUE(evaluation.truth);
  EXPECT_EQ(evaluation.truth->slip.all.mean_ms.value, evaluation.network.slip.all.mean_ms.value);
  EXPECT_DOUBLE_EQ(evaluation.truth->gross_slip.all.mean_ms.value, evaluation.network.slip.all.mean_ms.value - 20);
  // 581 ticks of which 100 lie in each interval and 50 in the guard after each, in each of three runs.
  EXPECT_EQ(evaluation.network.false_alarms.total.none_time, 3 * 281 * 2ms);
  EXPECT_EQ(evaluation.network.false_alarms.total.after_intervals_time, 3 * 100 * 2ms);
  EXPECT_NE(title_of(evaluation).find("simulated"), std::string::npos);
}

TEST(Evaluation, DoesNotDependOnTheNumberOfThreads) {
  const Trained trained;
  const Dataset dataset(trained.file);
  const nlohmann::json one = evaluate(dataset, Classifier(trained.bundle.folder, 1), test_runs(dataset), {.threads = 1});
  const nlohmann::json three = evaluate(dataset, Classifier(trained.bundle.folder, 3), test_runs(dataset), {.threads = 3});
  EXPECT_EQ(one, three);
}

TEST(Evaluation, StopsWhereARunHasChangedAndNamesIt) {
  const Trained trained;
  const Dataset dataset(trained.file);
  std::ofstream(trained.folder / "data/usb-hub/02/labels.json", std::ios::app) << "\n";
  try {
    evaluate(dataset, Classifier(trained.bundle.folder, 1), test_runs(dataset), {.threads = 1});
    ADD_FAILURE() << "no error";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("usb-hub/02"), std::string::npos) << e.what();
  }
}

TEST(Evaluation, RefusesAModelOfAnotherDataset) {
  const Trained trained;
  write_dataset(trained.folder / "data", trained.folder / "data/other.h5", {.sampling = {.seed = 2}}, 1);
  const Dataset other(trained.folder / "data/other.h5");
  EXPECT_THROW(evaluate(other, Classifier(trained.bundle.folder, 1), test_runs(other)), Error);
}

TEST(EvalCommand, WritesAllKeysIntoTheNewestSingleRunModel) {
  const Trained trained({"fan", "small-box", "usb-hub"});
  const auto result = run_tactile("eval --json", trained.folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("models/small"), std::string::npos);
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(read_json(trained.bundle.evaluation()), json);
  const auto expect_figure = [](const nlohmann::json& figure) {
    for (const char* key : {"value", "low", "high", "n"}) EXPECT_TRUE(figure.contains(key)) << key << " in " << figure;
  };
  expect_figure(json.at("accuracy").at("mean"));
  expect_figure(json.at("accuracy").at("objects").at("fan"));
  expect_figure(json.at("false_alarms_per_min"));
  for (const char* baseline : {"majority", "event_count", "logistic_moments", "logistic_position"})
    expect_figure(json.at("baselines").at(baseline).at("accuracy"));
  for (const char* touch : {"press", "slip"}) {
    for (const char* delays : {"delay_ms", "delay_true_ms"}) {
      const auto& delay = json.at(delays).at(touch);
      expect_figure(delay.at("mean"));
      expect_figure(delay.at("median"));
      for (const char* key : {"sem", "intervals", "misses", "early", "objects"}) EXPECT_TRUE(delay.contains(key)) << key;
    }
  }
  EXPECT_EQ(json.at("confusion").size(), 3U);
  EXPECT_TRUE(json.at("simulated").get<bool>());
  const auto text = run_tactile("eval", trained.folder.path());
  EXPECT_NE(text.out.find("on simulated runs"), std::string::npos);
  EXPECT_NE(text.out.find("The network's accuracy interval"), std::string::npos);
  EXPECT_NE(text.out.find("always_press"), std::string::npos);
}

TEST(EvalCommand, WithoutAModelNamesTheCommandThatTrainsOne) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan"}, 2);
  const auto no_dataset = run_tactile("eval", folder.path());
  EXPECT_EQ(no_dataset.exit_code, 1);
  EXPECT_NE(no_dataset.err.find("tactile train --th 40"), std::string::npos) << no_dataset.err;
  write_dataset(folder / "data", folder / "data/dataset.h5", {}, 1);
  const auto no_model = run_tactile("eval", folder.path());
  EXPECT_EQ(no_model.exit_code, 1);
  EXPECT_NE(no_model.err.find("tactile train --th 40"), std::string::npos) << no_model.err;
}

TEST(EvalCommand, UnseenTrainsWhatIsMissingWithTheSettingsOfTheOther) {
  const Trained trained(test::six_objects, 2);
  const auto refused = run_tactile("eval --unseen --no-train", trained.folder.path());
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("tactile train --th 40 --split unseen --epochs 4"), std::string::npos) << refused.err;

  const auto result = run_tactile("eval --unseen --json --threads 1", trained.folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("is missing: it is trained first"), std::string::npos) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(read_json(trained.bundle.unseen_evaluation()), json);
  const auto& objects = json.at("unseen").at("objects");
  EXPECT_EQ(objects.size(), 5U);
  for (const auto& [name, object] : objects.items()) {
    const double seen = object.at("seen").at("value"), held_out = object.at("held_out").at("value");
    EXPECT_NEAR(object.at("difference").at("value").get<double>(), held_out - seen, 1e-12) << name;
  }
  // Run 01 of a held-out object was learned from by the other model.
  const std::set<std::string> runs = json.at("unseen").at("runs");
  EXPECT_EQ(runs, (std::set<std::string>{"fan/02", "plastic-container/02", "small-box/02", "sprayer/02", "textured-box/02"}));
  EXPECT_EQ(json.at("unseen").at("models").at("seen"), "small");
  EXPECT_TRUE(json.contains("accuracy"));

  const auto again = run_tactile("eval --unseen --no-train --json", trained.folder.path());
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(nlohmann::json::parse(again.out).at("unseen"), json.at("unseen"));
}

}  // namespace
}  // namespace tactile
