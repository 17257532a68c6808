#include "tactile/evaluation/evaluation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <optional>

#include "evaluation/trained_model.hpp"
#include "tactile/core/error.hpp"
#include "tactile/evaluation/baselines.hpp"
#include "tactile/evaluation/full_run.hpp"
#include "tactile/evaluation/run_prediction.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/model/training/open_classifier.hpp"
#include "tactile/model/training/sample_logits.hpp"

namespace tactile::evaluation {
namespace {

using test::Trained;

std::vector<std::uint32_t> test_runs(const windows::Dataset& dataset) { return model::split_of(dataset, {}).test_runs; }

TEST(FullRun, PredictsAtASamplesTickWhatTheDatasetsHeatmapGives) {
  const Trained trained;
  const windows::Dataset dataset(trained.file);
  const model::Classifier classifier(trained.bundle.folder, 1);
  const std::uint32_t run = 1;
  const results::FullRun full = classify_full_run(dataset.run_folder(run) / "events.aedat4", classifier);
  // Events from 5 s to 6.2 s: ticks from 5.04 s to 6.2 s.
  EXPECT_EQ(full.ticks.first, camera_time(5'040'000));
  EXPECT_EQ(full.ticks.count, 581);
  ASSERT_EQ(full.verdicts.size(), 581U);
  EXPECT_EQ(expected_ticks(dataset.run_folder(run) / "events.aedat4", classifier.rendering()), 581U);
  const auto samples = model::samples_of_runs(dataset, {&run, 1});
  ASSERT_FALSE(samples.empty());
  const auto predicted = classifier.verdicts(model::sample_heatmaps(dataset, classifier.rendering(), samples, 1));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto place = (dataset.samples()[samples[i]].t - full.ticks.first) / full.ticks.tick;
    EXPECT_EQ(full.verdicts[static_cast<std::size_t>(place)], predicted[i]);
  }
}

TEST(FullRun, PredictsTheSameByBothEnginesExceptAtCloseTicks) {
  const Trained trained;
  const windows::Dataset dataset(trained.file);
  const model::Classifier fast(trained.bundle.folder, 1),
      libtorch = model::open_classifier(trained.bundle.folder, 1, model::EngineKind::libtorch);
  EXPECT_EQ(fast.engine(), model::EngineKind::fast);
  EXPECT_EQ(libtorch.engine(), model::EngineKind::libtorch);
  const auto events = dataset.run_folder(1) / "events.aedat4";
  const results::FullRun by_fast = classify_full_run(events, fast, {.threads = 2}),
                         by_libtorch = classify_full_run(events, libtorch);
  ASSERT_EQ(by_fast.verdicts.size(), by_libtorch.verdicts.size());
  std::size_t other = 0;
  for (std::size_t k = 0; k < by_fast.verdicts.size(); ++k) {
    other += by_fast.verdicts[k] != by_libtorch.verdicts[k] ? 1 : 0;
    for (std::size_t i = 0; i < touch_count; ++i)
      EXPECT_NEAR(by_fast.probabilities[k][i], by_libtorch.probabilities[k][i], 1e-4) << "tick " << k;
  }
  EXPECT_LE(other, by_fast.close);
  EXPECT_LT(by_fast.close, by_fast.verdicts.size() / 10);
}

TEST(FullRun, OfAStreamPredictsAtASamplesTickAlmostWhatTheDatasetsEventsGive) {
  const test::Trained trained;
  const windows::Dataset dataset(trained.file);
  const model::ModelBundle bundle{trained.folder / "models/stream"};
  model::ModelSettings settings;
  settings.kind = model::ModelKind::stream;
  settings.stream.steps = 10;
  settings.rendering.history = settings.rendering.tick;
  model::train_model(dataset, settings, bundle);
  const model::Classifier classifier(bundle.folder, 1);
  for (const std::uint32_t run : test_runs(dataset)) {
    const results::FullRun full = classify_full_run(dataset.run_folder(run) / "events.aedat4", classifier);
    const auto samples = model::samples_of_runs(dataset, {&run, 1});
    const auto logits = model::sample_logits(dataset, classifier, samples, 1);
    ASSERT_EQ(logits.size(), samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const auto k = static_cast<std::size_t>(between(full.ticks.first, dataset.samples()[samples[i]].t) / full.ticks.tick);
      const auto probabilities = model::probabilities_of(logits[i]);
      for (std::size_t c = 0; c < touch_count; ++c)
        ASSERT_NEAR(full.probabilities[k][c], probabilities[c], 0.01)
            << i << ": the dataset has only the histories of samples, and a stream remembers";
    }
  }
}

TEST(Evaluation, ReportsItsEngineAndCloseTicks) {
  const Trained trained({"fan", "small-box"});
  const windows::Dataset dataset(trained.file);
  const auto by = [&](model::EngineKind engine) -> nlohmann::json {
    return evaluate(dataset, model::open_classifier(trained.bundle.folder, 1, engine), test_runs(dataset), {.threads = 1})
        .evaluation;
  };
  const nlohmann::json fast = by(model::EngineKind::fast), libtorch = by(model::EngineKind::libtorch);
  EXPECT_EQ(fast.at("engine").at("name").get<std::string>(), "fast");
  EXPECT_EQ(libtorch.at("engine").at("name").get<std::string>(), "libtorch");
  EXPECT_GT(fast.at("engine").at("ticks").get<int>(), 500);
  EXPECT_LT(fast.at("engine").at("close_ticks").get<int>(), 50);
  EXPECT_EQ(fast.at("confusion"), libtorch.at("confusion"));
}

TEST(Evaluation, LearnsWhatIsEasyAndKnowsTheTrivialDetectors) {
  const Trained trained({"fan", "small-box", "usb-hub"});
  const windows::Dataset dataset(trained.file);
  const results::Evaluation evaluation =
      evaluate(dataset, model::Classifier(trained.bundle.folder, 2), test_runs(dataset), {.threads = 2}).evaluation;
  EXPECT_GT(evaluation.accuracy.mean.value, 0.9);
  EXPECT_EQ(evaluation.accuracy.objects.size(), 3U);
  EXPECT_EQ(evaluation.confusion.samples(), model::samples_of_runs(dataset, test_runs(dataset)).size());
  ASSERT_EQ(evaluation.baselines.size(), 3U);
  for (const auto& [name, baseline] : evaluation.baselines) {
    EXPECT_EQ(baseline.decided.touches, 6U) << name;
    EXPECT_GT(baseline.decided.outside_min, 0) << name;
    EXPECT_EQ(baseline.calm.size(), 4U) << name;
  }
  EXPECT_LT(evaluation.baselines.at("event_rate").decided.missed.value, 0.5);
  EXPECT_EQ(evaluation.network.press.all.intervals, 3U);
  EXPECT_EQ(evaluation.network.slip.all.intervals, 3U);
  EXPECT_EQ(evaluation.trivial.at("always_press").press.all.early, 3U);
  EXPECT_EQ(evaluation.trivial.at("always_press").slip.all.misses, 3U);
  EXPECT_EQ(evaluation.trivial.at("always_slip").slip.all.early, 3U);
  EXPECT_EQ(evaluation.trivial.at("always_slip").press.all.misses, 3U);
  EXPECT_EQ(evaluation.trivial.at("random").press.all.misses, 0U);
  // Labels are the truth here; gross slip begins 20 ms later.
  ASSERT_TRUE(evaluation.truth);
  EXPECT_EQ(evaluation.truth->delay_ms.slip.all.mean_ms.value, evaluation.network.slip.all.mean_ms.value);
  EXPECT_DOUBLE_EQ(evaluation.whole_runs.decided.gross_median_ms.ms.value,
                   evaluation.whole_runs.decided.slip_median_ms.ms.value - 20);
  // 581 ticks, of which 100 lie in each touch, in each of three runs.
  EXPECT_DOUBLE_EQ(evaluation.whole_runs.decided.outside_min, 3 * 381 * 0.002 / 60);
  EXPECT_NE(results::title_of(evaluation).find("simulated"), std::string::npos);
}

TEST(Evaluation, TakesABalancedSamplesVerdictAtItsTick) {
  const Trained trained;
  const windows::Dataset dataset(trained.file);
  const model::Classifier classifier(trained.bundle.folder, 1);
  const auto runs = test_runs(dataset);
  for (const Confirmation confirmation : {Confirmation{1, 1}, Confirmation{12, 20}}) {
    const EvaluationOptions options{.confirmation = confirmation, .threads = 1};
    results::Confusion by_hand;
    for (const std::uint32_t run : runs) {
      const results::FullRun full = classify_full_run(dataset.run_folder(run) / "events.aedat4", classifier);
      const auto verdicts = confirmed(full.verdicts, confirmation);
      for (const std::uint32_t i : model::samples_of_runs(dataset, {&run, 1})) {
        const windows::Sample& sample = dataset.samples()[i];
        by_hand.add(sample.touch, verdicts[static_cast<std::size_t>((sample.t - full.ticks.first) / full.ticks.tick)]);
      }
    }
    const results::Evaluation evaluation = evaluate(dataset, classifier, runs, options).evaluation;
    EXPECT_EQ(evaluation.confusion, by_hand);
    results::Confusion of_runs;
    for (const results::Cell& cell : judge_samples(dataset, {&classifier, runs}, options)) of_runs += cell.samples;
    EXPECT_EQ(of_runs, by_hand);
    // So many ticks have to pass since the onset.
    EXPECT_GE(evaluation.network.press.all.mean_ms.value, 2.0 * confirmation.needed);
  }
}

TEST(Evaluation, AgainstTheTruthCountsATickAsWhatItTrulyIs) {
  // By its labels the usb-hub's test run begins its slip 100 ms before it does.
  const Trained trained({"fan", "usb-hub"}, 2, 4, [](const std::filesystem::path& data) {
    const auto file = data / "usb-hub/02/labels.json";
    labels::Labels labels = labels::read_labels(file);
    labels.intervals[1].start.at = labels.intervals[1].start.low = before(labels.intervals[1].start.at, 100ms);
    labels::write_labels(file, labels);
  });
  const windows::Dataset dataset(trained.file);
  const results::Evaluation evaluation =
      evaluate(dataset, model::Classifier(trained.bundle.folder, 1), test_runs(dataset), {.threads = 1}).evaluation;
  ASSERT_TRUE(evaluation.truth.has_value());
  EXPECT_LT(evaluation.accuracy.objects.at("usb-hub").value, 0.95);
  EXPECT_GT(evaluation.truth->accuracy.objects.at("usb-hub").value, evaluation.accuracy.objects.at("usb-hub").value + 0.05);
  EXPECT_EQ(evaluation.truth->accuracy.objects.at("fan").value, evaluation.accuracy.objects.at("fan").value);
  EXPECT_GE(evaluation.network.slip.objects.at("usb-hub").mean_ms.value, 100.0);
  EXPECT_LT(evaluation.truth->delay_ms.slip.objects.at("usb-hub").mean_ms.value, 50.0);
}

TEST(RunPrediction, IsWrittenAsOneRowATick) {
  const Trained trained;
  const model::Classifier classifier(trained.bundle.folder, 1);
  test::make_run(trained.folder / "elsewhere/new/07", 5, false, false);
  const RunFolder unlabelled = run_folder_at(trained.folder / "elsewhere/new/07");
  const RunPrediction prediction = predict_run(unlabelled, classifier, {.decision = {.confirmation = {2, 3}}});
  EXPECT_EQ(prediction.run, "new/07");
  EXPECT_FALSE(prediction.simulated);
  EXPECT_TRUE(prediction.detections.empty());
  EXPECT_EQ(prediction.verdicts, confirmed(prediction.full.verdicts, {2, 3}));
  const auto file = trained.folder / "a.csv";
  write_prediction(file, prediction, {{prediction.full.ticks.at(1), Touch::slip}});
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line, "t_us,p_none,p_press,p_slip,verdict,label,truth,events,sample");
  std::getline(in, line);
  EXPECT_TRUE(line.starts_with("5040000,")) << line;
  EXPECT_TRUE(line.ends_with(",,," + std::to_string(prediction.full.events[0]) + ",")) << line;
  std::getline(in, line);
  EXPECT_TRUE(line.ends_with(",slip")) << line;
  std::size_t rows = 2;
  while (std::getline(in, line)) ++rows;
  EXPECT_EQ(rows, prediction.verdicts.size());
  for (const model::Probabilities& p : prediction.full.probabilities) EXPECT_NEAR(p[0] + p[1] + p[2], 1.0, 1e-5);
}

TEST(RunPrediction, OfASimulatedRunIsJudgedByItsTruthToo) {
  const Trained trained;
  const model::Classifier classifier(trained.bundle.folder, 1);
  const RunFolder run = run_folder_at(trained.folder / "data/fan/02");
  // A slip that is not there is labelled in its last 100 ms.
  labels::Labels labels = labels::read_labels(run.labels());
  const TouchInterval slip = labels.intervals.at(1).interval();
  labels.intervals[1].start.at = labels.intervals[1].start.low = labels.intervals[1].start.high = before(slip.end, 100ms);
  labels::write_labels(run.labels(), labels);
  const RunPrediction prediction = predict_run(run, classifier);
  ASSERT_EQ(prediction.detections.size(), 2U);
  ASSERT_EQ(prediction.true_detections.size(), 2U);
  EXPECT_EQ(prediction.detections[1].interval.start, before(slip.end, 100ms));
  EXPECT_EQ(prediction.true_detections[1].interval.start, slip.start);
  const nlohmann::json outcome = outcome_json(prediction);
  EXPECT_EQ(outcome.at("true_intervals").at(1), nlohmann::json(prediction.true_detections[1]));
  EXPECT_TRUE(outcome.at("whole_run").at("by_truth"));
  std::filesystem::remove(run.truth());
  const nlohmann::json by_labels = outcome_json(predict_run(run, classifier));
  EXPECT_TRUE(by_labels.at("true_intervals").is_null());
  EXPECT_FALSE(by_labels.at("whole_run").at("by_truth"));
}

TEST(Evaluation, DoesNotDependOnTheNumberOfThreads) {
  const Trained trained;
  const windows::Dataset dataset(trained.file);
  const auto by = [&](unsigned threads) {
    return evaluate(dataset, model::Classifier(trained.bundle.folder, threads), test_runs(dataset), {.threads = threads});
  };
  const Evaluated one = by(1), three = by(3);
  EXPECT_EQ(nlohmann::json(one.evaluation), nlohmann::json(three.evaluation));
  EXPECT_EQ(results::cells_csv(one.cells), results::cells_csv(three.cells));
}

TEST(Evaluation, IsReadBackAsItIsWritten) {
  const Trained trained;
  const windows::Dataset dataset(trained.file);
  const EvaluationOptions options{.confirmation = {2, 3}, .threads = 1};
  const nlohmann::json json =
      evaluate(dataset, model::Classifier(trained.bundle.folder, 1), test_runs(dataset), options).evaluation;
  ASSERT_FALSE(json.at("truth").is_null());
  EXPECT_EQ(nlohmann::json(results::JsonView(json, "eval.json").get<results::Evaluation>()), json);
}

TEST(Evaluation, JudgesEveryRunOfItsObjects) {
  const auto alter = [](const std::filesystem::path& data) {
    for (const auto& [run, interval] :
         {std::pair("fan/03", std::optional<std::size_t>{}), std::pair("usb-hub/02", std::optional<std::size_t>{1})}) {
      labels::Labels labels = labels::read_labels(data / run / "labels.json");
      labels.flags.push_back({interval, "in doubt", false});
      labels::write_labels(data / run / "labels.json", labels);
    }
    std::filesystem::remove(data / "usb-hub/03/labels.json");
    std::filesystem::remove(data / "usb-hub/03/truth.json");
  };
  const Trained trained({"fan", "usb-hub"}, 3, 4, alter);
  test::make_run(trained.folder / "data/mug/02", 5, true, true);  // of an object that the dataset does not have
  std::filesystem::create_directories(trained.folder / "data/mug/03");
  std::ofstream(trained.folder / "data/mug/03/events.aedat4") << "no recording";
  const windows::Dataset dataset(trained.file);
  const model::Classifier classifier(trained.bundle.folder, 1);
  const auto [evaluation, cells] = evaluate(dataset, classifier, test_runs(dataset), {.threads = 1});
  EXPECT_EQ(evaluation.whole_runs.runs, (std::vector<std::string>{"fan/02", "fan/03", "mug/02", "usb-hub/02"}))
      << "flagged ones too; 01 was learned from";
  EXPECT_EQ(evaluation.whole_runs.by_truth, evaluation.whole_runs.runs);
  ASSERT_EQ(evaluation.whole_runs.left_out.size(), 2U);
  EXPECT_EQ(evaluation.whole_runs.left_out[0].run, "mug/03");
  EXPECT_EQ(evaluation.whole_runs.left_out[1].run, "usb-hub/03");
  EXPECT_NE(evaluation.whole_runs.left_out[1].why.find("no labels"), std::string::npos);
  EXPECT_EQ(evaluation.whole_runs.decided.touches, 8U) << "by the truth, none is in doubt";
  EXPECT_EQ(cells.size(), 4 * (1 + baseline_names.size()) * (1 + curve_thresholds().size()))
      << "without thresholds, no slip is confirmed";
  // By labels, what is flagged is left out, and its time.
  for (const char* run : {"fan/02", "fan/03", "mug/02", "usb-hub/02"})
    std::filesystem::remove(trained.folder / "data" / run / "truth.json");
  const auto by_labels = evaluate(dataset, classifier, test_runs(dataset), {.threads = 1}).evaluation.whole_runs;
  EXPECT_TRUE(by_labels.by_truth.empty());
  EXPECT_EQ(by_labels.runs, (std::vector<std::string>{"fan/02", "mug/02", "usb-hub/02"}));
  ASSERT_EQ(by_labels.left_out.size(), 3U);
  EXPECT_EQ(by_labels.left_out[0].run, "fan/03");
  EXPECT_NE(by_labels.left_out[0].why.find("in doubt as a whole"), std::string::npos);
  EXPECT_EQ(by_labels.decided.touches, 5U) << "but for the flagged slip of usb-hub/02";
  double outside_s = 0;
  for (const results::Cell& cell : cells)
    outside_s += cell.setting == evaluation.models.front().name && !cell.confirmed && !cell.threshold && cell.run == "02"
                     ? cell.outside_s
                     : 0;
  EXPECT_NEAR(by_labels.decided.outside_min * 60, outside_s - 0.01, 1e-9) << "10 ms before a touch in doubt do not count";
}

TEST(Evaluation, HasCalibrationOfEveryTickOfASureClass) {
  const Trained trained;
  const windows::Dataset dataset(trained.file);
  const results::Evaluation evaluation =
      evaluate(dataset, model::Classifier(trained.bundle.folder, 1), test_runs(dataset), {.threads = 1}).evaluation;
  std::uint64_t ticks = 0, samples = 0;
  for (const results::ReliabilityBin& bin : evaluation.whole_run_calibration.bins) ticks += bin.samples;
  for (const results::ReliabilityBin& bin : evaluation.calibration.bins) samples += bin.samples;
  EXPECT_EQ(ticks, evaluation.engine.ticks) << "labels are exact here, and none is in doubt";
  EXPECT_EQ(samples, evaluation.confusion.samples());
}

TEST(Evaluation, StopsWhereARunHasChangedAndNamesIt) {
  const Trained trained;
  const windows::Dataset dataset(trained.file);
  const std::filesystem::path file = trained.folder / "data/usb-hub/02/labels.json";
  labels::Labels labels = labels::read_labels(file);
  labels.intervals[0].confirmed = true;
  labels::write_labels(file, labels);
  EXPECT_NO_THROW(windows::check_unchanged(dataset, static_cast<std::uint32_t>(dataset.runs().size() - 1)))
      << "its touches are the same";
  labels.intervals[0].end.at = labels.intervals[0].end.high = after(labels.intervals[0].end.at, 1us);
  labels::write_labels(file, labels);
  try {
    evaluate(dataset, model::Classifier(trained.bundle.folder, 1), test_runs(dataset), {.threads = 1});
    ADD_FAILURE() << "no error";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("usb-hub/02"), std::string::npos) << e.what();
  }
}

TEST(Evaluation, RefusesAModelOfAnotherDataset) {
  const Trained trained;
  windows::write_dataset(trained.folder / "data", trained.folder / "data/other.h5", {.sampling = {.seed = 2}}, 1);
  const windows::Dataset other(trained.folder / "data/other.h5");
  EXPECT_THROW(evaluate(other, model::Classifier(trained.bundle.folder, 1), test_runs(other)), Error);
}

}  // namespace
}  // namespace tactile::evaluation
