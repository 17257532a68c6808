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

json quantile(double ms, bool is_lower_bound = false) {
  json of = figure(ms);
  of["is_lower_bound"] = is_lower_bound;
  return of;
}

json delays(double mean) {
  const json one = {{"mean", figure(mean)},
                    {"median", figure(mean)},
                    {"sem", 0.5},
                    {"intervals", 9},
                    {"misses", 1},
                    {"early", 0},
                    {"missed", figure(0)},
                    {"median_of_all", quantile(mean)},
                    {"p90_of_all", quantile(412.5, true)}};
  json all = one;
  all["objects"] = {{"fan", one}, {"usb-hub", one}};
  return all;
}

json accuracy(double value) {
  return {{"mean", figure(value)}, {"objects", {{"fan", figure(value + 0.02)}, {"usb-hub", figure(value - 0.02)}}}};
}

json operating_point(json threshold, double alarms_per_min) {
  return {{"threshold", threshold},
          {"alarms_per_min", figure(alarms_per_min)},
          {"outside_min", 2},
          {"median_ms", quantile(4)},
          {"p90_ms", quantile(12)},
          {"missed", figure(0.01)},
          {"touches", 412},
          {"misses", 2},
          {"early", 1}};
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
      {"calm", {{{"at_most_per_min", 2}, {"point", operating_point(3, 1.5)}}, {{"at_most_per_min", 0.6}, {"point", nullptr}}}},
      {"confirmed", operating_point(nullptr, 0.25)},
      {"confirmed_curve", {operating_point(5, 0.75), operating_point(5.5, 0.875)}}};
}

json unseen() {
  const auto lost = [](double points) {
    return json{{"seen", figure(0.9)}, {"held_out", figure(0.9 - points)}, {"difference", figure(-points)}};
  };
  return {{"runs", {"fan/02", "usb-hub/02"}}, {"mean", lost(0.1)}, {"objects", {{"fan", lost(0.05)}, {"usb-hub", lost(0.15)}}}};
}

json evaluation() {
  const json model = {{"name", "m"}, {"settings", {{"rendering", {{"history_us", 40000}}}}}};
  json training = model;
  training["test_runs"] = {"fan/02", "usb-hub/02"};
  return {{"simulated", true},
          {"tick_ms", 2.0},
          {"confirm", "1/1"},
          {"model", model},
          {"trainings", {training}},
          {"test_runs", {"fan/02", "usb-hub/02"}},
          {"accuracy", accuracy(0.9)},
          {"baselines", {{"cusum", {{"decided", whole_runs().at("decided")}, {"calm", whole_runs().at("calm")}}}}},
          {"confusion", {{90, 5, 5}, {1, 98, 1}, {0, 10, 90}}},
          {"delay_ms", {{"press", delays(3.25)}, {"slip", delays(4.5)}}},
          {"whole_runs", whole_runs()},
          {"calibration_whole_runs", {{"ece", figure(0.0575)}}},
          {"trivial",
           {{"always_press",
             {{"press", {{"mean", {{"value", nullptr}}}, {"intervals", 9}, {"misses", 0}, {"early", 9}}}, {"slip", delays(6)}}},
            {"random", {{"press", delays(7.75)}, {"slip", delays(6)}}}}},
          {"truth",
           {{"accuracy", accuracy(0.85)},
            {"confusion", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
            {"delay_ms", {{"press", delays(5.125)}, {"slip", delays(6.625)}}}}},
          {"calibration",
           {{"ece", figure(0.03)},
            {"bins", {{{"from", 0.9}, {"to", 1.0}, {"samples", 50}, {"confidence", 0.97}, {"accuracy", figure(0.95)}}}}}}};
}

json claim(const std::string& paper, int written, int replicates, const std::string& outcome, bool is_by_margin = false) {
  return {{"id", "x"},
          {"figure", "8"},
          {"paper", paper},
          {"measure", "the lowest accuracy at 40 ms"},
          {"unit", "%"},
          {"is_below", is_by_margin},
          {"limit", 95},
          {"is_by_margin", is_by_margin},
          {"written", written},
          {"replicates", replicates},
          {"measured", replicates == 0 ? json() : figure(96.5)},
          {"outcome", outcome}};
}

json whole_run(int alarms) {
  return {{"by_truth", true}, {"outside_s", 3.5}, {"in_alarm_s", 0.1}, {"alarms", {{"quiet", alarms}}}, {"wrong_class", 2}};
}

void write_run(const fs::path& runs) {
  write_whole(runs / "fan-02.csv", test::prediction_text);
  write_json(
      runs / "fan-02.json",
      {{"tick_ms", 2.0},
       {"confirm", "1/1"},
       {"intervals", {{{"class", "press"}, {"start_us", 1500}, {"end_us", 5000}, {"outcome", "detected"}, {"delay_ms", 2.0}}}},
       {"true_intervals",
        {{{"class", "press"}, {"start_us", 3000}, {"end_us", 5000}, {"outcome", "detected"}, {"delay_ms", 4.0}}}},
       {"whole_run", whole_run(6)}});
}

/// LeNets of 2 ms and 40 ms, and streams with and without their objects; whole runs of the latter three.
json results_of(const std::string& mark) {
  json settings = json::array();
  const auto add = [&](const std::string& setting, const std::string& text, json history_ms, double value, bool is_unseen,
                       const json& whole) {
    settings.push_back({{"setting", setting},
                        {"text", text + mark},
                        {"is_unseen", is_unseen},
                        {"th_ms", history_ms},
                        {"accuracy", accuracy(value)},
                        {"whole_runs", whole}});
  };
  add("th002", "LeNet, t_h 2 ms", 2, 0.8, false, nullptr);
  add("th040", "LeNet, t_h 40 ms", 40, 0.9, false, whole_runs());
  add("stream", "stream", nullptr, 0.95, false, whole_runs());
  add("th040-unseen", "LeNet, t_h 40 ms, objects never seen", 40, 0.7, true, nullptr);
  add("stream-unseen", "stream, objects never seen", nullptr, 0.75, true, whole_runs());
  return settings;
}

/// Of the first world a LeNet and a stream, of the second a LeNet.
json models_of(const fs::path& folder, const std::string& mark) {
  json models = json::array();
  const auto add = [&](int world, const std::string& setting, const std::string& loss) {
    const std::string name = setting + "-" + std::to_string(501 + world);
    write_whole(folder / name / "history.csv", "epoch,loss,accuracy\n1,0.5,0.8\n2," + loss + ",0.95\n");
    models.push_back({{"world", world},
                      {"training", 0},
                      {"setting", setting},
                      {"name", name + mark},
                      {"folder", name},
                      {"history", name + "/history.csv"},
                      {"train_run", "01"},
                      {"seed", 501 + world},
                      {"weights_sha256", std::string(64, 'e')}});
  };
  add(0, "th040", "0.125");
  add(0, "stream", "0.0625");
  add(1, "th040", "0.4375");
  return models;
}

json world(const std::string& name, const std::string& data) {
  return {{"name", name},
          {"data", data},
          {"manifest_hash", std::string(64, 'd')},
          {"runs", 18},
          {"samples", 61234},
          {"held_out", {"fan", "usb-hub"}},
          {"left_out", {{{"run", "usb-hub/02"}, {"what", "press-1"}, {"reason", "flagged: it rings in " + name}}}}};
}

/// A study with all parts, in `folder`; `mark` goes into its names.
json write_study(const fs::path& folder, const std::string& mark = "") {
  write_run(folder / "runs/stream");
  json study = {{"format", "tactile-study-2"},
                {"title", "A study" + mark},
                {"found", {"This was found."}},
                {"simulated", true},
                {"settings", {{"data", "data"}, {"seed", 7123}}},
                {"machine", {{"cpu", "a processor" + mark}}},
                {"bootstrap", {{"draws", 2345}, {"confidence", 0.95}, {"seed", 1}}},
                {"intervals", "Two worlds, and one training of each setting in each."},
                {"remarks", {"world 502, fan learned from run 02"}},
                {"worlds", {world("501", "data"), world("502", "data/502")}},
                {"models", models_of(folder, mark)},
                {"results", results_of(mark)},
                {"unseen", {{{"setting", "stream"}, {"text", "stream" + mark}, {"accuracy", unseen()}}}},
                {"full_runs", {{{"run", "fan/02" + mark}, {"model", "m"}, {"th_ms", 2}, {"csv", "runs/stream/fan-02.csv"}}}},
                {"claims",
                 {claim("First sentence" + mark, 7, 8, "holds"), claim("Second sentence", 1, 8, "does not"),
                  claim("Third sentence", 4, 8, "cannot tell", true), claim("Fourth sentence", 0, 0, "cannot tell")}},
                {"steps", {{{"name", "train" + mark}, {"seconds", 61.5}, {"finished_at", "2026-01-02"}, {"command", nullptr}}}}};
  write_json(folder / "study.json", study);
  return study;
}

/// A LeNet that was evaluated.
void write_model(const fs::path& folder, int history_ms = 40, const std::string& trained_at = "2026-01-01") {
  write_json(folder / "model.json", {{"dataset", {{"file", "data/dataset.h5"}, {"manifest_hash", "abc"}, {"simulated", true}}},
                                     {"rendering", {{"history_us", 1000 * history_ms}}},
                                     {"split", {{"kind", "single-run"}}},
                                     {"trained_at", trained_at},
                                     {"weights_sha256", std::string(64, 'e')}});
  write_whole(folder / "history.csv", "epoch,loss,accuracy\n1,0.5,0.8\n");
  write_json(folder / "eval.json", evaluation());
}

bool any_tells(const std::vector<std::string>& texts, const std::string& words) {
  return std::any_of(texts.begin(), texts.end(), [&](const std::string& text) { return contains(text, words); });
}

void expect_all(const std::string& page, const std::vector<const char*>& all) {
  for (const char* words : all) EXPECT_TRUE(contains(page, words)) << words;
}

/// Each once, as SVG and PNG, and on the page in this order.
void expect_figures(const ReportSummary& summary, const std::vector<std::string>& figures) {
  EXPECT_EQ(summary.figures, figures);
  const std::string page = read_text(summary.page);
  std::size_t last = 0;
  for (const std::string& name : figures) {
    const std::size_t at = page.find("id=\"figure-" + name + "\"");
    ASSERT_NE(at, std::string::npos) << name;
    EXPECT_GT(at, last) << name;
    last = at;
    for (const char* extension : {".svg", ".png"})
      EXPECT_GT(fs::file_size(summary.page.parent_path() / "figures" / (name + extension)), 1000U) << name;
  }
}

TEST(Report, OfAStudyHoldsItsFiguresTheMostImportantFirst) {
  const TemporaryFolder folder;
  write_study(folder / "study");
  test::make_run(folder / "study/data", {});
  std::vector<std::string> named;
  const ReportSummary summary =
      write_report(folder / "study", folder / "out", [&](std::string_view name) { named.emplace_back(name); });
  const std::vector<std::string> figures{"settings-curve",
                                         "operating-curve-stream",
                                         "operating-curve-stream-unseen",
                                         "operating-curve-th040",
                                         "frames",
                                         "accuracy-by-history",
                                         "run-fan-02-m",
                                         "unseen-stream",
                                         "training"};
  expect_figures(summary, figures);
  EXPECT_EQ(named, figures);
  EXPECT_EQ(summary.claims, 4U);
  EXPECT_EQ(summary.hold, 1U);
  EXPECT_EQ(summary.do_not, 1U);
  EXPECT_TRUE(summary.simulated);
  const std::string page = read_text(summary.page);
  EXPECT_TRUE(contains(page, "The data is simulated"));
  // What was found and the curves come before everything else.
  EXPECT_LT(page.find("This was found."), page.find("id=\"figure-settings-curve\""));
  EXPECT_LT(page.find("id=\"figure-operating-curve-th040\""), page.find("First sentence"));
  EXPECT_LT(page.find("First sentence"), page.find("id=\"figure-frames\""));
  const std::string run = read_text(folder / "out/figures/run-fan-02-m.svg");
  expect_all(run, {"press: 4 ms", "Above each true touch: its detection delay.",
                   "By the truth: 6 false alarms in 3.5 s outside of touches (6 quiet)", "2 episodes of the wrong class",
                   "A tick every 2 ms"});
  EXPECT_FALSE(contains(run, "press: 2 ms")) << "a simulated run is judged by its truth";
}

TEST(Report, OfAStudyHoldsEachSettingOnWholeRuns) {
  const TemporaryFolder folder;
  write_study(folder / "study");
  const std::string page = read_text(write_report(folder / "study", folder / "out").page);
  expect_all(page, {"<h3>stream</h3>", "<h3>stream, objects never seen</h3>", "<h3>LeNet, t_h 40 ms</h3>", "21.5 [21.5, 21.5]",
                    "63.5 [", "3 of 412", "firm lift", "20.00", "at most 2", "at most 0.6",
                    "3 whole runs, judged by the truth. 1 run is left out: fan/09, it has no labels."});
  EXPECT_FALSE(contains(page, "<h3>LeNet, t_h 2 ms</h3>")) << "it was judged on samples only";
  EXPECT_TRUE(contains(page, "<th scope=\"row\">5</th>")) << "confirmed from";
  EXPECT_FALSE(contains(page, "<th scope=\"row\">5.5</th>")) << "whole numbers are enough";
  const std::string curves = read_text(folder / "out/figures/settings-curve.svg");
  expect_all(curves, {">stream<", ">stream, objects never seen<", ">LeNet, t_h 40 ms<", "(simulated runs)"});
}

TEST(Report, OfAStudyHoldsItsSentencesAndHowOftenTheyAreWritten) {
  const TemporaryFolder folder;
  write_study(folder / "study");
  const ReportSummary summary = write_report(folder / "study", folder / "out");
  const std::string page = read_text(summary.page);
  expect_all(page, {"First sentence<small>figure 8</small>", "✓ 7 of 8</span><small>holds</small>",
                    "✗ 1 of 8</span><small>does not</small>", "? 4 of 8</span><small>cannot tell</small>",
                    "the lowest accuracy at 40 ms<small>written where it is above 95 %</small>", "a margin: below 95 %",
                    "96.50 % [96.49, 96.51]", ">unknown<", "A replicate is such a study: one training of each setting"});
  // The command names what was not tested; the page does not.
  EXPECT_TRUE(any_tells(summary.missing, "The sentence was not tested: Fourth sentence"));
  EXPECT_FALSE(any_tells(summary.missing, "Third sentence"));
  EXPECT_FALSE(contains(page, "was not tested"));
}

TEST(Report, OfAStudyHoldsAccuraciesWorldsModelsAndSettings) {
  const TemporaryFolder folder;
  write_study(folder / "study");
  const std::string page = read_text(write_report(folder / "study", folder / "out").page);
  expect_all(page, {"The mean over objects is best with 90.0 % at 40 ms, on all test runs.",
                    "82.00<small>81.00 to 83.00</small>",
                    "stream: on objects that it has never seen the accuracy changes by -10.0 points [-11.0, -9.0]",
                    "mean over 2 objects.",
                    "-15.00<small>",
                    "Two worlds, and one training of each setting in each.",
                    "world 502, fan learned from run 02.",
                    "With one training they hold for that training only",
                    "flagged: it rings in 501",
                    "flagged: it rings in 502",
                    "fan, usb-hub",
                    "dddddddddddddddd<",
                    "61234",
                    "eeeeeeeeeeeeeeee<",
                    "th040-502",
                    "0.1250",
                    "0.0625",
                    "7123",
                    "2345",
                    "a processor",
                    "61.5 s",
                    "sum over all steps, some of them at the same time"});
  EXPECT_LT(page.find(">usb-hub</th><td class=\"number\">90.00"), page.find(">fan</th><td class=\"number\">90.00"))
      << "what loses most comes first";
  EXPECT_FALSE(contains(page, "0.4375")) << "of each setting one training is drawn";
}

TEST(Report, OfAModelHoldsItsEvaluation) {
  const TemporaryFolder folder;
  write_model(folder / "net");
  write_run(folder / "net/runs");
  json comparison = unseen();
  comparison["models"] = {{"seen", "net"}, {"held_out", "other"}};
  write_json(folder / "net/eval-unseen.json", {{"unseen", comparison}});
  test::make_run(folder / "data", {});
  const ReportSummary summary = write_report(read_models({folder / "net"}, folder / "data"), folder / "out");
  expect_figures(summary,
                 {"operating-curve", "frames", "delays", "confusion", "reliability", "run-fan-02-net", "unseen", "training"});
  const std::string page = read_text(summary.page);
  expect_all(page, {"Detection: net (40 ms), 2 runs: fan/02, usb-hub/02</h2>",
                    "Model net, history 40 ms, a tick every 2 ms, confirmation 1/1.",
                    "21.5 [",
                    "63.5 [",
                    "3 of 412",
                    "1 run is left out: fan/09, it has no labels.",
                    "at most 0.6",
                    "90.00<small>89.00 to 91.00</small>",
                    ">by true class<",
                    "85.00<small>84.00 to 86.00</small>",
                    ">CUSUM<",
                    "Median delay of all presses: 3.2 ms [3.2, 3.3]; of all slips: 4.5 ms [4.5, 4.5].",
                    "Missed: 1 of 9 presses, 1 of 9 slips.",
                    "at least 412.50",
                    "all objects, by always_press",
                    "all objects, by random",
                    "7.75",
                    "Detection delay from the true onset",
                    "5.12",
                    "6.62",
                    "calibration error: 3.00 %",
                    "whole runs, with their shares of the classes: 5.75 %",
                    "net and other: on objects that it has never seen the accuracy changes by -10.0 points [-11.0, -9.0]"});
  std::size_t curves = 0;
  for (std::size_t at = page.find("What fewer false alarms cost"); at != std::string::npos;
       at = page.find("What fewer false alarms cost", at + 1))
    ++curves;
  EXPECT_EQ(curves, 2U) << "a caption and its label: the page begins with it, and does not repeat it";
}

TEST(Report, OfAModelOnRealRunsSpeaksOfNoTruth) {
  const TemporaryFolder folder;
  write_model(folder / "net");
  json real = evaluation();
  real["truth"] = nullptr;
  write_json(folder / "net/eval.json", real);
  const std::string page = read_text(write_report(read_models({folder / "net"}, {}), folder / "out").page);
  EXPECT_FALSE(contains(page, "true onset"));
  EXPECT_FALSE(contains(page, ">by true class<"));
  EXPECT_TRUE(contains(page, "Detection delay from the labelled onset"));
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
  fs::remove(folder / "study/runs/stream/fan-02.csv");
  fs::remove(folder / "study/stream-501/history.csv");
  study.erase("claims");
  study["unseen"] = nullptr;
  study["machine"] = nullptr;
  for (json& setting : study["results"]) setting["whole_runs"] = nullptr;
  write_json(folder / "study/study.json", study);
  const ReportSummary summary = write_report(folder / "study", folder / "out");
  EXPECT_EQ(summary.figures, (std::vector<std::string>{"accuracy-by-history", "training"}));
  for (const char* words : {"The full run fan/02: ", "The training of stream-501: ", "figure 11", "Frames", "machine"})
    EXPECT_TRUE(any_tells(summary.missing, words)) << words;
  const std::string page = read_text(summary.page);
  EXPECT_FALSE(contains(page, "none could be held out")) << "the command lists what is missing";
  EXPECT_FALSE(contains(page, "The paper&#39;s sentences"));
  for (const char* figure : {"settings-curve.svg", "operating-curve-th040.png", "run-fan-02-m.png", "unseen-stream.svg"})
    EXPECT_FALSE(fs::exists(folder / "out/figures" / figure)) << figure;
  EXPECT_TRUE(fs::exists(folder / "out/figures/mine.png"));

  write_json(folder / "empty/study.json", {{"format", "tactile-study-2"}});
  EXPECT_TRUE(write_report(folder / "empty", folder / "empty-out").figures.empty());
}

TEST(Report, RefusesInWordsWhatIsNoStudyAndLeavesTheReportThatIsThere) {
  const TemporaryFolder folder;
  json study = write_study(folder / "study");
  const fs::path page = write_report(folder / "study", folder / "out").page;
  const std::string before = read_text(page);
  study["results"][0]["accuracy"]["mean"]["value"] = "much";
  write_json(folder / "study/study.json", study);
  const std::string error = error_of([&] { write_report(folder / "study", folder / "out"); });
  EXPECT_TRUE(contains(error, "'value' is string; expected a number") && contains(error, "study.json")) << error;
  EXPECT_EQ(read_text(page), before);
  write_json(folder / "study/study.json", {{"format", "another"}});
  EXPECT_TRUE(contains(error_of([&] { read_study(folder / "study"); }), "'format' is 'another'; expected tactile-study-2"));
  EXPECT_TRUE(contains(error_of([&] { read_study(folder / "nowhere"); }), "study.json"));
}

TEST(ReportCommand, ReportsAModelAloneAndAllOfADataset) {
  const TemporaryFolder folder;
  write_model(folder / "models/a", 40, "2026-01-01");
  const auto result = run_tactile("report models/a --json --quiet", folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json summary = json::parse(result.out);
  EXPECT_EQ(summary.at("title").get<std::string>(), "Results of a (simulated runs)");
  EXPECT_EQ(summary.at("page").get<std::string>(), "models/a/report/report.html");
  EXPECT_EQ(summary.at("figures"), json({"operating-curve", "delays", "confusion", "reliability", "training"}));
  for (const char* words : {"figure 8", "figure 10", "figure 11", "claims"})
    EXPECT_TRUE(any_tells(summary.at("missing"), words)) << words;
  const std::string page = read_text(folder / "models/a/report/report.html");
  const std::size_t first = page.find("m, on 3 whole runs of all kinds: 21.5 [21.5, 21.5] false alarms a minute"),
                    second = page.find("m predicts 90.0 % [89.0, 91.0] of the balanced samples correctly."),
                    last = page.find("a learned from 0 runs, and is judged on 2 others.");
  EXPECT_LT(first, second);
  EXPECT_LT(second, last);
  EXPECT_LT(last, page.find("id=\"figure-operating-curve\""));

  write_model(folder / "models/b", 2, "2026-01-02");
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
