#include "tactile/report/report.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "report/plot_rows.hpp"
#include "report/prediction_text.hpp"
#include "support/error_of.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"
#include "windows/made_runs.hpp"

namespace tactile::report {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::contains;
using test::error_of;
using test::run_tactile;
using test::TemporaryFolder;

json figure(double value) { return {{"value", value}, {"low", value - 0.01}, {"high", value + 0.01}, {"n", 9}}; }

json delays(double mean) {
  json median = figure(mean), quantile = figure(412.5);
  median["is_lower_bound"] = false;
  quantile["is_lower_bound"] = true;
  const json one = {
      {"mean", figure(mean)},    {"median", figure(mean)}, {"sem", 0.5}, {"intervals", 9}, {"misses", 1}, {"early", 0},
      {"median_of_all", median}, {"p90_of_all", quantile}};
  json all = one;
  all["detected_within"] = {{{"ms", 0}, {"share", figure(0)}}, {{"ms", 500}, {"share", figure(0.875)}}};
  all["objects"] = {{"fan", one}, {"usb-hub", one}};
  return all;
}

json accuracy(double value) {
  return {{"mean", figure(value)}, {"objects", {{"fan", figure(value + 0.02)}, {"usb-hub", figure(value - 0.02)}}}};
}

json operating_point(json threshold, double alarms_per_min) {
  return {{"threshold", threshold}, {"alarms_per_min", figure(alarms_per_min)},
          {"outside_min", 2},       {"median_ms", figure(4)},
          {"p90_ms", figure(12)},   {"missed", figure(0.01)},
          {"touches", 412},         {"misses", 3}};
}

json whole_runs() {
  return {
      {"runs", {"fan/02", "usb-hub/02", "usb-hub/03"}},
      {"by_truth", {"fan/02", "usb-hub/02", "usb-hub/03"}},
      {"left_out", {{{"run", "fan/09"}, {"why", "it has no labels"}}}},
      {"units", "objects"},
      {"decided", operating_point(nullptr, 21.5)},
      {"objects", {{"fan", operating_point(nullptr, 63.5)}}},
      {"causes", {{"firm lift", 40}, {"quiet", 3}}},
      {"curve", {operating_point(1, 9.5), operating_point(3, 1.5)}},
      {"calm", {{{"at_most_per_min", 2}, {"point", operating_point(3, 1.5)}}, {{"at_most_per_min", 0.6}, {"point", nullptr}}}}};
}

json evaluation() {
  return {
      {"simulated", true},
      {"tick_ms", 2.0},
      {"model", {{"name", "m"}, {"settings", {{"rendering", {{"history_us", 40000}}}}}}},
      {"test_runs", {"fan/02", "usb-hub/02"}},
      {"accuracy", accuracy(0.9)},
      {"accuracy_by_guard",
       {{{"guard_ms", 100.0}, {"mean", figure(0.9)}},
        {{"guard_ms", 0.0}, {"mean", figure(0.85)}, {"objects", {{"fan", figure(0.8)}}}}}},
      {"baselines", {{"majority", {{"accuracy", figure(0.333)}, {"objects", {{"fan", figure(0.333)}}}}}}},
      {"confusion", {{90, 5, 5}, {1, 98, 1}, {0, 10, 90}}},
      {"delay_ms", {{"press", delays(3.25)}, {"slip", delays(4.5)}}},
      {"false_alarms_per_min", figure(21.5)},
      {"whole_runs", whole_runs()},
      {"label_uncertainty",
       {{"draws", 200},
        {"accuracy", {{"mean", 0.8875}, {"low", 0.88}, {"high", 0.91}, {"with_runs", figure(0.9)}}},
        {"delay_ms", {{"press", {{"mean", {{"mean", 3.5}, {"low", 2.75}, {"high", 4.5}, {"with_runs", figure(3.25)}}}}}}}}},
      {"calibration_whole_runs", {{"ece", figure(0.0575)}}},
      {"over_time",
       {{"press",
         {{"first", figure(0.97)},
          {"last", figure(0.8)},
          {"before_last", figure(0.915)},
          {"last_minus_before", figure(-0.115)},
          {"still_predicted", figure(0.355)}}}}},
      {"trivial",
       {{"always_press",
         {{"delay_ms",
           {{"press", {{"mean", {{"value", nullptr}}}, {"intervals", 9}, {"misses", 0}, {"early", 9}}}, {"slip", delays(6)}}}}},
        {"random", {{"delay_ms", {{"press", delays(6)}, {"slip", delays(6)}}}}}}},
      {"calibration",
       {{"ece", figure(0.03)},
        {"bins", {{{"from", 0.9}, {"to", 1.0}, {"samples", 50}, {"confidence", 0.97}, {"accuracy", figure(0.95)}}}}}}};
}

json claim(const std::string& words, const std::string& outcome) {
  return {{"id", "x"},
          {"in_words", "Above 95 % for 1 of 2 objects."},
          {"why", outcome == "cannot tell" ? "too few runs: 1 each, 3 wanted" : ""},
          {"can_be_decided", outcome != "cannot tell"},
          {"claim", words},
          {"paper", "95 %"},
          {"unit", "%"},
          {"asked", "above"},
          {"limit", 95},
          {"measured", figure(96.5)},
          {"verdict", outcome},
          {"objects", {{"fan", figure(97.25)}}},
          {"note", "a note"},
          {"all_test", {{"measured", figure(91.5)}, {"verdict", "does not"}, {"note", ""}, {"objects", json::object()}}}};
}

json whole_run(int alarms) {
  return {{"by_truth", true}, {"outside_s", 3.5}, {"in_alarm_s", 0.1}, {"alarms", {{"quiet", alarms}}}, {"wrong_class", 2}};
}

/// A study with all parts, in `folder`; `mark` goes into its names.
json write_study(const fs::path& folder, const std::string& mark = "") {
  write_json(folder / "evaluations/reported.json", evaluation());
  write_whole(folder / "runs/fan-02.csv", test::prediction_text);
  write_whole(folder / "m/history.csv", "epoch,loss,accuracy\n1,0.5,0.8\n2,0.125,0.95\n");
  write_whole(folder / "u/history.csv", "epoch,loss,accuracy\n1,0.5,0.8\n2,0.0625,0.9\n");
  write_json(folder / "m/model.json", {{"training", {{"batch", 32}, {"learning_rate", 0.001}, {"optimizer", "adam"}}},
                                       {"network", {{"input", {{"width", 128}}}}}});
  write_json(
      folder / "runs/fan-02.json",
      {{"tick_ms", 2.0},
       {"confirm", "1/1"},
       {"intervals", {{{"class", "press"}, {"start_us", 1500}, {"end_us", 5000}, {"outcome", "detected"}, {"delay_ms", 2.0}}}},
       {"true_intervals",
        {{{"class", "press"}, {"start_us", 3000}, {"end_us", 5000}, {"outcome", "detected"}, {"delay_ms", 4.0}}}},
       {"whole_run", whole_run(6)}});
  const json unseen = {
      {"mean", {{"seen", figure(0.9)}, {"held_out", figure(0.8)}, {"difference", figure(-0.1)}}},
      {"objects", {{"fan" + mark, {{"seen", figure(0.9)}, {"held_out", figure(0.8)}, {"difference", figure(-0.1)}}}}}};
  json study = {
      {"format", "tactile-study-1"},
      {"title", "A study" + mark},
      {"found", {"This was found."}},
      {"simulated", true},
      {"settings", {{"data", "data"}, {"seed", 7}}},
      {"machine", {{"cpu", "a processor" + mark}}},
      {"claims", {claim("First claim" + mark, "holds"), claim("Second claim", "cannot tell")}},
      {"histories", json::array()},
      {"left_out", {{{"run", "usb-hub/02"}, {"what", "press-1"}, {"reason", "flagged: it rings"}}}},
      {"bootstrap", {{"trainings", "One training each."}}},
      {"choice", {{"th_ms", 40}, {"model", "m40" + mark}, {"why", "It is best."}}},
      {"evaluations",
       {{{"id", "reported"}, {"th_ms", 40}, {"model", "m" + mark}, {"runs", "reported"}, {"json", "evaluations/reported.json"}}}},
      {"full_runs", {{{"run", "fan/02" + mark}, {"model", "m"}, {"th_ms", 40}, {"csv", "runs/fan-02.csv"}}}},
      {"unseen",
       {{"models", {{"seen", "m"}, {"held_out", "u"}}},
        {"trainings", {{{"seed", 1}, {"name", "u"}, {"folder", "u"}, {"history", "u/history.csv"}, {"weights_sha256", "ff"}}}},
        {"reported", unseen},
        {"all_test", nullptr}}},
      {"steps", {{{"name", "train" + mark}, {"seconds", 61.5}, {"finished_at", "2026-01-02T03:04:05Z"}, {"command", nullptr}}}}};
  for (const int history : {2, 40}) {
    study["histories"].push_back({{"th_ms", history},
                                  {"models",
                                   {{{"seed", 1},
                                     {"name", "m" + std::to_string(history) + mark},
                                     {"folder", "m"},
                                     {"history", "m/history.csv"},
                                     {"accuracy", figure(0.9)}}}},
                                  {"accuracy", {{"reported", accuracy(history == 2 ? 0.8 : 0.9)}, {"choice", nullptr}}}});
  }
  write_json(folder / "study.json", study);
  return study;
}

bool any_tells(const std::vector<std::string>& texts, const std::string& words) {
  return std::any_of(texts.begin(), texts.end(), [&](const std::string& text) { return contains(text, words); });
}

TEST(Report, OfAStudyHoldsClaimsFiguresTablesAndSettings) {
  const TemporaryFolder folder;
  write_study(folder / "study");
  test::make_run(folder / "study/data", {});
  std::vector<std::string> named;
  const ReportSummary summary =
      write_report(folder / "study", folder / "out", [&](std::string_view name) { named.emplace_back(name); });
  const std::vector<std::string> figures{"operating-curve", "frames",      "accuracy-by-history", "detection-curve", "delays",
                                         "confusion",       "reliability", "run-fan-02",          "unseen",          "training"};
  EXPECT_EQ(summary.figures, figures);
  EXPECT_EQ(named, figures);
  EXPECT_EQ(summary.claims, 2U);
  EXPECT_EQ(summary.hold, 1U);
  EXPECT_EQ(summary.do_not, 0U);
  EXPECT_TRUE(summary.simulated);
  const std::string page = read_text(summary.page);
  for (const std::string& name : figures) {
    EXPECT_TRUE(contains(page, "id=\"figure-" + name + "\"")) << name;
    EXPECT_GT(fs::file_size(folder / "out/figures" / (name + ".svg")), 1000U);
    EXPECT_GT(fs::file_size(folder / "out/figures" / (name + ".png")), 1000U);
  }
  for (const char* words : {"The data is simulated",
                            "First claim",
                            "claimed: above 95 %",
                            "Above 95 % for 1 of 2 objects.",
                            "too few runs: 1 each, 3 wanted",
                            "x: above 95 %",
                            "✓ 97.25",
                            "With one training they hold for that training only",
                            "One training each.",
                            "flagged: it rings",
                            "training optimizer",
                            "network input width",
                            "0.0625",
                            "all objects, by always_press",
                            "21.5 [",
                            "63.5 [",
                            "3 of 412",
                            "firm lift",
                            "20.00",
                            "at most 0.6",
                            "1 run is left out: fan/09, it has no labels.",
                            "at least 412.50",
                            "2.75 to 4.50",
                            "whole runs, with their shares of the classes: 5.75 %",
                            "-11.50",
                            "35.50",
                            "at the same time",
                            "96.50 % (96.49 to 96.51)",
                            "✓ holds",
                            "? cannot tell",
                            "✗ does not",
                            "a note",
                            "97.25",
                            "guard 0 ms",
                            "85.00",
                            "84.00 to 86.00",
                            "baseline majority",
                            "3.25",
                            "calibration error: 3.00 %",
                            "-10.00",
                            "a processor",
                            "61.5 s",
                            "0.1250",
                            "It is best."})
    EXPECT_TRUE(contains(page, words)) << words;
  // What was found and the curve come before everything else; what was not measured is not on the page.
  EXPECT_LT(page.find("This was found."), page.find("id=\"figure-operating-curve\""));
  EXPECT_LT(page.find("id=\"figure-operating-curve\""), page.find("Results are compared with Faris"));
  EXPECT_LT(page.find("id=\"figure-operating-curve\""), page.find("First claim"));
  EXPECT_FALSE(contains(page, "What was not measured"));
  EXPECT_TRUE(any_tells(summary.missing, "1 of the 2 claims have too few trainings, runs or objects"));
  const std::string run = read_text(folder / "out/figures/run-fan-02.svg");
  for (const char* words : {"press: 4 ms", "Above each true touch: its detection delay.",
                            "By the truth: 6 false alarms in 3.5 s outside of touches (6 quiet)", "2 episodes of the wrong class",
                            "A tick every 2 ms"})
    EXPECT_TRUE(contains(run, words)) << words;
  EXPECT_FALSE(contains(run, "press: 2 ms")) << "a simulated run is judged by its truth";
}

TEST(Report, FoldsThePapersOwnWay) {
  const TemporaryFolder folder;
  json study = write_study(folder / "study");
  json beside = study["evaluations"][0];
  beside["id"] = "all_test";
  beside["runs"] = "all_test";
  study["evaluations"].push_back(beside);
  study["unseen"]["all_test"] = study["unseen"]["reported"];
  write_json(folder / "study/study.json", study);
  const std::string page = read_text(write_report(folder / "study", folder / "out").page);
  const auto folds_around = [&page](const std::string& figure) {
    const std::size_t at = page.find("id=\"" + figure + "\"");
    EXPECT_NE(at, std::string::npos) << figure;
    int folds = 0;
    for (std::size_t i = page.find("<details>"); i < at; i = page.find("<details>", i + 1)) ++folds;
    for (std::size_t i = page.find("</details>"); i < at; i = page.find("</details>", i + 1)) --folds;
    return folds;
  };
  for (const char* figure : {"figure-delays-all-test", "figure-unseen-all-test-runs-as-in-the-paper"})
    EXPECT_EQ(folds_around(figure), 1) << figure;
  for (const char* figure : {"figure-delays", "figure-unseen"})
    EXPECT_EQ(folds_around(figure), 0) << "what is reported on is shown";
}

TEST(Report, NamesEveryHistoryThatTheTrainingsChose) {
  const TemporaryFolder folder;
  json study = write_study(folder / "study");
  json& evaluation = study["evaluations"][0];
  for (const int history : {50, 30, 40, 30}) evaluation["models"].push_back({{"name", "m"}, {"th_ms", history}});
  study["training_spread"] = {{"th_ms", 30}, {"mean", {0.9, 0.92}}, {"objects", {{"fan", {0.75, 0.925}}}}};
  study["splits"] = {{{"name", "split-001"}}, {{"name", "split-002"}}};
  study["splits_mean"]["reported"] = {{"value", -0.125}, {"low", -0.25}, {"high", -0.0625}, {"n", 10}};
  write_json(folder / "study/study.json", study);
  const std::string page = read_text(write_report(folder / "study", folder / "out").page);
  EXPECT_TRUE(contains(page, "Detection: 4 trainings, t_h 30, 40 and 50 ms, the reported runs</h2>")) << page;
  EXPECT_TRUE(contains(page, "<p>4 trainings, t_h 30, 40 and 50 ms, a tick every 2 ms"));
  EXPECT_TRUE(contains(page, "on one object their accuracies are up to 17.5 points apart (fan: 75.0 to 92.5 %)"));
  EXPECT_TRUE(contains(page, "Over 2 random splits, the accuracy on a held-out object differs by -12.50 points [-25.00, -6.25]"));
  evaluation["models"] = {{{"name", "one"}, {"th_ms", 20}}};
  write_json(folder / "study/study.json", study);
  EXPECT_TRUE(
      contains(read_text(write_report(folder / "study", folder / "out").page), "Detection: one (20 ms), the reported runs"));
}

TEST(Report, EscapesWhateverComesFromFiles) {
  const TemporaryFolder folder;
  write_study(folder / "study", " <b onerror=\"x\">'&</b><script>");
  const std::string page = read_text(write_report(folder / "study", folder / "out").page);
  EXPECT_FALSE(contains(page, "<script"));
  EXPECT_FALSE(contains(page, "<b "));
  EXPECT_TRUE(contains(page, "A study &lt;b onerror=&quot;x&quot;&gt;&#39;&amp;&lt;/b&gt;&lt;script&gt;"));
}

TEST(Report, NamesTheMissingPartsAndLeavesOldFiguresOfTheirsOut) {
  const TemporaryFolder folder;
  json study = write_study(folder / "study");
  write_report(folder / "study", folder / "out");
  write_whole(folder / "out/figures/mine.png", "a person's own");
  fs::remove(folder / "study/evaluations/reported.json");
  fs::remove(folder / "study/runs/fan-02.csv");
  study.erase("claims");
  study["unseen"] = nullptr;
  write_json(folder / "study/study.json", study);
  const ReportSummary summary = write_report(folder / "study", folder / "out");
  EXPECT_EQ(summary.figures, (std::vector<std::string>{"accuracy-by-history", "training"}));
  for (const char* words :
       {"claims were not tested", "The evaluation reported: ", "The full run fan/02: ", "figure 11", "Frames"})
    EXPECT_TRUE(any_tells(summary.missing, words)) << words;
  const std::string page = read_text(summary.page);
  EXPECT_FALSE(contains(page, "claims were not tested")) << "the command lists what is missing";
  EXPECT_FALSE(fs::exists(folder / "out/figures/delays.svg"));
  EXPECT_FALSE(fs::exists(folder / "out/figures/run-fan-02.png"));
  EXPECT_TRUE(fs::exists(folder / "out/figures/mine.png"));

  write_json(folder / "empty/study.json", {{"format", "tactile-study-1"}});
  EXPECT_TRUE(write_report(folder / "empty", folder / "empty-out").figures.empty());
}

TEST(Report, RefusesInWordsWhatIsNoStudyAndLeavesTheReportThatIsThere) {
  const TemporaryFolder folder;
  json study = write_study(folder / "study");
  const fs::path page = write_report(folder / "study", folder / "out").page;
  const std::string before = read_text(page);
  study["histories"][0]["accuracy"]["reported"]["mean"]["value"] = "much";
  write_json(folder / "study/study.json", study);
  const std::string error = error_of([&] { write_report(folder / "study", folder / "out"); });
  EXPECT_TRUE(contains(error, "'value' is string; expected a number") && contains(error, "study.json")) << error;
  EXPECT_EQ(read_text(page), before);
  write_json(folder / "study/study.json", {{"format", "another"}});
  EXPECT_TRUE(contains(error_of([&] { read_study(folder / "study"); }), "is of format 'another'; expected 'tactile-study-1'"));
  EXPECT_TRUE(contains(error_of([&] { read_study(folder / "nowhere"); }), "study.json"));
}

TEST(ReportCommand, ReportsAModelAloneAndAllOfADataset) {
  const TemporaryFolder folder;
  const auto write_model = [&](const std::string& name, int history_ms, const std::string& trained_at) {
    const fs::path model = folder / ("models/" + name);
    write_json(model / "model.json", {{"dataset", {{"file", "data/dataset.h5"}, {"manifest_hash", "abc"}, {"simulated", true}}},
                                      {"rendering", {{"history_us", 1000 * history_ms}}},
                                      {"split", {{"kind", "single-run"}}},
                                      {"trained_at", trained_at},
                                      {"weights_sha256", std::string(64, 'e')}});
    write_whole(model / "history.csv", "epoch,loss,accuracy\n1,0.5,0.8\n");
    write_json(model / "eval.json", evaluation());
  };
  write_model("a", 40, "2026-01-01");
  const auto result = run_tactile("report models/a --json --quiet", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json summary = json::parse(result.out);
  EXPECT_EQ(summary.at("title").get<std::string>(), "Results of a (simulated runs)");
  EXPECT_EQ(summary.at("page").get<std::string>(), "models/a/report/report.html");
  EXPECT_EQ(summary.at("figures"),
            json({"operating-curve", "detection-curve", "delays", "confusion", "reliability", "training"}));
  for (const char* words : {"figure 8", "figure 10", "figure 11", "claims"})
    EXPECT_TRUE(any_tells(summary.at("missing"), words)) << words;
  const std::string page = read_text(folder / "models/a/report/report.html");
  const std::size_t first = page.find("the model predicts"), last = page.find("a learned from 0 runs, and is judged on ");
  EXPECT_LT(first, last) << "five sentences";
  EXPECT_LT(last, page.find("id=\"figure-operating-curve\""));

  write_model("b", 2, "2026-01-02");
  const ReportSummary both = write_report(read_models({folder / "models/b", folder / "models/a"}, {}), folder / "out");
  EXPECT_EQ(both.figures[0], "operating-curve");
  EXPECT_EQ(both.figures[1], "accuracy-by-history");
  EXPECT_EQ(both.title, "Results of b (simulated runs)");
  const auto remarks_of = [&] { return json(read_models({folder / "models/b", folder / "models/a"}, {}).remarks).dump(); };
  EXPECT_FALSE(contains(remarks_of(), "differ in more")) << "the history alone is what they are compared by";
  json other = read_json(folder / "models/a/model.json");
  other["training"]["learning_rate"] = 0.01;
  other["dataset"]["manifest_hash"] = "abd";
  write_json(folder / "models/a/model.json", other);
  EXPECT_TRUE(contains(remarks_of(),
                       "b and a differ in more than their history: another dataset; training.learning_rate: null and 0.01."))
      << remarks_of();
  other["network"] = {{"kind", "stream"}, {"steps", 800}};
  write_json(folder / "models/a/model.json", other);
  EXPECT_TRUE(contains(remarks_of(), "b and a differ in more than their history: another kind of model; another dataset."))
      << remarks_of();

  const auto brief = run_tactile("report models/a --quiet", folder.path());
  EXPECT_LE(std::count(brief.out.begin(), brief.out.end(), '\n'), 15) << brief.out;
  EXPECT_TRUE(contains(brief.out, "parts are not in it; --verbose lists them")) << brief.out;
  EXPECT_TRUE(contains(run_tactile("report models/a --quiet --verbose", folder.path()).out, "Missing:\n- "));

  const auto nothing = run_tactile("report models", folder.path());
  EXPECT_EQ(nothing.exit_code, 1);
  EXPECT_TRUE(contains(nothing.err, "contains no study, model, trade, stress or dataset")) << nothing.err;
  write_whole(folder / "models/a/eval.json", "{\"accuracy\": 3}");
  const auto damaged = run_tactile("report models/a", folder.path());
  EXPECT_EQ(damaged.exit_code, 1);
  EXPECT_TRUE(contains(damaged.err, "eval.json: 'accuracy' is number; expected an object")) << damaged.err;
}

}  // namespace
}  // namespace tactile::report
