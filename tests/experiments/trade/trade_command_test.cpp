#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "support/run_command.hpp"
#include "support/settings_file.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::trade {
namespace {

namespace fs = std::filesystem;

/// Three objects of three simulated runs, an epoch, and few values of few settings.
const std::string small =
    "trade --kind lenet --th 20,40 --tick-us 2000,3000,4000,5000 --factor 0.2 --resize area --denoise mean --augment none "
    "--engine fast --epochs 1 --trainings 2 --timed-ticks 600 --corners 2 --no-trial --threads "
    "2 ";

void simulate_runs(const fs::path& folder, const std::string& objects) {
  for (const std::string& command : {"simulate --preset tiny --runs 3 --objects " + objects,
                                     std::string("label --no-pictures --least-probability 0.5 --widest-onset 1000")}) {
    const auto result = test::run_tactile(command, folder);
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }
}

nlohmann::json traded(const fs::path& folder, const std::string& arguments, const std::string& command = small) {
  const auto result = test::run_tactile(command + arguments + " --json", folder);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return nlohmann::json::parse(result.out, nullptr, false);
}

const nlohmann::json* point_of(const nlohmann::json& trade, const std::string& text) {
  for (const auto& point : trade.at("points")) {
    if (point.at("text") == text) return &point;
  }
  return nullptr;
}

nlohmann::json without_times(nlohmann::json trade) {
  for (const char* key : {"steps", "steps_done", "steps_kept", "figures", "recommendation", "settings"}) trade.erase(key);
  return trade;
}

TEST(TradeCommand, TriesAStreamAndNamesIt) {
  const test::TemporaryFolder folder;
  simulate_runs(folder.path(), "plastic-container,sprayer,water-bottle");
  const std::string with_stream =
      "trade --th 40 --tick-us 2000 --factor 0.2 --resize area --denoise mean --augment none,flip+shift --engine fast "
      "--precision fp32,int8 --epochs 1 --steps 200 --trainings 2 --timed-ticks 600 --corners 2 "
      "--no-trial "
      "--threads 2 ";
  const nlohmann::json trade = traded(folder.path(), "", with_stream);
  ASSERT_TRUE(trade.is_object());
  const nlohmann::json* moved = point_of(trade, "augment flip+shift");
  ASSERT_NE(moved, nullptr);
  EXPECT_EQ(moved->at("setting").at("augment"), "flip+shift");
  const fs::path model = folder.path() / "trade" / "models" / moved->at("models").at(0).get<std::string>();
  EXPECT_EQ(read_json(model / "model.json").at("training").at("augment"), "flip,shift");
  const nlohmann::json* stream = point_of(trade, "stream");
  ASSERT_NE(stream, nullptr);
  EXPECT_EQ(stream->at("setting").at("kind"), "stream");
  EXPECT_EQ(stream->at("setting").at("th_ms"), 2);
  EXPECT_EQ(trade.at("points")[0].at("setting").at("kind"), "lenet");
  EXPECT_TRUE(stream->at("models")[0].get<std::string>().starts_with("stream-single-1-steps200")) << "its number of steps";
  EXPECT_GT(stream->at("reported").at("accuracy").at("value").get<double>(), 0.6);
  EXPECT_GT(stream->at("reported").at("us_p50").at("value").get<double>(), 0);
  EXPECT_EQ(point_of(trade, "stream, int8"), nullptr);
  EXPECT_TRUE(trade.at("not_measured").empty()) << trade.at("not_measured");
  const std::string csv = read_text(folder / "trade/trade.csv");
  EXPECT_TRUE(csv.starts_with("id,design,trainings,kind,th_ms,")) << csv.substr(0, 60);
  EXPECT_NE(csv.find("-stream,one,2,stream,2,"), std::string::npos) << csv;
  // The same again keeps all.
  EXPECT_EQ(traded(folder.path(), "", with_stream).at("steps_done"), 0);
}

TEST(TradeCommand, MeasuresSettingsAndDrawsThem) {
  const test::TemporaryFolder folder;
  simulate_runs(folder.path(), "plastic-container,sprayer,water-bottle");
  const nlohmann::json trade = traded(folder.path(), "--models models");
  ASSERT_TRUE(trade.is_object());
  EXPECT_EQ(trade.at("simulated"), true);
  EXPECT_EQ(trade.at("runs")[0].at("choice"),
            (std::vector<std::string>{"plastic-container/02", "sprayer/02", "water-bottle/02"}));
  EXPECT_EQ(trade.at("runs")[0].at("reported"),
            (std::vector<std::string>{"plastic-container/03", "sprayer/03", "water-bottle/03"}));
  EXPECT_EQ(trade.at("points")[0].at("design"), "usual");
  for (const char* text : {"t_h 20 ms", "tick 4 ms", "tick 5 ms", "int8"}) EXPECT_NE(point_of(trade, text), nullptr) << text;
  EXPECT_EQ(point_of(trade, "tick 3 ms"), nullptr);
  ASSERT_EQ(trade.at("left_out").size(), 2U) << "neither history is a whole number of 3 ms";
  EXPECT_EQ(trade.at("left_out")[0].at("tick_ms"), 3);
  EXPECT_TRUE(trade.at("not_measured").empty());

  // The same, not done again but counted.
  const std::string written = read_text(folder / "trade/trade.json");
  const nlohmann::json estimate = traded(folder.path(), "--models models --dry-run");
  EXPECT_EQ(read_text(folder / "trade/trade.json"), written);
  std::set<std::string> networks;
  for (const auto& point : trade.at("points")) {
    if (point.at("design") != "corner") networks.insert(point.at("models").at(0));
  }
  std::map<std::string, nlohmann::json> parts;
  for (const auto& part : estimate.at("parts")) parts[part.at("what")] = part;
  EXPECT_EQ(parts.at("trainings").at("count"), networks.size());
  for (const char* what : {"trainings", "predictions of whole runs"})
    EXPECT_EQ(parts.at(what).at("exist"), parts.at(what).at("count"));
  EXPECT_EQ(parts.at("trainings of combinations, at most").at("count"), 2 * 2);
  EXPECT_EQ(parts.at("further trainings, at most").at("count"), networks.size() + 4);

  // The usual setting has all trainings, and so has whatever shares its predictions. The second training has other runs.
  EXPECT_EQ(trade.at("points")[0].at("trainings"), 2);
  EXPECT_EQ(point_of(trade, "tick 4 ms")->at("trainings"), 2);
  EXPECT_TRUE(trade.at("points")[0].at("models")[1].get<std::string>().starts_with("th40-single-run02-2-epochs1"))
      << trade.at("points")[0].at("models");
  const auto& second_runs = trade.at("runs")[1];
  EXPECT_EQ(second_runs.at("train")[0], "plastic-container/02");
  EXPECT_EQ(second_runs.at("choice")[0], "plastic-container/03");
  EXPECT_EQ(second_runs.at("reported")[0], "plastic-container/01");
  EXPECT_EQ(trade.at("points")[0].at("reported").at("accuracy").at("trainings"), 2);
  const bool on_a_front = std::any_of(trade.at("points").begin(), trade.at("points").end(),
                                      [](const auto& point) { return point.at("on_accuracy_front").template get<bool>(); });
  EXPECT_TRUE(on_a_front);
  for (const auto& point : trade.at("points")) {
    const double probability = point.at("front_probability").at("accuracy");
    EXPECT_TRUE(probability >= 0 && probability <= 1) << probability;
    for (const char* runs : {"choice", "reported"}) {
      const auto& figures = point.at(runs);
      const double accuracy = figures.at("accuracy").at("value"), p50 = figures.at("us_p50").at("value");
      EXPECT_GT(accuracy, 0.2) << point.at("id");
      EXPECT_LE(accuracy, 1) << point.at("id");
      EXPECT_GT(p50, 0) << point.at("id");
      EXPECT_GE(figures.at("us_p99").at("value").get<double>(), p50);
      EXPECT_GE(figures.at("us_p999").at("value"), figures.at("us_p99").at("value"));
      EXPECT_GE(figures.at("ticks"), 600);
      EXPECT_GE(figures.at("whole_runs").at("p90_ms").at("value"), figures.at("whole_runs").at("median_ms").at("value"));
      EXPECT_EQ(figures.at("accuracy").at("n"), 3);
    }
  }
  for (const char* figure : {"trade-accuracy.svg", "trade-accuracy.png", "trade-delay.svg", "trade-delay.png",
                             "trade-budgets.svg", "trade-budgets.png"})
    EXPECT_TRUE(fs::is_regular_file(folder / "trade/figures" / figure)) << figure;
  const std::string csv = read_text(folder / "trade/trade.csv");
  EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')), 1 + 2 * trade.at("points").size());

  const auto report = test::run_tactile("report trade --json", folder.path());
  ASSERT_EQ(report.exit_code, 0) << report.err;
  const std::string page = read_text(folder / "trade/report/report.html");
  EXPECT_NE(page.find("Speed against accuracy"), std::string::npos);
  EXPECT_NE(page.find("figure-trade-delay"), std::string::npos);
  EXPECT_NE(page.find("figure-trade-budgets"), std::string::npos);

  // Nothing is done again; a constraint that no setting meets measures nothing.
  const nlohmann::json second = traded(folder.path(), "--no-figures");
  EXPECT_EQ(second.at("steps_done"), 0);
  EXPECT_EQ(without_times(second).at("points"), trade.at("points"));
  const nlohmann::json other = traded(folder.path(), "--at-least-accuracy 1 --at-most-us 0.001 --no-figures");
  EXPECT_EQ(other.at("steps_done"), 0);
  EXPECT_FALSE(other.at("recommendation").at("met"));
  EXPECT_TRUE(other.at("recommendation").at("sentence").get<std::string>().starts_with("No measured setting"));
  const auto refused = test::run_tactile(small + "--at-most-us 0.001 --no-figures --apply none.json", folder.path());
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("no setting to apply"), std::string::npos) << refused.err;
  EXPECT_FALSE(fs::exists(folder / "none.json"));
}

/// A setting must keep up with its ticks to be recommended: these are so long that it does on any machine, however busy.
TEST(TradeCommand, RecommendsASettingAsAConfigThatDetectReads) {
  const test::TemporaryFolder folder;
  simulate_runs(folder.path(), "plastic-container,sprayer,water-bottle");
  const auto windows = test::run_tactile("windows --history-ms 400", folder.path());
  ASSERT_EQ(windows.exit_code, 0) << windows.err;
  const std::string long_ticks =
      "trade --kind lenet --th 400 --tick-us 200000,400000 --factor 0.2 --resize area --denoise mean --augment none --engine "
      "fast "
      "--precision fp32 --epochs 1 --trainings 1 --timed-ticks 100 --threads 2 --at-most-us 60000000 "
      "--at-most-missed 1 --no-figures ";
  const nlohmann::json trade = traded(folder.path(), "--apply best.json", long_ticks);
  ASSERT_TRUE(trade.is_object());
  const nlohmann::json& recommendation = trade.at("recommendation");
  EXPECT_TRUE(recommendation.at("met"));
  EXPECT_NE(recommendation.at("sentence").get<std::string>().find("On runs that its trainings neither learned from"),
            std::string::npos);
  const nlohmann::json& trial = recommendation.at("trial");
  EXPECT_TRUE(trial.at("source").get<std::string>().starts_with("tcp://127.0.0.1:")) << trial;
  EXPECT_GT(trial.at("ticks").at("reported"), 10);
  EXPECT_NE(recommendation.at("sentence").get<std::string>().find("In 'tactile detect' over loopback"), std::string::npos);
  EXPECT_EQ(read_json(folder / "best.json").at("tick-us"),
            static_cast<int>(1000 * recommendation.at("setting").at("tick_ms").get<double>()));
  // The folder may be moved as a whole.
  EXPECT_EQ(read_json(folder / "best.json").at("model"), "trade/models/" + recommendation.at("model").get<std::string>());
  EXPECT_EQ(read_json(folder / "best.json").at("comment"), recommendation.at("sentence"));
  EXPECT_EQ(traded(folder.path(), "", long_ticks).at("steps_done"), 0);
  const auto detected =
      test::run_tactile("detect --config best.json --from file:data/plastic-container/03 --speed 0 --json", folder.path());
  EXPECT_EQ(detected.exit_code, 0) << detected.err;
}

TEST(TradeCommand, MarksASettingThatIsNotConfirmedAndConfirmsOneOverRuns) {
  const test::TemporaryFolder folder;
  for (const char* command : {"simulate --preset tiny --runs 4 --objects sprayer",
                              "label --no-pictures --least-probability 0.5 --widest-onset 1000", "windows --history-ms 400"}) {
    const auto result = test::run_tactile(command, folder.path());
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }
  const std::string one_setting =
      "trade --kind lenet --th 400 --tick-us 200000 --factor 0.2 --resize area --denoise mean --augment none --engine fast "
      "--precision fp32 --epochs 1 --timed-ticks 100 --threads 2 --at-most-missed 1 --no-trial "
      "--no-figures --apply best.json ";
  const auto one_training = test::run_tactile(one_setting + "--trainings 1", folder.path());
  EXPECT_EQ(one_training.exit_code, 2) << one_training.err;
  EXPECT_NE(one_training.err.find("no setting can be confirmed: 1 object and 2 reported runs of one give no 95 % interval"),
            std::string::npos)
      << one_training.err;
  EXPECT_NE(one_training.err.find("this takes about "), std::string::npos) << one_training.err;
  EXPECT_NE(one_training.out.find("best.json (a setting that is not confirmed)"), std::string::npos) << one_training.out;
  EXPECT_NE(one_training.out.find(" % of the timed ticks.\n"), std::string::npos) << one_training.out;
  EXPECT_TRUE(read_json(folder / "best.json")
                  .at("comment")
                  .get<std::string>()
                  .starts_with("Not confirmed. The setting chosen for at most 100 % of presses and slips missed or early, "));
  const std::string detect = "detect --config best.json --from file:data/sprayer/03 --speed 0";
  EXPECT_EQ(test::run_tactile(detect, folder.path()).exit_code, 0);

  // Three trainings report on all four runs.
  const auto three = test::run_tactile(one_setting + "--trainings 3 --json", folder.path());
  EXPECT_EQ(three.exit_code, 0) << three.err;
  EXPECT_EQ(three.err.find("no setting can be confirmed"), std::string::npos) << three.err;
  const nlohmann::json trade = nlohmann::json::parse(three.out, nullptr, false);
  EXPECT_EQ(trade.at("recommendation").at("met"), true) << trade.at("recommendation").at("sentence");
  EXPECT_EQ(trade.at("points")[0].at("reported").at("accuracy").at("n"), 4);
  const double interrupted = trade.at("points")[0].at("reported").at("interrupted");
  EXPECT_TRUE(interrupted >= 0 && interrupted <= 1) << interrupted;
  EXPECT_EQ(trade.at("interrupted"), interrupted) << "of the only setting";
  EXPECT_TRUE(read_json(folder / "best.json").at("comment").get<std::string>().starts_with("For at most 100 % of presses"));
}

TEST(TradeCommand, ABudgetLeavesOutWhatItDoesNotAllowAndTheNextCallResumes) {
  const test::TemporaryFolder folder;
  simulate_runs(folder.path(), "plastic-container,water-bottle");
  const std::string few =
      "trade --tick-us 2000 --factor 0.2 --resize area --denoise mean --augment none --engine fast --precision fp32 "
      "--kind lenet --epochs 1 --trainings 1 --timed-ticks 600 --no-figures --threads 2 ";
  const auto none = test::run_tactile(few + "--th 20,40 --budget-minutes 0", folder.path());
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_NE(none.err.find("a larger --budget-minutes"), std::string::npos) << none.err;
  EXPECT_FALSE(fs::exists(folder / "trade/trade.json"));
  const auto output = test::run_tactile(few + "--th 20,40", folder.path());
  ASSERT_EQ(output.exit_code, 0) << output.err;
  for (const char* words : {"part 1 of 2: one change at a time, 2 settings", "training 1 of 2: the usual network",
                            "training 2 of 2: t_h 20 ms", "judging 1 of 2, at every tick of its runs: the usual network",
                            "judging 2 of 2", "timing 600 ticks of each of 2 settings"})
    EXPECT_NE(output.err.find(words), std::string::npos) << words << '\n' << output.err;
  EXPECT_EQ(output.err.find("single-run"), std::string::npos) << "no names of files\n" << output.err;
  const nlohmann::json whole = traded(folder.path(), "--th 20,40", few);
  EXPECT_NE(point_of(whole, "t_h 20 ms"), nullptr);
  EXPECT_TRUE(whole.at("points")[0].at("reported").at("accuracy").at("low").is_null()) << "two objects of one run";
  const nlohmann::json again = traded(folder.path(), "--th 20,30,40 --budget-minutes 0", few);
  EXPECT_NE(point_of(again, "t_h 20 ms"), nullptr) << "it is trained already";
  EXPECT_EQ(point_of(again, "t_h 30 ms"), nullptr);
  ASSERT_EQ(again.at("not_measured").size(), 1U);
  EXPECT_EQ(again.at("not_measured")[0].at("setting"), "t_h 30 ms");
  // If the budget is too short for one training, the same command would never end.
  EXPECT_NE(again.at("unfinished").get<std::string>().find("a larger --budget-minutes"), std::string::npos);
  EXPECT_EQ(whole.at("unfinished"), "");
  // Another dataset: all is measured again.
  const auto redrawn = test::run_tactile("windows --seed 2", folder.path());
  ASSERT_EQ(redrawn.exit_code, 0) << redrawn.err;
  EXPECT_NE(redrawn.out.find("seed 2 instead of 1"), std::string::npos) << redrawn.out;
  const auto other = test::run_tactile(few + "--th 40", folder.path());
  EXPECT_EQ(other.exit_code, 0) << other.err;
  EXPECT_NE(other.err.find("is not the dataset that trade was measured on (seed 2 instead of 1)"), std::string::npos)
      << other.err;

  EXPECT_LE(std::count(output.out.begin(), output.out.end(), '\n'), 15) << output.out;
  for (const char* words : {"\nusual ", "\nmost accurate ", "\nfastest ", "No constraint given", "--verbose prints all"})
    EXPECT_NE(output.out.find(words), std::string::npos) << words << " in\n" << output.out;
  const auto all = test::run_tactile(few + "--th 40 --verbose", folder.path());
  EXPECT_NE(all.out.find("a star: on the"), std::string::npos) << all.out;

  test::expect_settings_of("trade/settings.json", few + "--th 40", folder.path());

  // Its models are in its own folder, so no command takes one of them unasked.
  EXPECT_FALSE(fs::exists(folder / "models"));
  EXPECT_TRUE(fs::exists(folder / "trade/models/th40-single-1-epochs1/model.json"));
  const auto unasked = test::run_tactile("detect --from sim --duration 1", folder.path());
  EXPECT_EQ(unasked.exit_code, 1);
  EXPECT_NE(unasked.err.find("models: no model; expected one, run 'tactile train' first"), std::string::npos) << unasked.err;

  // Models of another dataset in a folder that is named stay as they are.
  ASSERT_EQ(test::run_tactile("windows --seed 3", folder.path()).exit_code, 0);
  const std::string weights = read_text(folder / "trade/models/th40-single-1-epochs1/weights.safetensors");
  const nlohmann::json third = traded(folder.path(), "--th 40 --out third --models trade/models", few);
  ASSERT_TRUE(third.is_object());
  EXPECT_EQ(third.at("points")[0].at("models")[0], "th40-single-1-epochs1-2");
  EXPECT_EQ(read_text(folder / "trade/models/th40-single-1-epochs1/weights.safetensors"), weights);
}

TEST(TradeCommand, NeedsRunsToChooseOn) {
  const test::TemporaryFolder folder;
  simulate_runs(folder.path(), "plastic-container");
  const auto result = test::run_tactile(small + "--choice-runs 02,03", folder.path());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("--choice-runs"), std::string::npos) << result.err;
  EXPECT_FALSE(fs::exists(folder / "trade")) << "nothing was written";
  const auto unconstrained = test::run_tactile("trade --apply best.json", folder.path());
  EXPECT_EQ(unconstrained.exit_code, 1);
  EXPECT_NE(unconstrained.err.find("--at-most-us"), std::string::npos) << unconstrained.err;
  for (const char* delay : {"p99:30", "p90:", "0", "-3", "p90:x", "30 ms"}) {
    const auto refused = test::run_tactile("trade --at-most-delay-ms '" + std::string(delay) + "'", folder.path());
    EXPECT_NE(refused.exit_code, 0) << delay;
    EXPECT_NE(refused.err.find("p90:30"), std::string::npos) << refused.err;
  }
}

}  // namespace
}  // namespace tactile::trade
