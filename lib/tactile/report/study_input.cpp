#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/json.hpp"
#include "tactile/report/input_parts.hpp"
#include "tactile/results/study.hpp"

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

std::string ms_words(double ms) { return std::isfinite(ms) ? fmt::format("{:g}", ms) : "-"; }

std::string seconds_text(double seconds) {
  if (!std::isfinite(seconds)) return "-";
  if (seconds < 120) return fmt::format("{:.1f} s", seconds);
  return fmt::format("{:.1f} min", seconds / 60);
}

void add_table(std::vector<ReportedTable>& tables, const std::string& caption, TableRow head, std::vector<TableRow> rows) {
  if (!rows.empty()) tables.push_back({.caption = caption, .head = std::move(head), .rows = std::move(rows)});
}

void read_claims(ReportInput& input, const results::Study& study) {
  input.claims = study.claims;
  const auto undecided =
      std::count_if(input.claims.begin(), input.claims.end(), [](const results::Claim& claim) { return !claim.can_be_decided; });
  if (undecided > 0) {
    input.missing.push_back(
        fmt::format("{} of the {} claims have too few trainings, runs or objects to be decided; another preset of 'tactile "
                    "reproduce' has more.",
                    undecided, input.claims.size()));
  }
  if (!study.bootstrap.trainings.empty()) {
    input.remarks.push_back(study.bootstrap.trainings);
    if (study.trainings.size() < 2) {
      input.missing.push_back(
          "The influence of the training: no interval includes it. 'tactile reproduce --trainings N' trains more often.");
    }
  }
  input.variance = study.variance;
  input.training_spread = words_of(study.training_spread);
  add_sentences(input.remarks, study.remarks);
  if (input.claims.empty()) input.missing.push_back("The paper's claims were not tested; 'tactile reproduce' tests them.");
  std::vector<TableRow> rows;
  for (const results::LeftOut& one : study.left_out)
    rows.push_back({one.run, one.what == "run" ? "the whole run" : one.what, one.reason});
  add_table(input.left_out, "Runs and intervals that are not used in training, choice and test", {"run", "what", "reason"},
            std::move(rows));
}

void read_histories(ReportInput& input, const results::Study& study) {
  for (const auto& [key, words] : {reported_runs, choice_runs, all_test_runs}) {
    std::vector<std::pair<double, results::Accuracy>> accuracies;
    for (const results::StudyHistory& history : study.histories) {
      if (history.accuracy[key]) accuracies.emplace_back(history.history_ms, *history.accuracy[key]);
    }
    ReportedHistories of_runs = histories_of(words, accuracies);
    of_runs.is_folded = key != "reported";
    if (!of_runs.curves.empty()) input.histories.push_back(std::move(of_runs));
  }
  if (study.histories.empty())
    input.missing.push_back("No network was trained; 'tactile reproduce' trains one for each history.");
}

/// Every training once. @return  the rows of the table of models
std::vector<TableRow> read_trainings(ReportInput& input, const results::Study& study, const fs::path& folder) {
  std::vector<TableRow> rows;
  const auto add = [&](const results::TrainedModel& model, const std::string& without_accuracy) {
    if (std::any_of(rows.begin(), rows.end(), [&](const TableRow& row) { return row[0] == model.name; })) return;
    const fs::path file = folder / model.history;
    if (is_found(input, file, "The training of " + model.name)) input.trainings.push_back(training_in(file, model.name));
    const results::Figure accuracy = model.accuracy.value_or(results::Figure{});
    rows.push_back({model.name, std::to_string(model.training), std::to_string(model.seed),
                    std::isfinite(accuracy.value) ? percent_text(accuracy) : without_accuracy,
                    model.weights_sha256.substr(0, 16)});
  };
  for (const results::StudyHistory& history : study.histories) {
    for (const results::TrainedModel& model : history.models) add(model, "-");
  }
  if (study.unseen) {
    for (const results::TrainedModel& model : study.unseen->trainings) add(model, "see Unseen objects");
  }
  for (const results::StudySplit& split : study.splits) {
    if (split.training) add(*split.training, "see Unseen objects");
  }
  return rows;
}

void read_choice(ReportInput& input, const results::Study& study) {
  if (const results::StudyChoice& choice = study.choice; !choice.model.empty()) {
    input.history_ms = choice.history_ms;
    input.remarks.push_back(fmt::format("History to use: {:g} ms, model {}. {}", choice.history_ms, choice.model, choice.why));
    if (choice.trainings.size() > 1) {
      input.remarks.push_back(fmt::format(
          "On its own runs to choose on, each training chose: {:g} ms. The reported runs are judged with these histories.",
          fmt::join(choice.trainings, ", ")));
    }
    const std::array keys{"choice", "reported", "all_test"};
    std::map<std::string, TableRow> best;
    for (std::size_t i = 0; i < keys.size(); ++i) {
      if (!choice.best[keys[i]]) continue;
      for (const auto& [object, history] : choice.best[keys[i]]->of_objects) {
        TableRow& row = best.try_emplace(object, TableRow{object, "-", "-", "-"}).first->second;
        row[i + 1] = ms_words(in_ms(history));
      }
    }
    ReportedTable table{.caption = "Best history of each object [ms], by set of runs; the shorter one where two are equal",
                        .head = {"object", "choice runs", "reported runs", "all test runs"},
                        .rows = {}};
    for (auto& [object, row] : best) table.rows.push_back(std::move(row));
    input.choice.push_back(std::move(table));
  }
  if (const results::ChosenHistory& paper = study.paper_way; !paper.model.empty()) {
    input.remarks.push_back(fmt::format("The paper's choice, made on the reported runs themselves: {:g} ms, model {}. {}",
                                        paper.history_ms, paper.model, paper.why));
  }
}

/// "5 trainings, t_h 30, 40 and 50 ms"; the name of a single one
std::string models_in(const results::StudyEvaluation& evaluation) {
  const std::vector<results::TrainedModel>& models = evaluation.models;
  if (models.size() < 2) return models.empty() ? "" : models.front().name;
  std::set<double> histories;
  for (const results::TrainedModel& model : models) {
    if (std::isfinite(model.history_ms)) histories.insert(model.history_ms);
  }
  std::string text = fmt::format("{} trainings", models.size());
  for (const double history : histories) {
    const bool is_first = history == *histories.begin(), is_last = history == *histories.rbegin();
    text += fmt::format("{}{:g}{}", is_first ? ", t_h " : is_last ? " and " : ", ", history, is_last ? " ms" : "");
  }
  return text;
}

void read_evaluations(ReportInput& input, const results::Study& study, const fs::path& folder) {
  for (const results::StudyEvaluation& entry : study.evaluations) {
    const fs::path file = folder / entry.json_file;
    if (!is_found(input, file, "The evaluation " + entry.id)) continue;
    const nlohmann::json document = read_json(file);
    input.evaluations.push_back({.id = entry.id,
                                 .model = models_in(entry),
                                 .runs = (entry.runs == "all_test" ? all_test_runs : reported_runs).second,
                                 .history_ms = entry.models.size() == 1 ? entry.models.front().history_ms : NAN,
                                 .is_folded = entry.id == "all_test",
                                 .scores = results::JsonView(document, file.string()).get<results::Evaluation>()});
  }
  if (study.evaluations.empty()) input.missing.push_back("No model was evaluated; 'tactile reproduce' evaluates.");
  for (results::ReportedRun run : study.full_runs) {
    run.csv = folder / run.csv;
    if (is_found(input, run.csv, "The full run " + run.run)) input.runs.push_back(std::move(run));
  }
  if (study.full_runs.empty())
    input.missing.push_back("No run over time (the paper's figure 10); 'tactile eval --run OBJECT/RUN' makes one.");
}

void read_unseen(ReportInput& input, const results::Study& study) {
  for (const auto& [key, words] : {reported_runs, all_test_runs}) {
    if (!study.unseen || !study.unseen->on[key] || study.unseen->on[key]->objects.empty()) continue;
    input.unseen.push_back({.runs = words, .comparison = *study.unseen->on[key], .is_folded = key != "reported"});
    input.unseen.back().comparison.models = study.unseen->models;
  }
  if (input.unseen.empty())
    input.missing.push_back("Unseen objects (the paper's figure 11) were not tested; 'tactile eval --unseen' tests them.");
  std::vector<TableRow> rows;
  for (const results::StudySplit& split : study.splits) {
    const results::SeenAndHeldOut mean = split.on.reported.value_or(results::UnseenComparison{}).mean;
    rows.push_back({split.name, fmt::format("{}", fmt::join(split.held_out, ", ")), percent_text(mean.seen),
                    percent_text(mean.held_out), percent_text(mean.difference)});
  }
  const results::Figure mean = study.splits_mean.reported.value_or(results::Figure{});
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
std::vector<TableRow> model_settings(ReportInput& input, const results::Study& study, const fs::path& folder) {
  std::vector<TableRow> rows;
  for (const results::StudyHistory& history : study.histories) {
    for (const results::TrainedModel& model : history.models) {
      const fs::path file = folder / model.folder / "model.json";
      if (!rows.empty() || model.name != study.choice.model) continue;
      if (!is_found(input, file, "The training settings of the chosen model")) continue;
      const nlohmann::json document = read_json(file);
      const results::JsonView description(document, file.string());
      for (const std::string key : {"rendering", "split", "training", "network", "result"})
        add_settings(rows, key + " ", description[key]);
    }
  }
  return rows;
}

std::vector<TableRow> training_rows(const results::Study& study) {
  std::vector<TableRow> rows;
  for (const results::StudyTraining& training : study.trainings) {
    rows.push_back({std::to_string(rows.size()), std::to_string(training.seed), ms_words(training.history_ms),
                    list_of_runs(training.train), list_of_runs(training.choice), list_of_runs(training.reported)});
  }
  return rows;
}

void read_settings(ReportInput& input, const results::Study& study, const fs::path& folder, std::vector<TableRow> models) {
  const auto add = [&](const std::string& caption, TableRow head, std::vector<TableRow> rows) {
    add_table(input.settings, caption, std::move(head), std::move(rows));
  };
  std::vector<TableRow> settings, machine, steps;
  const nlohmann::json dataset = study.dataset, bootstrap = study.bootstrap;
  add_settings(settings, "", {study.settings, "settings"});
  add_settings(settings, "dataset ", {dataset, "dataset"});
  add_settings(settings, "bootstrap ", {bootstrap, "bootstrap"});
  add("Settings and seeds", {"setting", "value"}, std::move(settings));
  add("Training settings of the chosen model, " + study.choice.model, {"setting", "value"}, model_settings(input, study, folder));
  add_settings(machine, "", {study.software, "software"});
  add_settings(machine, "", {study.machine, "machine"});
  add("Software and machine", {"what", "value"}, std::move(machine));
  if (study.machine.is_null()) input.missing.push_back("The machine that measured is not recorded.");
  add("Runs of each training", {"training", "seed", "t_h [ms]", "learned from", "to choose on", "reported"},
      training_rows(study));
  add("Models: accuracy is the mean over objects on the reported runs",
      {"model", "training", "seed", "accuracy", "weights, SHA-256"}, std::move(models));
  double total = 0;
  for (const results::StepRecord& step : study.steps) {
    steps.push_back({step.name, seconds_text(step.seconds), step.finished_at, step.command.empty() ? "-" : step.command});
    if (std::isfinite(step.seconds)) total += step.seconds;
  }
  if (!steps.empty()) steps.push_back({"sum over all steps, some of them at the same time", seconds_text(total), "", ""});
  add("Steps and their times", {"step", "duration", "finished (UTC)", "equivalent command"}, std::move(steps));
}

}  // namespace

ReportInput read_study(const fs::path& folder) {
  const fs::path file = folder / "study.json";
  const nlohmann::json document = read_json(file);
  const auto study = results::JsonView(document, file.string()).get<results::Study>();
  ReportInput input;
  input.title = study.title;
  input.simulated = study.simulated;
  input.found = study.found;
  if (input.found.empty() && !study.summary.empty()) input.found = {study.summary};
  if (const results::JsonView settings(study.settings, file.string() + ": 'settings'"); settings["data"])
    input.data = folder / settings["data"].text();
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
