#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/report/input_parts.hpp"

namespace tactile::report {
namespace {

namespace fs = std::filesystem;

using NamedRuns = std::pair<std::string, std::string>;  // a key of study.json, and its runs in words

const NamedRuns reported_runs{"reported", "the reported runs"};
const NamedRuns choice_runs{"choice", "the choice runs"};
const NamedRuns all_test_runs{"all_test", "all test runs, as in the paper"};

std::string percent_text(const results::Figure& figure) {
  return std::isfinite(figure.value) ? fmt::format("{:.2f} %", 100 * figure.value) : "-";
}

std::string seconds_text(double seconds) {
  if (!std::isfinite(seconds)) return "-";
  if (seconds < 120) return fmt::format("{:.1f} s", seconds);
  return fmt::format("{:.1f} min", seconds / 60);
}

void add_table(std::vector<ReportedTable>& tables, const std::string& caption, TableRow head, std::vector<TableRow> rows) {
  if (!rows.empty()) tables.push_back({.caption = caption, .head = std::move(head), .rows = std::move(rows)});
}

void read_claims(ReportInput& input, const results::JsonView& study) {
  input.claims = study["claims"].list_of<results::Claim>();
  const auto undecided =
      std::count_if(input.claims.begin(), input.claims.end(), [](const results::Claim& claim) { return !claim.can_be_decided; });
  if (undecided > 0) {
    input.missing.push_back(
        fmt::format("{} of the {} claims have too few trainings, runs or objects to be decided; another preset of 'tactile "
                    "reproduce' has more.",
                    undecided, input.claims.size()));
  }
  if (const std::string trainings = study["bootstrap"]["trainings"].text(); !trainings.empty()) {
    input.remarks.push_back(trainings);
    if (study["trainings"].items().size() < 2) {
      input.missing.push_back(
          "The influence of the training: no interval includes it. 'tactile reproduce --trainings N' trains more often.");
    }
  }
  if (const results::JsonView variance = study["variance"]) {
    input.variance = variance.get<results::VarianceShares>();
  }
  input.training_spread = study["training_spread"]["in_words"].text();
  add_sentences(input.remarks, study["remarks"]);
  if (input.claims.empty()) input.missing.push_back("The paper's claims were not tested; 'tactile reproduce' tests them.");
  std::vector<TableRow> rows;
  for (const results::JsonView& one : study["left_out"].items()) {
    const std::string what = one["what"].text();
    rows.push_back({one["run"].text(), what == "run" ? "the whole run" : what, one["reason"].text()});
  }
  add_table(input.left_out, "Runs and intervals that are not used in training, choice and test", {"run", "what", "reason"},
            std::move(rows));
}

void read_histories(ReportInput& input, const results::JsonView& study) {
  const std::vector<results::JsonView> histories = study["histories"].items();
  for (const auto& [key, words] : {reported_runs, choice_runs, all_test_runs}) {
    std::vector<std::pair<double, results::JsonView>> accuracies;
    for (const results::JsonView& history : histories)
      accuracies.emplace_back(history["th_ms"].number(), history["accuracy"][key]);
    ReportedHistories of_runs = histories_of(words, accuracies);
    of_runs.is_folded = key != "reported";
    if (!of_runs.curves.empty()) input.histories.push_back(std::move(of_runs));
  }
  if (histories.empty()) input.missing.push_back("No network was trained; 'tactile reproduce' trains one for each history.");
}

/// Every training once. @return  the rows of the table of models
std::vector<TableRow> read_trainings(ReportInput& input, const results::JsonView& study, const fs::path& folder) {
  std::vector<TableRow> rows;
  const auto add = [&](const results::JsonView& model, const std::string& without_accuracy) {
    const std::string name = model["name"].text();
    if (!model || std::any_of(rows.begin(), rows.end(), [&](const TableRow& row) { return row[0] == name; })) return;
    const fs::path file = folder / model["history"].text();
    if (is_found(input, file, "The training of " + name)) input.trainings.push_back(training_in(file, name));
    const results::Figure accuracy = model["accuracy"].get<results::Figure>();
    rows.push_back({name, model["training"].words(), model["seed"].words(),
                    std::isfinite(accuracy.value) ? percent_text(accuracy) : without_accuracy,
                    model["weights_sha256"].text().substr(0, 16)});
  };
  for (const results::JsonView& history : study["histories"].items()) {
    for (const results::JsonView& model : history["models"].items()) add(model, "-");
  }
  for (const results::JsonView& model : study["unseen"]["trainings"].items()) add(model, "see Unseen objects");
  for (const results::JsonView& split : study["splits"].items()) add(split["training"], "see Unseen objects");
  return rows;
}

void read_choice(ReportInput& input, const results::JsonView& study) {
  if (const results::JsonView choice = study["choice"]) {
    input.history_ms = choice["th_ms"].number();
    input.remarks.push_back(
        fmt::format("History to use: {:g} ms, model {}. {}", input.history_ms, choice["model"].text(), choice["why"].text()));
    if (choice["trainings"].items().size() > 1) {
      input.remarks.push_back(fmt::format(
          "On its own runs to choose on, each training chose: {} ms. The reported runs are judged with these histories.",
          choice["trainings"].words()));
    }
    const std::array<std::string, 3> keys{"choice", "reported", "all_test"};
    std::map<std::string, std::array<std::string, 3>> best;
    for (std::size_t i = 0; i < keys.size(); ++i) {
      for (const auto& [object, ms] : choice["best"][keys[i]]["objects"].members()) best[object][i] = ms.words();
    }
    ReportedTable table{.caption = "Best history of each object [ms], by set of runs; the shorter one where two are equal",
                        .head = {"object", "choice runs", "reported runs", "all test runs"},
                        .rows = {}};
    for (const auto& [object, values] : best) {
      TableRow row{object};
      for (const std::string& value : values) row.push_back(value.empty() ? "-" : value);
      table.rows.push_back(std::move(row));
    }
    input.choice.push_back(std::move(table));
  }
  if (const results::JsonView paper = study["paper_way"]) {
    input.remarks.push_back(fmt::format("The paper's choice, made on the reported runs themselves: {:g} ms, model {}. {}",
                                        paper["th_ms"].number(), paper["model"].text(), paper["why"].text()));
  }
}

/// "5 trainings, t_h 30, 40 and 50 ms"; the name of a single one
std::string models_in(const results::JsonView& evaluation) {
  const std::vector<results::JsonView> models = evaluation["models"].items();
  if (models.size() < 2) return models.empty() ? evaluation["model"].text() : models.front()["name"].text();
  std::set<double> histories;
  for (const results::JsonView& model : models) {
    if (const double history = model["th_ms"].number(); std::isfinite(history)) histories.insert(history);
  }
  std::string text = fmt::format("{} trainings", models.size());
  for (const double history : histories) {
    const bool is_first = history == *histories.begin(), is_last = history == *histories.rbegin();
    text += fmt::format("{}{:g}{}", is_first ? ", t_h " : is_last ? " and " : ", ", history, is_last ? " ms" : "");
  }
  return text;
}

/// The history of a single model; NaN of several, whose histories `models_in` names
double history_of(const results::JsonView& evaluation) {
  const std::vector<results::JsonView> models = evaluation["models"].items();
  if (models.size() > 1) return NAN;
  return models.empty() ? evaluation["th_ms"].number() : models.front()["th_ms"].number();
}

void read_evaluations(ReportInput& input, const results::JsonView& study, const fs::path& folder) {
  for (const results::JsonView& entry : study["evaluations"].items()) {
    const std::string id = entry["id"].text();
    const fs::path file = folder / entry["json"].text();
    if (!is_found(input, file, "The evaluation " + id)) continue;
    const nlohmann::json document = read_json(file);
    input.evaluations.push_back({.id = id,
                                 .model = models_in(entry),
                                 .runs = (entry["runs"].text() == "all_test" ? all_test_runs : reported_runs).second,
                                 .history_ms = history_of(entry),
                                 .is_folded = id == "all_test",
                                 .scores = results::JsonView(document, file.string()).get<results::Evaluation>()});
  }
  if (study["evaluations"].items().empty()) input.missing.push_back("No model was evaluated; 'tactile reproduce' evaluates.");
  for (const results::JsonView& run : study["full_runs"].items()) {
    const fs::path csv = folder / run["csv"].text();
    if (is_found(input, csv, "The full run " + run["run"].text())) {
      input.runs.push_back({.run = run["run"].text(),
                            .model = run["model"].text(),
                            .history_ms = run["th_ms"].number(),
                            .csv = csv,
                            .outcome = fs::path(csv).replace_extension(".json")});
    }
  }
  if (study["full_runs"].items().empty())
    input.missing.push_back("No run over time (the paper's figure 10); 'tactile eval --run OBJECT/RUN' makes one.");
}

void read_unseen(ReportInput& input, const results::JsonView& study) {
  const results::JsonView unseen = study["unseen"];
  for (const auto& [key, words] : {reported_runs, all_test_runs}) {
    UnseenSection section{
        .runs = words, .comparison = unseen[key].get<results::UnseenComparison>(), .is_folded = key != "reported"};
    section.comparison.models = unseen["models"].get<results::UnseenComparison::Models>();
    if (!section.comparison.objects.empty()) input.unseen.push_back(std::move(section));
  }
  if (input.unseen.empty())
    input.missing.push_back("Unseen objects (the paper's figure 11) were not tested; 'tactile eval --unseen' tests them.");
  std::vector<TableRow> rows;
  for (const results::JsonView& split : study["splits"].items()) {
    const results::SeenAndHeldOut mean = split["reported"]["mean"].get<results::SeenAndHeldOut>();
    rows.push_back({split["name"].text(), split["held_out"].words(), percent_text(mean.seen), percent_text(mean.held_out),
                    percent_text(mean.difference)});
  }
  const results::Figure mean = study["splits_mean"]["reported"].get<results::Figure>();
  if (!rows.empty() && std::isfinite(mean.value)) {
    input.remarks.push_back(fmt::format(
        "Over {} random splits, the accuracy on a held-out object differs by {} (mean over {} objects) from that of the "
        "same training with it.",
        rows.size(), results::text_of(results::scaled(mean, 100), " points", "+.2f"), mean.n));
    if (std::string note = results::note_on_intervals({mean}); !note.empty()) input.remarks.push_back(std::move(note));
  }
  add_table(input.splits, "Other random splits with five held-out objects: accuracy on them, on the reported runs",
            {"split", "held out", "seen", "held out", "difference"}, std::move(rows));
}

/// What the chosen model was trained with.
std::vector<TableRow> model_settings(ReportInput& input, const results::JsonView& study, const fs::path& folder) {
  std::vector<TableRow> rows;
  const results::JsonView choice = study["choice"];
  for (const results::JsonView& history : study["histories"].items()) {
    for (const results::JsonView& model : history["models"].items()) {
      const fs::path file = folder / model["folder"].text() / "model.json";
      if (!rows.empty() || !choice || model["name"].text() != choice["model"].text()) continue;
      if (!is_found(input, file, "The training settings of the chosen model")) continue;
      const nlohmann::json document = read_json(file);
      const results::JsonView description(document, file.string());
      for (const std::string key : {"rendering", "split", "training", "network", "result"})
        add_settings(rows, key + " ", description[key]);
    }
  }
  return rows;
}

std::vector<TableRow> training_rows(const results::JsonView& study) {
  std::vector<TableRow> rows;
  for (const results::JsonView& training : study["trainings"].items()) {
    const results::JsonView runs = training["runs"];
    rows.push_back({std::to_string(rows.size()), training["seed"].words(), training["th_ms"].words(),
                    list_of_runs(runs["train"].texts()), list_of_runs(runs["choice"].texts()),
                    list_of_runs(runs["reported"].texts())});
  }
  return rows;
}

void read_settings(ReportInput& input, const results::JsonView& study, const fs::path& folder, std::vector<TableRow> models) {
  const auto add = [&](const std::string& caption, TableRow head, std::vector<TableRow> rows) {
    add_table(input.settings, caption, std::move(head), std::move(rows));
  };
  std::vector<TableRow> settings, machine, steps;
  add_settings(settings, "", study["settings"]);
  add_settings(settings, "dataset ", study["dataset"]);
  add_settings(settings, "bootstrap ", study["bootstrap"]);
  add("Settings and seeds", {"setting", "value"}, std::move(settings));
  add("Training settings of the chosen model, " + study["choice"]["model"].text(), {"setting", "value"},
      model_settings(input, study, folder));
  add_settings(machine, "", study["software"]);
  add_settings(machine, "", study["machine"]);
  add("Software and machine", {"what", "value"}, std::move(machine));
  if (!study["machine"]) input.missing.push_back("The machine that measured is not recorded.");
  add("Runs of each training", {"training", "seed", "t_h [ms]", "learned from", "to choose on", "reported"},
      training_rows(study));
  add("Models: accuracy is the mean over objects on the reported runs",
      {"model", "training", "seed", "accuracy", "weights, SHA-256"}, std::move(models));
  double total = 0;
  for (const results::JsonView& step : study["steps"].items()) {
    const double seconds = step["seconds"].number();
    steps.push_back(
        {step["name"].text(), seconds_text(seconds), step["finished_at"].text(), step["command"] ? step["command"].text() : "-"});
    if (std::isfinite(seconds)) total += seconds;
  }
  if (!steps.empty()) steps.push_back({"sum over all steps, some of them at the same time", seconds_text(total), "", ""});
  add("Steps and their times", {"step", "duration", "finished (UTC)", "equivalent command"}, std::move(steps));
}

}  // namespace

ReportInput read_study(const fs::path& folder) {
  const fs::path file = folder / "study.json";
  const nlohmann::json document = read_json(file);
  const results::JsonView study(document, file.string());
  if (const std::string format = study["format"].text(); format != "tactile-study-1")
    throw Error(fmt::format("{}: is of format '{}'; expected 'tactile-study-1'", file.string(), format));
  ReportInput input;
  input.title = study["title"].text();
  input.simulated = study["simulated"].truth();
  input.found = study["found"].texts();
  if (const std::string summary = study["summary"].text(); input.found.empty() && !summary.empty()) input.found = {summary};
  if (const results::JsonView data = study["settings"]["data"]) input.data = folder / data.text();
  read_claims(input, study);
  read_histories(input, study);
  std::vector<TableRow> models = read_trainings(input, study, folder);
  read_choice(input, study);
  read_evaluations(input, study, folder);
  read_unseen(input, study);
  read_settings(input, study, folder, std::move(models));
  return input;
}

}  // namespace tactile::report
