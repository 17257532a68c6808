#include "tactile/report/report_input.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string_view>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/results/accuracy.hpp"
#include "tactile/results/json_view.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;

using Row = std::vector<std::string>;

std::optional<DelayTable> delays_if_there(const JsonView& json) {
  return json ? std::optional(json.get<DelayTable>()) : std::nullopt;
}

/// Of a detector: the network, or a trivial one.
ReportedFalseAlarms false_alarms_of(const std::string& name, const JsonView& detector) {
  const JsonView alarms = detector["false_alarms"];
  return {.of = name,
          .per_min = detector["false_alarms_per_min"].get<Figure>(),
          .press = detector["delay_ms"]["press"].get<DelaySummary>(),
          .slip = detector["delay_ms"]["slip"].get<DelaySummary>(),
          .count = alarms["count"].count_if_there(),
          .after_intervals = alarms["after_intervals"]["count"].count_if_there(),
          .unlabelled = alarms["unlabelled"]["count"].count_if_there(),
          .none_min = alarms["none_min"].number()};
}

/// Puts an accuracy, or what is made like one, beside those that are there.
void add_accuracy(ReportedEvaluation& evaluation, const std::string& name, const JsonView& mean, const JsonView& objects) {
  if (!mean && !objects) return;
  const std::size_t before = evaluation.accuracy_of.size();
  evaluation.accuracy_of.push_back(name);
  const auto put = [&](const std::string& object, const Figure& value) {
    auto found = std::find_if(evaluation.accuracies.begin(), evaluation.accuracies.end(),
                              [&](const ReportedAccuracy& row) { return row.object == object; });
    if (found == evaluation.accuracies.end()) {
      evaluation.accuracies.push_back({.object = object, .values = std::vector<Figure>(before)});
      found = std::prev(evaluation.accuracies.end());
    }
    found->values.push_back(value);
  };
  put("mean over objects", mean.get<Figure>());
  for (const auto& [object, value] : objects.members()) put(object, value.get<Figure>());
  for (ReportedAccuracy& row : evaluation.accuracies) row.values.resize(before + 1);
}

ReportedEvaluation evaluation_of(const JsonView& json) {
  ReportedEvaluation evaluation;
  evaluation.model = json["model"]["name"].text();
  const double history_us = json["model"]["settings"]["rendering"]["history_us"].number();
  evaluation.history_ms = history_us / 1000;
  evaluation.tick_ms = json["tick_ms"].number();
  evaluation.guard_ms = json["guard_ms"].number();
  evaluation.confirm = json["confirm"].text();
  add_accuracy(evaluation, "network", json["accuracy"]["mean"], json["accuracy"]["objects"]);
  const std::vector<JsonView> guards = json["accuracy_by_guard"].items();
  for (const JsonView& guard : guards) {
    // The first is the dataset's own, which is told already.
    if (&guard == &guards.front()) continue;
    add_accuracy(evaluation, fmt::format("guard {:g} ms", guard["guard_ms"].number()), guard["mean"], guard["objects"]);
  }
  for (const auto& [name, baseline] : json["baselines"].members())
    add_accuracy(evaluation, "baseline " + name, baseline["accuracy"], baseline["objects"]);
  add_accuracy(evaluation, "by the truth", json["accuracy_true"]["mean"], json["accuracy_true"]["objects"]);

  if (const JsonView confusion = json["confusion"]) evaluation.confusion = confusion.get<Confusion>();
  for (const Touch touch : all_touches) {
    const JsonView scores = json["per_class"][name_of(touch)];
    if (scores) {
      evaluation.per_class.emplace_back(name_of(touch), std::array{scores["precision"].get<Figure>(),
                                                                   scores["recall"].get<Figure>(), scores["f1"].get<Figure>()});
    }
  }
  evaluation.press = json["delay_ms"]["press"].get<DelayTable>();
  evaluation.slip = json["delay_ms"]["slip"].get<DelayTable>();
  evaluation.true_press = delays_if_there(json["delay_true_ms"]["press"]);
  evaluation.true_slip = delays_if_there(json["delay_true_ms"]["slip"]);
  evaluation.gross_slip = delays_if_there(json["delay_gross_ms"]["slip"]);
  if (json["false_alarms_per_min"]) {
    evaluation.false_alarms.push_back(false_alarms_of("network", json));
    evaluation.own_point = OperatingPoint{.press = evaluation.press.all,
                                          .slip = evaluation.slip.all,
                                          .false_alarms_per_min = json["false_alarms_per_min"].get<Figure>()};
  }
  for (const auto& [name, trivial] : json["trivial"].members()) evaluation.false_alarms.push_back(false_alarms_of(name, trivial));
  evaluation.operating_curve = json["operating_curve"].list_of<OperatingPoint>();
  evaluation.calibration = json["calibration"].get<Calibration>();
  for (const std::string name : {"press", "slip", "both"}) {
    if (const JsonView of = json["over_time"][name]) evaluation.over_time.emplace(name, of.get<AccuracyOverTime>());
  }
  return evaluation;
}

/// The rows of `history.csv`; columns by their names.
TrainingCurve training_in(const fs::path& file, const std::string& name) {
  const std::string text = read_text(file, std::size_t{16} << 20);
  TrainingCurve curve{.name = name, .epochs = {}};
  std::map<std::string, std::size_t, std::less<>> place;
  std::size_t line_number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line(text.data() + begin, end - begin);
    begin = end + 1;
    ++line_number;
    std::vector<std::string_view> fields;
    for (std::size_t from = 0;;) {
      const std::size_t to = std::min(line.find(',', from), line.size());
      fields.push_back(line.substr(from, to - from));
      if (to == line.size()) break;
      from = to + 1;
    }
    if (line_number == 1) {
      for (std::size_t i = 0; i < fields.size(); ++i) place.emplace(std::string(fields[i]), i);
      if (!place.contains("epoch") || !place.contains("loss")) {
        throw Error(fmt::format("{}: has no columns 'epoch' and 'loss'; expected the history of a training", file.string()));
      }
      continue;
    }
    if (line.empty()) continue;
    const auto value = [&](std::string_view column) {
      const auto found = place.find(column);
      if (found == place.end() || found->second >= fields.size()) return std::numeric_limits<double>::quiet_NaN();
      return number_in(fields[found->second]).value_or(std::numeric_limits<double>::quiet_NaN());
    };
    curve.epochs.push_back({.epoch = value("epoch"),
                            .loss = value("loss"),
                            .accuracy = value("accuracy"),
                            .later_accuracy = value("validation_accuracy")});
  }
  return curve;
}

/// Mean first, then objects by name, from accuracies at several histories.
ReportedHistories histories_of(const std::string& runs, const std::vector<std::pair<double, JsonView>>& accuracies) {
  ReportedHistories histories{.runs = runs, .curves = {}};
  HistoryCurve mean{.name = "mean over objects", .points = {}};
  std::map<std::string, HistoryCurve> objects;
  for (const auto& [history_ms, accuracy] : accuracies) {
    if (!accuracy) continue;
    const Accuracy read = accuracy.get<Accuracy>();
    mean.points.push_back({.history_ms = history_ms, .accuracy = read.mean});
    for (const auto& [object, value] : read.objects) {
      objects[object].name = object;
      objects[object].points.push_back({.history_ms = history_ms, .accuracy = value});
    }
  }
  if (mean.points.empty()) return histories;
  histories.curves.push_back(std::move(mean));
  for (auto& [name, curve] : objects) histories.curves.push_back(std::move(curve));
  return histories;
}

/// The members of an object as a table of two columns, objects in it by their paths.
void add_settings(std::vector<Row>& rows, const std::string& prefix, const JsonView& json) {
  for (const auto& [key, value] : json.members()) {
    if (value.is_object())
      add_settings(rows, prefix + key + " ", value);
    else
      rows.push_back({prefix + key, value ? value.words() : "-"});
  }
}

std::string seconds_text(double seconds) {
  if (!std::isfinite(seconds)) return "-";
  if (seconds < 120) return fmt::format("{:.1f} s", seconds);
  return fmt::format("{:.1f} min", seconds / 60);
}

/// `shown` where the file is there; else it is told as missing.
bool is_there(ReportInput& input, const fs::path& file, std::string_view what) {
  std::error_code ignored;
  if (fs::is_regular_file(file, ignored)) return true;
  input.missing.push_back(fmt::format("{}: {} is not there.", what, file.string()));
  return false;
}

std::string list_of(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return names.empty() ? "none" : fmt::format("{} runs: {}", names.size(), text);
}

/// Each with the full stop that lines of a log go without.
void add_sentences(std::vector<std::string>& sentences, const JsonView& lines) {
  for (const std::string& line : lines.texts()) sentences.push_back(line.ends_with('.') ? line : line + ".");
}

}  // namespace

ReportInput read_study(const fs::path& folder) {
  const fs::path file = folder / "study.json";
  const nlohmann::json document = read_json(file);
  const JsonView study(document, file.string());
  if (const std::string format = study["format"].text(); format != "tactile-study-1")
    throw Error(fmt::format("{}: is of format '{}'; expected 'tactile-study-1'", file.string(), format));

  ReportInput input;
  input.title = study["title"].text();
  input.simulated = study["simulated"].truth();
  input.summary = study["summary"].text();
  if (const JsonView data = study["settings"]["data"]) input.data = folder / data.text();

  input.claims = study["claims"].list_of<Claim>();
  const auto not_told =
      std::count_if(input.claims.begin(), input.claims.end(), [](const Claim& claim) { return !claim.can_be_told; });
  if (not_told > 0) {
    input.missing.push_back(fmt::format(
        "For {} of the {} claims there are too few runs or objects for a verdict, whatever they say; another preset of 'tactile "
        "reproduce' has more.",
        not_told, input.claims.size()));
  }
  if (const std::string trainings = study["bootstrap"]["trainings"].text(); !trainings.empty()) {
    input.remarks.push_back(trainings);
    input.missing.push_back("What another seed would change: no interval holds it. 'tactile reproduce --seeds N' trains more.");
  }
  add_sentences(input.remarks, study["remarks"]);
  ReportedTable left_out{.caption = "Runs and intervals left out of training, choice and test, and why",
                         .head = {"run", "what", "reason"},
                         .rows = {}};
  for (const JsonView& one : study["left_out"].items())
    left_out.rows.push_back(
        {one["run"].text(), one["what"].text() == "run" ? "the whole run" : one["what"].text(), one["reason"].text()});
  if (!left_out.rows.empty()) input.left_out.push_back(std::move(left_out));
  if (input.claims.empty()) input.missing.push_back("The paper's claims were not judged; 'tactile reproduce' does so.");

  for (const auto& [key, words] : {std::pair<std::string, std::string>{"reported", "the runs reported on"},
                                   {"choice", "the runs that settings were chosen on"},
                                   {"all_test", "all test runs, as in the paper"}}) {
    std::vector<std::pair<double, JsonView>> accuracies;
    for (const JsonView& history : study["histories"].items())
      accuracies.emplace_back(history["th_ms"].number(), history["accuracy"][key]);
    ReportedHistories histories = histories_of(words, accuracies);
    histories.is_beside = key != "reported";
    if (!histories.curves.empty()) input.histories.push_back(std::move(histories));
  }
  std::vector<Row> seeds;
  std::vector<std::string> told;
  const auto add_model = [&](const JsonView& model, const std::string& without_accuracy) {
    const std::string name = model["name"].text();
    if (!model || std::find(told.begin(), told.end(), name) != told.end()) return;
    told.push_back(name);
    const fs::path history_file = folder / model["history"].text();
    if (is_there(input, history_file, "The training of " + name)) input.trainings.push_back(training_in(history_file, name));
    const Figure accuracy = model["accuracy"].get<Figure>();
    seeds.push_back({name, model["seed"].words(),
                     std::isfinite(accuracy.value) ? fmt::format("{:.2f} %", 100 * accuracy.value) : without_accuracy,
                     model["weights_sha256"].text().substr(0, 16)});
  };
  for (const JsonView& history : study["histories"].items()) {
    for (const JsonView& model : history["models"].items()) add_model(model, "-");
  }
  for (const JsonView& model : study["unseen"]["trainings"].items()) add_model(model, "held-out objects, see there");
  for (const JsonView& split : study["splits"].items()) add_model(split["training"], "held-out objects, see there");
  if (study["histories"].items().empty()) input.missing.push_back("No history was trained for; 'tactile reproduce' does so.");

  const JsonView choice = study["choice"];
  if (choice) {
    input.history_ms = choice["th_ms"].number();
    input.remarks.push_back(fmt::format("History of the study: {:g} ms, model {}. {}", choice["th_ms"].number(),
                                        choice["model"].text(), choice["why"].text()));
    ReportedTable best{.caption = "The best history of each object [ms], by the runs it is chosen on; the shorter of equals.",
                       .head = {"object", "choice runs", "reported runs", "all test runs"},
                       .rows = {}};
    std::map<std::string, std::array<std::string, 3>> rows;
    const std::array<std::string, 3> keys{"choice", "reported", "all_test"};
    for (std::size_t i = 0; i < keys.size(); ++i) {
      for (const auto& [object, ms] : choice["best"][keys[i]]["objects"].members()) rows[object][i] = ms.words();
    }
    for (const auto& [object, values] : rows) {
      Row row{object};
      for (const std::string& value : values) row.push_back(value.empty() ? "-" : value);
      best.rows.push_back(std::move(row));
    }
    input.choice.push_back(std::move(best));
  }
  if (const JsonView paper = study["paper_way"]) {
    input.remarks.push_back(fmt::format("The paper's own way, chosen on the runs reported on: {:g} ms, model {}. {}",
                                        paper["th_ms"].number(), paper["model"].text(), paper["why"].text()));
  }

  for (const JsonView& entry : study["evaluations"].items()) {
    const fs::path json_file = folder / entry["json"].text();
    if (!is_there(input, json_file, "The evaluation " + entry["id"].text())) continue;
    const nlohmann::json evaluation_document = read_json(json_file);
    ReportedEvaluation evaluation = evaluation_of(JsonView(evaluation_document, json_file.string()));
    evaluation.id = entry["id"].text();
    evaluation.model = entry["model"].text();
    evaluation.history_ms = entry["th_ms"].number();
    evaluation.is_beside = entry["id"].text() == "all_test";
    evaluation.runs = entry["runs"].text() == "all_test" ? "all test runs, as in the paper" : "the runs reported on";
    input.evaluations.push_back(std::move(evaluation));
  }
  if (study["evaluations"].items().empty()) input.missing.push_back("No model was evaluated; 'tactile reproduce' does so.");

  for (const JsonView& run : study["full_runs"].items()) {
    const fs::path csv = folder / run["csv"].text();
    if (is_there(input, csv, "The full run " + run["run"].text())) {
      input.runs.push_back({.run = run["run"].text(),
                            .model = run["model"].text(),
                            .history_ms = run["th_ms"].number(),
                            .csv = csv,
                            .outcome = fs::path(csv).replace_extension(".json")});
    }
  }
  if (study["full_runs"].items().empty())
    input.missing.push_back("No run over time (the paper's figure 8); 'tactile eval --run OBJECT/RUN' makes one.");

  const JsonView unseen = study["unseen"];
  for (const auto& [key, words] : {std::pair<std::string, std::string>{"reported", "the runs reported on"},
                                   {"all_test", "all test runs, as in the paper"}}) {
    UnseenSection section{.runs = words, .comparison = unseen[key].get<UnseenComparison>(), .is_beside = key != "reported"};
    section.comparison.models = unseen["models"].get<UnseenComparison::Models>();
    if (!section.comparison.objects.empty()) input.unseen.push_back(std::move(section));
  }
  if (input.unseen.empty())
    input.missing.push_back("Unseen objects (the paper's figure 9) were not tested; 'tactile eval --unseen' does so.");

  ReportedTable splits{
      .caption =
          "Other ways to hold five objects out: accuracy on the held-out objects of each drawn split, on the runs reported on.",
      .head = {"split", "held out", "seen", "held out", "difference"},
      .rows = {}};
  for (const JsonView& split : study["splits"].items()) {
    const SeenAndHeldOut mean = split["reported"]["mean"].get<SeenAndHeldOut>();
    const auto text = [](const Figure& value) {
      return std::isfinite(value.value) ? fmt::format("{:.2f} %", 100 * value.value) : "-";
    };
    splits.rows.push_back(
        {split["name"].text(), split["held_out"].words(), text(mean.seen), text(mean.held_out), text(mean.difference)});
  }
  if (!splits.rows.empty()) {
    const Figure mean = study["splits_mean"]["reported"].get<Figure>();
    if (std::isfinite(mean.value)) {
      input.remarks.push_back(fmt::format("Over {} drawn splits an object that is held out loses {:.2f} points on average.",
                                          splits.rows.size(), -100 * mean.value));
    }
    input.splits.push_back(std::move(splits));
  }

  const auto add_table = [&](const std::string& caption, Row head, std::vector<Row> rows) {
    if (!rows.empty()) input.settings.push_back({.caption = caption, .head = std::move(head), .rows = std::move(rows)});
  };
  std::vector<Row> rows;
  add_settings(rows, "", study["settings"]);
  add_settings(rows, "dataset ", study["dataset"]);
  add_settings(rows, "bootstrap ", study["bootstrap"]);
  add_table("Settings and seeds", {"setting", "value"}, std::move(rows));
  rows = {};
  for (const JsonView& history : study["histories"].items()) {
    for (const JsonView& model : history["models"].items()) {
      const fs::path description = folder / model["folder"].text() / "model.json";
      if (!rows.empty() || !choice || model["name"].text() != choice["model"].text()) continue;
      if (!is_there(input, description, "What the model chosen was trained with")) continue;
      const nlohmann::json model_document = read_json(description);
      const JsonView told_by_model(model_document, description.string());
      for (const std::string key : {"rendering", "split", "training", "network", "result"})
        add_settings(rows, key + " ", told_by_model[key]);
    }
  }
  add_table("The model chosen, " + choice["model"].text() + ": what it was trained with", {"setting", "value"}, std::move(rows));
  rows = {};
  add_settings(rows, "", study["software"]);
  add_settings(rows, "", study["machine"]);
  add_table("Software and machine", {"what", "value"}, std::move(rows));
  if (!study["machine"]) input.missing.push_back("The machine that it was measured on is not told.");
  rows = {};
  for (const auto& [name, words] : {std::pair<std::string, std::string>{"train", "trained on"},
                                    {"choice", "chosen on"},
                                    {"reported", "reported on"},
                                    {"all_test", "all test runs"}})
    rows.push_back({words, list_of(study["runs"][name].texts())});
  add_table("Runs", {"set", "runs"}, std::move(rows));
  add_table("Models: accuracy is the mean over objects on the runs reported on",
            {"model", "seed", "accuracy", "weights, SHA-256"}, std::move(seeds));
  rows = {};
  double total = 0;
  for (const JsonView& step : study["steps"].items()) {
    rows.push_back({step["name"].text(), seconds_text(step["seconds"].number()), step["finished_at"].text(),
                    step["command"] ? step["command"].text() : "-"});
    if (std::isfinite(step["seconds"].number())) total += step["seconds"].number();
  }
  if (!rows.empty()) rows.push_back({"work of all steps, several of them side by side", seconds_text(total), "", ""});
  add_table("Steps and their times", {"step", "took", "finished (UTC)", "the same by"}, std::move(rows));
  return input;
}

namespace {

/// What a model was made with, but for the history, by which models stand beside each other.
nlohmann::json compared_settings(const nlohmann::json& model, const std::string& where) {
  nlohmann::json settings = {{"dataset", {{"manifest_hash", JsonView(model, where)["dataset"]["manifest_hash"].words()}}}};
  if (!model.is_object()) return settings.flatten();
  for (const char* key : {"rendering", "split", "training", "network"})
    settings[key] = model.value(key, nlohmann::json::object());
  if (settings["rendering"].is_object()) settings["rendering"].erase("history_us");
  return settings.flatten();
}

/// In what two models' settings differ beside the history: "training.learning_rate: 0.001 and 0.01; ..."; empty if in nothing.
std::string other_settings(const nlohmann::json& one, const nlohmann::json& two, const std::string& where) {
  nlohmann::json ours = compared_settings(one, where);
  const nlohmann::json theirs = compared_settings(two, where);
  for (const auto& [path, value] : theirs.items()) {
    if (!ours.contains(path)) ours[path] = nullptr;
  }
  std::string text;
  for (const auto& [path, value] : ours.items()) {
    const nlohmann::json other = theirs.value(path, nlohmann::json());
    if (other == value) continue;
    std::string name = path.substr(1);
    std::replace(name.begin(), name.end(), '/', '.');
    text += text.empty() ? "" : "; ";
    text += name == "dataset.manifest_hash" ? "another dataset" : fmt::format("{}: {} and {}", name, value.dump(), other.dump());
  }
  return text;
}

}  // namespace

ReportInput read_models(const std::vector<fs::path>& folders, const fs::path& data) {
  ReportInput input;
  input.data = data;
  std::vector<std::unique_ptr<nlohmann::json>> documents;  // views lie into them
  std::vector<std::pair<double, JsonView>> by_history;
  std::vector<Row> models;
  std::vector<Row> settings;
  for (const fs::path& folder : folders) {
    const bool is_first = &folder == &folders.front();
    const fs::path file = folder / "model.json";
    documents.push_back(std::make_unique<nlohmann::json>(read_json(file)));
    const JsonView model(*documents.back(), file.string());
    const std::string name = fs::absolute(folder).lexically_normal().filename().string();
    const double history_ms = model["rendering"]["history_us"].number() / 1000;
    if (const std::string other = other_settings(*documents.front(), *documents.back(), file.string()); !other.empty()) {
      input.remarks.push_back(fmt::format("{} and {} differ in more than their history: {}.",
                                          fs::absolute(folders.front()).lexically_normal().filename().string(), name, other));
    }
    input.simulated = input.simulated || model["dataset"]["simulated"].truth();
    if (is_there(input, folder / "history.csv", "The training of " + name))
      input.trainings.push_back(training_in(folder / "history.csv", name));
    models.push_back(
        {name, model["trained_at"].words(), model["samples"].words(), model["weights_sha256"].words().substr(0, 16)});

    const fs::path eval_file = folder / "eval.json";
    std::error_code ignored;
    if (fs::is_regular_file(eval_file, ignored)) {
      documents.push_back(std::make_unique<nlohmann::json>(read_json(eval_file)));
      const JsonView json(*documents.back(), eval_file.string());
      if (std::isfinite(history_ms)) by_history.emplace_back(history_ms, json["accuracy"]);
      if (is_first) {
        add_sentences(input.remarks, json["warnings"]);
        ReportedEvaluation evaluation = evaluation_of(json);
        evaluation.id = "reported";
        evaluation.model = name;
        evaluation.history_ms = history_ms;
        evaluation.runs = list_of(json["test_runs"].texts());
        input.evaluations.push_back(std::move(evaluation));
        add_settings(settings, "bootstrap ", json["bootstrap"]);
      }
    } else if (is_first) {
      input.missing.push_back(
          fmt::format("{} was not evaluated; 'tactile eval --model {}' does so.", name, shell_word(folder.string())));
    }
    if (const fs::path unseen_file = folder / "eval-unseen.json";
        input.unseen.empty() && fs::is_regular_file(unseen_file, ignored)) {
      const nlohmann::json document = read_json(unseen_file);
      UnseenSection section{.runs = {},
                            .comparison = JsonView(document, unseen_file.string())["unseen"].get<UnseenComparison>(),
                            .is_beside = false};
      section.runs = list_of(section.comparison.runs);
      if (!section.comparison.objects.empty()) input.unseen.push_back(std::move(section));
    }
    if (!is_first) continue;
    input.title = fmt::format("Results of {}{}", name, input.simulated ? " (simulated runs)" : "");
    if (std::isfinite(history_ms)) input.history_ms = history_ms;
    for (const std::string key : {"rendering", "split", "training", "network", "software"})
      add_settings(settings, key + " ", model[key]);
    settings.push_back({"dataset", model["dataset"]["file"].words()});
    settings.push_back({"dataset manifest, SHA-256", model["dataset"]["manifest_hash"].words()});
    settings.push_back({"threads of the training", model["threads"].words()});
    if (fs::is_directory(folder / "runs", ignored)) {
      std::vector<fs::path> files;
      for (const auto& entry : fs::directory_iterator(folder / "runs", ignored)) {
        if (entry.path().extension() == ".csv") files.push_back(entry.path());
      }
      std::sort(files.begin(), files.end());
      constexpr std::size_t most_runs = 3;
      for (const fs::path& csv : files) {
        if (input.runs.size() == most_runs) break;
        input.runs.push_back({.run = csv.stem().string(),
                              .model = name,
                              .history_ms = input.history_ms,
                              .csv = csv,
                              .outcome = fs::path(csv).replace_extension(".json")});
      }
      if (files.size() > most_runs)
        input.remarks.push_back(fmt::format("Of {} runs over time the first {} are shown.", files.size(), most_runs));
    }
    if (input.runs.empty()) {
      input.missing.push_back(
          fmt::format("No run over time (the paper's figure 8); 'tactile eval --model {} --run OBJECT/RUN' makes one.",
                      shell_word(folder.string())));
    }
  }
  std::stable_sort(by_history.begin(), by_history.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  const bool several = std::adjacent_find(by_history.begin(), by_history.end(),
                                          [](const auto& a, const auto& b) { return a.first != b.first; }) != by_history.end();
  if (several)
    input.histories.push_back(histories_of("the test runs of each model", by_history));
  else
    input.missing.push_back(
        "Accuracy by history (the paper's figure 6) needs models of several histories; 'tactile reproduce' trains them.");
  if (input.unseen.empty())
    input.missing.push_back("Unseen objects (the paper's figure 9) were not tested; 'tactile eval --unseen' does so.");
  input.missing.push_back("The paper's claims are judged, and the machine and times told, by 'tactile reproduce' alone.");
  input.settings.push_back({.caption = "Settings and seeds", .head = {"setting", "value"}, .rows = std::move(settings)});
  input.settings.push_back(
      {.caption = "Models", .head = {"model", "trained at", "samples", "weights, SHA-256"}, .rows = std::move(models)});
  return input;
}

}  // namespace tactile
