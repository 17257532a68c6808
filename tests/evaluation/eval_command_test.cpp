#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <utility>

#include "evaluation/trained_model.hpp"
#include "support/events_in_file.hpp"
#include "support/run_command.hpp"
#include "support/settings_file.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/core/truth.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/evaluation/whole_runs.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/results/cell.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile::evaluation {
namespace {

namespace fs = std::filesystem;

using test::make_runs;
using test::run_tactile;
using test::Trained;

/// The longest of its lines, "Written to" paths left out.
std::string longest_line(const std::string& text) {
  std::string longest;
  for (const std::string& line : lines_of(text)) {
    if (!line.starts_with("Written to ") && characters_in(line) > characters_in(longest)) longest = line;
  }
  return longest;
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
  for (const char* baseline : {"event_rate", "cusum", "features"})
    expect_figure(json.at("baselines").at(baseline).at("decided").at("alarms_per_min"));
  for (const char* touch : {"press", "slip"}) {
    for (const nlohmann::json* delays : {&json.at("delay_ms"), &json.at("truth").at("delay_ms")}) {
      const auto& delay = delays->at(touch);
      expect_figure(delay.at("mean"));
      expect_figure(delay.at("median"));
      for (const char* key : {"sem", "intervals", "misses", "early", "objects"}) EXPECT_TRUE(delay.contains(key)) << key;
    }
  }
  EXPECT_EQ(json.at("confusion").size(), 3U);
  EXPECT_TRUE(json.at("simulated").get<bool>());
  const auto brief = run_tactile("eval", trained.folder.path());
  EXPECT_LE(std::count(brief.out.begin(), brief.out.end(), '\n'), 20) << brief.out;
  for (const char* line : {"\naccuracy ", "\nfalse alarms ", "\ndelay ", "\nat most 2 "})
    EXPECT_NE(brief.out.find(line), std::string::npos) << line << " in\n" << brief.out;
  EXPECT_EQ(brief.out.find("always_press"), std::string::npos);
  const auto text = run_tactile("eval --verbose", trained.folder.path());
  EXPECT_NE(text.out.find("on simulated runs"), std::string::npos);
  EXPECT_NE(text.out.find("\nevent rate "), std::string::npos);
  EXPECT_NE(text.out.find("always_press"), std::string::npos);
  EXPECT_LE(characters_in(longest_line(text.out)), 100U) << longest_line(text.out);
  expect_figure(json.at("calibration").at("ece"));
  EXPECT_EQ(json.at("calibration").at("bins").size(), 15U);
  expect_figure(json.at("truth").at("accuracy").at("mean"));
  for (const auto& point : json.at("whole_runs").at("curve")) {
    expect_figure(point.at("p90_ms"));
    expect_figure(point.at("alarms_per_min"));
  }
  EXPECT_EQ(json.at("confirm").get<std::string>(), "1/1");
}

TEST(EvalCommand, WritesTheCellsThatFiguresOfWholeRunsAreMadeFrom) {
  const Trained trained({"fan", "small-box", "usb-hub"});
  const auto result = run_tactile("eval --json --quiet", trained.folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  auto cells = results::read_cells(trained.bundle.folder / "eval-cells.csv");
  const auto of_a_baseline = [&](const results::Cell& cell) { return cell.setting != trained.bundle.name(); };
  const std::size_t of_baselines = std::erase_if(cells, of_a_baseline);
  EXPECT_EQ(of_baselines, 3 * cells.size()) << "as many of each of the three baselines";
  EXPECT_EQ(nlohmann::json::diff(whole_runs(cells, 1), json.at("whole_runs")), nlohmann::json::array());
  std::uint64_t samples = 0;
  for (const results::Cell& cell : cells) samples += cell.samples.samples();
  std::uint64_t of_confusion = 0;
  for (const auto& row : json.at("confusion")) {
    for (const auto& count : row) of_confusion += count.get<std::uint64_t>();
  }
  EXPECT_EQ(samples, of_confusion);
}

TEST(EvalCommand, ConfirmsVerdictsAndReportsIt) {
  const Trained trained({"fan", "small-box", "usb-hub"});
  const auto result = run_tactile("eval --json --confirm 12/20", trained.folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("confirm").get<std::string>(), "12/20");
  EXPECT_GE(json.at("delay_ms").at("press").at("mean").at("value").get<double>(), 24.0);
  const auto wrong = run_tactile("eval --confirm 1/2", trained.folder.path());
  EXPECT_NE(wrong.exit_code, 0);
  EXPECT_NE(wrong.err.find("more than half"), std::string::npos) << wrong.err;
}

TEST(EvalCommand, ShowsRunsOverTimeAsTableAndPictures) {
  const Trained trained;
  test::make_run(trained.folder / "elsewhere/new/07", 5, false, false);
  const auto result = run_tactile("eval --run fan/02,elsewhere/new/07 --json", trained.folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  ASSERT_EQ(json.at("runs").size(), 2U);
  EXPECT_EQ(json.at("runs").at(0).at("ticks"), 581);
  EXPECT_EQ(json.at("runs").at(0).at("intervals").size(), 2U);
  EXPECT_TRUE(json.at("runs").at(1).at("intervals").empty());
  EXPECT_TRUE(json.at("runs").at(1).at("false_alarms").is_null());
  for (const char* name : {"fan-02", "new-07"}) {
    for (const char* extension : {".csv", ".png", ".svg"})
      EXPECT_GT(std::filesystem::file_size(trained.bundle.folder / "runs" / (std::string(name) + extension)), 1000U) << name;
  }
  const auto outcome = read_json(trained.bundle.folder / "runs/fan-02.json");
  EXPECT_EQ(outcome.at("intervals"), json.at("runs").at(0).at("intervals"));
  EXPECT_EQ(outcome.at("first_event_us"), us_of(test::events_in_file(trained.folder / "data/fan/02/events.aedat4").front().t));
  const auto whole = results::JsonView(outcome.at("whole_run"), "fan-02.json").get<results::Cell>();
  EXPECT_EQ(whole.alarm_count(), json.at("runs").at(0).at("false_alarms"));
  const std::string words = results::words_of(whole), picture = read_text(trained.bundle.folder / "runs/fan-02.svg");
  EXPECT_GT(whole.outside_s, 0);
  EXPECT_NE(picture.find(words.substr(0, words.find('('))), std::string::npos) << words;
  EXPECT_TRUE(read_json(trained.bundle.folder / "runs/new-07.json").at("whole_run").is_null());
  EXPECT_FALSE(std::filesystem::exists(trained.bundle.evaluation()));

  EXPECT_EQ(run_tactile("eval --run fan/01 --out shown", trained.folder.path()).exit_code, 0);
  EXPECT_NE(read_text(trained.folder / "shown/fan-01.svg").find("learned from this run"), std::string::npos);
  const auto unknown = run_tactile("eval --run fan/09", trained.folder.path());
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_NE(unknown.err.find("fan/09: no such run"), std::string::npos) << unknown.err;
}

/// Shifts labels against the truth, flags an interval, and adds motion that nobody labels, so that every definition has its case.
void make_odd(const std::filesystem::path& data) {
  const auto alter = [&](const std::string& run, const std::function<void(labels::Labels&)>& change) {
    labels::Labels labels = labels::read_labels(data / run / "labels.json");
    change(labels);
    labels::write_labels(data / run / "labels.json", labels);
  };
  const auto shift = [](alignment::UncertainTime& time, microseconds by) {
    time = {after(time.at, by), after(time.low, by), after(time.high, by)};
  };
  alter("fan/02", [&](labels::Labels& labels) { shift(labels.intervals[0].start, -37ms); });
  alter("fan/03", [&](labels::Labels& labels) { shift(labels.intervals[1].start, 63ms); });       // early: predicted long before
  alter("small-box/02", [&](labels::Labels& labels) { shift(labels.intervals[0].start, 7ms); });  // a head start
  alter("small-box/03", [&](labels::Labels& labels) { shift(labels.intervals[0].end, -120ms); });
  alter("usb-hub/02", [](labels::Labels& labels) { labels.flags.push_back({1, "in doubt", false}); });
  alter("usb-hub/03",
        [](labels::Labels& labels) { labels.intervals[1].touch = Touch::press, labels.intervals[1].id = "press-2"; });
  for (const char* run : {"fan/02", "small-box/03"}) {
    Truth truth = read_truth(data / run / "truth.json");
    const auto motion = [](Touch touch, std::int64_t start_us, std::int64_t end_us, const char* what) {
      return TrueInterval{{touch, camera_time(start_us), camera_time(end_us)}, {}, camera_time(start_us), false, what};
    };
    truth.intervals.push_back(motion(Touch::slip, 5'560'000, 5'640'000, "firm shear"));
    truth.intervals.push_back(motion(Touch::press, 5'100'000, 5'150'000, "release"));
    truth.intervals.push_back({{Touch::press, camera_time(5'050'000), camera_time(5'090'000)}, {}, {}, false, "unseen"});
    write_truth(data / run / "truth.json", truth);
  }
  // A lift without slip, and a run that is judged by its labels.
  Truth truth = read_truth(data / "usb-hub/03/truth.json");
  truth.lift_start = truth.intervals[1].interval.start;
  truth.intervals[1].labelled = false;
  truth.intervals[1].what = "firm shear";
  write_truth(data / "usb-hub/03/truth.json", truth);
  fs::remove(data / "usb-hub/02/truth.json");
}

TEST(EvalCommand, AgreesWithAnIndependentComputation) {
  if (test::run_shell("/usr/bin/python3 -c 'import numpy'").exit_code != 0) GTEST_SKIP() << "no /usr/bin/python3 with NumPy";
  // One pass over few samples: it errs often enough.
  const Trained trained({"fan", "small-box", "usb-hub"}, 3, 1, make_odd);
  for (const auto& [confirm, file] : {std::pair("1/1", "eval.json"), std::pair("2/3", "eval-confirm-2-of-3.json"),
                                      std::pair("3/5", "eval-confirm-3-of-5.json")}) {
    const std::string options = std::string(" --quiet --confirm ") + confirm;
    const auto evaluated = run_tactile("eval" + options, trained.folder.path());
    ASSERT_EQ(evaluated.exit_code, 0) << evaluated.err;
    const auto shown =
        run_tactile("eval --run fan/02,fan/03,small-box/02,small-box/03,usb-hub/02,usb-hub/03" + options, trained.folder.path());
    ASSERT_EQ(shown.exit_code, 0) << shown.err;
    const auto checked = test::run_shell("/usr/bin/python3 '" TACTILE_TEST_SOURCES "/check_evaluation.py' models/small/" +
                                             std::string(file) + " models/small/runs data",
                                         trained.folder.path());
    EXPECT_EQ(checked.exit_code, 0) << checked.out << checked.err;
    EXPECT_NE(checked.out.find("figures agree"), std::string::npos) << checked.out;
  }
}

TEST(EvalCommand, PrintsOnsetsInSecondsSinceTheFirstEventOrInCameraTime) {
  const Trained trained({"fan", "usb-hub"}, 2, 1);
  const double first_s =
      1e-6 * static_cast<double>(us_of(test::events_in_file(trained.folder / "data/fan/02/events.aedat4").front().t));
  ASSERT_GT(first_s, 1) << "otherwise both would look alike";
  const auto labels = read_json(trained.folder / "data/fan/02/labels.json");
  const double press_s = 1e-6 * labels.at("intervals")[0].at("start_us").get<double>();
  for (const auto& [option, zero_s] : {std::pair("", first_s), std::pair(" --camera-time", 0.0)}) {
    const auto shown = run_tactile(std::string("eval --run fan/02") + option, trained.folder.path());
    ASSERT_EQ(shown.exit_code, 0) << shown.err;
    EXPECT_NE(shown.out.find(fmt::format("{:.4f}", press_s - zero_s)), std::string::npos) << shown.out;
  }
  EXPECT_NE(run_tactile("eval --camera-time", trained.folder.path()).exit_code, 0) << "needs --run";
}

TEST(EvalCommand, OptionsThatMakeOtherFiguresHaveFilesOfTheirOwn) {
  const Trained trained({"fan", "usb-hub"}, 2, 1);
  ASSERT_EQ(run_tactile("eval --quiet", trained.folder.path()).exit_code, 0);
  const std::string usual = read_text(trained.bundle.evaluation());
  const auto confirmed = run_tactile("eval --quiet --confirm 2/3", trained.folder.path());
  ASSERT_EQ(confirmed.exit_code, 0) << confirmed.err;
  EXPECT_EQ(read_text(trained.bundle.evaluation()), usual);
  EXPECT_EQ(read_json(trained.bundle.folder / "eval-confirm-2-of-3.json").at("confirm"), nlohmann::json("2/3"));
}

TEST(EvalCommand, JudgesAModelOnWhatTheDatasetHasBecome) {
  const Trained trained({"fan", "usb-hub"}, 3, 1);
  const fs::path data = trained.folder / "data";
  // A label is put right, of a run that nothing was learned from: another dataset.
  auto labels = read_json(data / "fan/02/labels.json");
  labels.at("intervals")[0]["end_us"] = labels.at("intervals")[0]["end_us"].get<std::int64_t>() - 2'000;
  write_json(data / "fan/02/labels.json", labels);
  windows::write_dataset(data, data / "dataset.h5", {}, 1);
  const auto judged = run_tactile("eval --json", trained.folder.path());
  ASSERT_EQ(judged.exit_code, 0) << judged.err;
  const auto json = nlohmann::json::parse(judged.out);
  EXPECT_EQ(json.at("model").at("name"), "small");
  EXPECT_EQ(json.at("learned_from").at("left_out"), nlohmann::json({"fan/01", "usb-hub/01"}));
  EXPECT_EQ(json.at("test_runs"), nlohmann::json({"fan/02", "fan/03", "usb-hub/02", "usb-hub/03"}));
  EXPECT_EQ(json.at("baselines").size(), 3U) << "fitted on the runs it learned from, which are there";
  EXPECT_FALSE(fs::exists(trained.bundle.evaluation()));
  EXPECT_TRUE(fs::exists(trained.bundle.folder /
                         ("eval-on-" + windows::Dataset(data / "dataset.h5").manifest_hash().substr(0, 8) + ".json")));

  // Data of which nothing was learned: all of it is judged, and no baseline is fitted.
  fs::remove_all(data / "fan/01");
  fs::remove_all(data / "usb-hub/01");
  windows::write_dataset(data, data / "dataset.h5", {}, 1);
  const auto others = run_tactile("eval --json --model small", trained.folder.path());
  ASSERT_EQ(others.exit_code, 0) << others.err;
  EXPECT_EQ(nlohmann::json::parse(others.out).at("test_runs"), json.at("test_runs"));
  EXPECT_TRUE(nlohmann::json::parse(others.out).at("baselines").empty());
}

TEST(EvalCommand, NothingThatAModelOrItsStartLearnedFromIsJudged) {
  const Trained trained({"fan", "sprayer", "usb-hub"}, 3, 1);
  const auto next = run_tactile("train --json --epochs 1 --train-run 02 --from small --name next", trained.folder.path());
  ASSERT_EQ(next.exit_code, 0) << next.err;
  const nlohmann::json thirds{"fan/03", "sprayer/03", "usb-hub/03"};
  EXPECT_EQ(nlohmann::json::parse(next.out).at("test_runs"), thirds);
  const auto judged = run_tactile("eval --json --model next", trained.folder.path());
  ASSERT_EQ(judged.exit_code, 0) << judged.err;
  EXPECT_EQ(nlohmann::json::parse(judged.out).at("test_runs"), thirds);
  const auto shown = run_tactile("eval --json --model next --run fan/01,fan/02,fan/03", trained.folder.path());
  ASSERT_EQ(shown.exit_code, 0) << shown.err;
  const auto runs = nlohmann::json::parse(shown.out).at("runs");
  EXPECT_TRUE(runs[0].at("learned_from").get<bool>()) << "its start did";
  EXPECT_TRUE(runs[1].at("learned_from").get<bool>());
  EXPECT_FALSE(runs[2].at("learned_from").get<bool>());
  fs::create_directories(trained.folder / "elsewhere/mug");
  fs::copy(trained.folder / "data/fan/01", trained.folder / "elsewhere/mug/01", fs::copy_options::recursive);
  ASSERT_EQ(run_tactile("convert data/fan/01/events.aedat4 elsewhere/mug/01/events.aedat4 --compression zstd --force",
                        trained.folder.path())
                .exit_code,
            0);
  const auto copy = run_tactile("eval --json --model models/next --run elsewhere/mug/01 --out shown", trained.folder.path());
  ASSERT_EQ(copy.exit_code, 0) << copy.err;
  EXPECT_TRUE(nlohmann::json::parse(copy.out).at("runs")[0].at("learned_from").get<bool>()) << "the same events";
  test::expect_settings_of("shown/settings.json", "eval --model models/next --run elsewhere/mug/01 --out shown",
                           trained.folder.path());
  const auto one_missing = run_tactile("eval --json --model next --run nowhere/01,fan/03", trained.folder.path());
  EXPECT_EQ(one_missing.exit_code, 1);
  EXPECT_NE(one_missing.err.find("nowhere/01: no such run"), std::string::npos) << one_missing.err;
  EXPECT_EQ(nlohmann::json::parse(one_missing.out).at("runs").size(), 1U) << "the others are shown";

  // With fan held out, a start that saw it must not be used. One that did not see it may be.
  const auto leaking =
      run_tactile("train --epochs 1 --split unseen --held-out fan --from small --name leaking", trained.folder.path());
  EXPECT_EQ(leaking.exit_code, 1);
  EXPECT_NE(leaking.err.find("learned from fan/01, but fan is held out"), std::string::npos) << leaking.err;
  const auto hint = run_tactile("eval --unseen --held-out fan --model next", trained.folder.path());
  EXPECT_EQ(hint.exit_code, 1);
  EXPECT_NE(hint.err.find("--from MODEL"), std::string::npos) << hint.err;
  for (const char* train : {"train --epochs 1 --split unseen --held-out fan --name clean",
                            "train --epochs 1 --train-run 02 --split unseen --held-out fan --from clean --name clean-next"})
    ASSERT_EQ(run_tactile(train, trained.folder.path()).exit_code, 0) << train;
  const auto compared = run_tactile("eval --json --unseen --held-out fan --model next --trainings 1", trained.folder.path());
  ASSERT_EQ(compared.exit_code, 0) << compared.err;
  const auto unseen = nlohmann::json::parse(compared.out).at("unseen");
  EXPECT_EQ(unseen.at("models").at("held_out"), nlohmann::json("clean-next"));
  EXPECT_EQ(unseen.at("runs"), nlohmann::json({"fan/03"})) << "01 and 02 were learned from by the one with fan";
}

TEST(EvalCommand, WithoutAModelNamesTheCommandThatTrainsOne) {
  const test::TemporaryFolder folder;
  make_runs(folder / "data", {"fan"}, 2);
  const auto no_dataset = run_tactile("eval", folder.path());
  EXPECT_EQ(no_dataset.exit_code, 1);
  EXPECT_NE(no_dataset.err.find("tactile train --th 40"), std::string::npos) << no_dataset.err;
  windows::write_dataset(folder / "data", folder / "data/dataset.h5", {}, 1);
  const auto no_model = run_tactile("eval", folder.path());
  EXPECT_EQ(no_model.exit_code, 1);
  EXPECT_NE(no_model.err.find("tactile train --th 40"), std::string::npos) << no_model.err;
}

TEST(EvalCommand, UnseenTrainsWhatIsMissingWithTheSettingsOfTheOther) {
  const Trained trained(test::six_objects, 2);
  const auto refused = run_tactile("eval --unseen --no-train", trained.folder.path());
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("tactile train --th 40 --split unseen --epochs 4"), std::string::npos) << refused.err;

  const auto result = run_tactile("eval --unseen --trainings 1 --json --threads 1", trained.folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("is missing: it is trained first"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("compares 1 model that saw all objects with 1 that did not; those that are missing"),
            std::string::npos)
      << result.err;
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

  const auto text = run_tactile("eval --unseen --trainings 1 --no-train", trained.folder.path());
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_NE(text.out.find("held out"), std::string::npos) << text.out;
  EXPECT_LE(characters_in(longest_line(text.out)), 100U) << longest_line(text.out);
  const auto again = run_tactile("eval --unseen --trainings 1 --no-train --json", trained.folder.path());
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(nlohmann::json::parse(again.out).at("unseen"), json.at("unseen"));
}

TEST(EvalCommand, RemarksThatARunLeavesTheSceneOfTheTrainingRuns) {
  const Trained trained;
  const fs::path folder = trained.folder.path();
  const auto usual = run_tactile("eval --json --run fan/02 --out shown", folder);
  ASSERT_EQ(usual.exit_code, 0) << usual.err;
  EXPECT_EQ(usual.err.find("scene:"), std::string::npos) << usual.err;
  EXPECT_TRUE(nlohmann::json::parse(usual.out).at("runs").at(0).at("warnings").empty());

  fs::create_directories(folder / "loud/01");
  ASSERT_EQ(run_tactile("convert --quiet data/fan/02 loud/01/events.aedat4 --stress noise:100", folder).exit_code, 0);
  const auto loud = run_tactile("eval --json --run loud/01 --out shown", folder);
  ASSERT_EQ(loud.exit_code, 0) << loud.err;
  const std::string remark = nlohmann::json::parse(loud.out).at("runs").at(0).at("warnings").at(0);
  EXPECT_NE(loud.err.find(remark), std::string::npos);
  EXPECT_TRUE(remark.starts_with("scene: 1 of 1 judged run leaves the training runs: ")) << remark;
  EXPECT_NE(remark.find("background "), std::string::npos) << remark;
}

TEST(EvalCommand, RemarksWhichJudgedRunsLeaveTheScene) {
  // The model learned from quiet runs; all others are loud.
  const Trained trained({"fan", "usb-hub"}, 2, 1, [](const fs::path& data) {
    for (const char* object : {"fan", "usb-hub"}) {
      const fs::path file = data / object / "02/events.aedat4";
      const fs::path loud = file.parent_path() / "loud.aedat4";
      const auto made = run_tactile("convert --quiet " + file.string() + " " + loud.string() + " --stress noise:100");
      ASSERT_EQ(made.exit_code, 0) << made.err;
      fs::rename(loud, file);
    }
  });
  const auto result = run_tactile("eval --json", trained.folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::string remark = nlohmann::json::parse(result.out).at("warnings").back();
  EXPECT_TRUE(remark.starts_with("scene: 2 of 2 judged runs leave the training runs: fan/02 (background ")) << remark;
  EXPECT_NE(result.err.find(remark), std::string::npos);
}

}  // namespace
}  // namespace tactile::evaluation
