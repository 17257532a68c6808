#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <system_error>

#include "tactile/core/changed_values.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/report/input_parts.hpp"
#include "tactile/results/found.hpp"

namespace tactile::report {
namespace {

namespace fs = std::filesystem;

/// Dataset and settings of a model without its history, which is what models are compared by.
nlohmann::json compared_settings(const nlohmann::json& model, const std::string& where) {
  nlohmann::json settings = {
      {"dataset", {{"manifest_hash", results::JsonView(model, where)["dataset"]["manifest_hash"].words()}}}};
  if (!model.is_object()) return settings;
  for (const char* key : {"rendering", "split", "training", "network"})
    settings[key] = model.value(key, nlohmann::json::object());
  if (settings["rendering"].is_object()) settings["rendering"].erase("history_us");
  return settings;
}

/// The other differences of two models: "training.learning_rate: 0.001 and 0.01; ..."; empty if there are none.
std::string other_settings(const nlohmann::json& one, const nlohmann::json& two, const std::string& where) {
  std::string text;
  nlohmann::json first = compared_settings(one, where), second = compared_settings(two, where);
  // Models of two kinds share no settings of network and training: a list of them would be useless.
  if (results::JsonView(one, where)["network"]["kind"].words() != results::JsonView(two, where)["network"]["kind"].words()) {
    text = "another kind of model";
    for (nlohmann::json* settings : {&first, &second}) {
      settings->erase("network");
      settings->erase("training");
    }
  }
  for (const auto& [path, ours, theirs] : changed_values(first, second)) {
    if (ours == theirs) continue;
    text += text.empty() ? "" : "; ";
    text += path == "dataset.manifest_hash" ? "another dataset" : fmt::format("{}: {} and {}", path, ours.dump(), theirs.dump());
  }
  return text;
}

/// A model's folder with its description and its evaluation, as views into JSON.
class ModelFolder {
 public:
  explicit ModelFolder(const ModelToReport& model)
      : folder_(model.folder),
        evaluation_file_(model.evaluation),
        model_(read_json(folder_ / "model.json")),
        evaluation_(is_file(evaluation_file_) ? read_json(evaluation_file_) : nlohmann::json()) {}

  const fs::path& path() const { return folder_; }
  std::string name() const { return fs::absolute(folder_).lexically_normal().filename().string(); }
  const nlohmann::json& document() const { return model_; }
  results::JsonView model() const { return {model_, (folder_ / "model.json").string()}; }
  results::JsonView evaluation() const { return {evaluation_, evaluation_file_.string()}; }
  /// Whether it learned from simulated runs, or was judged on some.
  bool is_simulated() const { return model()["dataset"]["simulated"].truth() || evaluation()["simulated"].truth(); }
  std::string learned_from() const { return model()["dataset"]["manifest_hash"].words(); }
  double history_ms() const { return model()["rendering"]["history_us"].number() / 1000; }

 private:
  fs::path folder_, evaluation_file_;
  nlohmann::json model_, evaluation_;
};

void read_evaluation(ReportInput& input, const ModelFolder& folder) {
  const results::JsonView json = folder.evaluation();
  if (!json) {
    input.missing.push_back(fmt::format("{} was not evaluated; 'tactile eval --model {}' evaluates it.", folder.name(),
                                        shell_word(folder.path().string())));
    return;
  }
  add_sentences(input.remarks, json["warnings"].texts());
  if (const std::string judged_on = json["dataset"]["manifest_hash"].words(); judged_on != folder.learned_from()) {
    input.remarks.push_back(
        fmt::format("{} learned from {} with manifest {}. It is judged on runs of {} with manifest {} that it has not seen.",
                    folder.name(), folder.model()["dataset"]["file"].words(), folder.learned_from().substr(0, 8),
                    json["dataset"]["file"].words(), judged_on.substr(0, 8)));
  }
  input.evaluations.push_back({.model = folder.name(),
                               .runs = list_of_runs(json["test_runs"].texts()),
                               .history_ms = folder.history_ms(),
                               .scores = json.get<results::Evaluation>()});
}

void read_unseen(ReportInput& input, const fs::path& folder) {
  const fs::path file = folder / "eval-unseen.json";
  if (!input.unseen.empty() || !is_file(file)) return;
  const nlohmann::json document = read_json(file);
  const results::UnseenComparison comparison =
      results::JsonView(document, file.string())["unseen"].get<results::UnseenComparison>();
  if (!comparison.objects.empty())
    input.unseen.push_back({.name = {}, .setting = {}, .runs = list_of_runs(comparison.runs), .comparison = comparison});
}

void read_runs(ReportInput& input, const ModelFolder& folder) {
  constexpr std::size_t most_runs = 3;
  std::error_code ignored;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder.path() / "runs", ignored)) {
    if (entry.path().extension() == ".csv") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const fs::path& csv : files) {
    if (input.runs.size() == most_runs) break;
    input.runs.push_back(
        {.run = csv.stem().string(), .model = folder.name(), .history_ms = input.history_ms, .csv = csv.string()});
  }
  if (files.size() > most_runs)
    input.remarks.push_back(fmt::format("The first {} of {} runs over time are shown.", most_runs, files.size()));
  if (files.empty()) {
    input.missing.push_back(
        fmt::format("No run over time (the paper's figure 10); 'tactile eval --model {} --run OBJECT/RUN' makes one.",
                    shell_word(folder.path().string())));
  }
}

/// The sentences that the page begins with; none without an evaluation.
std::vector<std::string> found_of(const ReportInput& input, const ModelFolder& folder) {
  if (input.evaluations.empty()) return {};
  const results::Evaluation& scores = input.evaluations.front().scores;
  std::string learned = fmt::format("{} learned from {} runs, and is judged on {} others.", folder.name(),
                                    folder.model()["train_runs"].texts().size(), scores.test_runs().size());
  std::vector<std::string> found =
      results::found_in(scores, input.unseen.empty() ? results::UnseenComparison{} : input.unseen.front().comparison);
  found.push_back(std::move(learned));
  return found;
}

std::vector<TableRow> settings_of(const ModelFolder& folder) {
  const results::JsonView model = folder.model();
  std::vector<TableRow> rows;
  add_settings(rows, "bootstrap ", folder.evaluation()["bootstrap"]);
  for (const std::string key : {"rendering", "split", "training", "network", "software"})
    add_settings(rows, key + " ", model[key]);
  rows.push_back({"dataset", model["dataset"]["file"].words()});
  rows.push_back({"dataset manifest, SHA-256", model["dataset"]["manifest_hash"].words()});
  rows.push_back({"threads of the training", model["threads"].words()});
  return rows;
}

/// Accuracy by history, where the models have several.
void add_histories(ReportInput& input, const std::vector<ModelFolder>& folders) {
  std::vector<std::pair<double, results::Accuracy>> by_history;
  for (const ModelFolder& folder : folders) {
    const auto accuracy = folder.evaluation()["accuracy"].if_there<results::Accuracy>();
    if (accuracy && std::isfinite(folder.history_ms())) by_history.emplace_back(folder.history_ms(), *accuracy);
  }
  std::stable_sort(by_history.begin(), by_history.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  if (!by_history.empty() && by_history.front().first != by_history.back().first)
    input.histories.push_back(histories_of("the test runs of each model", by_history));
  else
    input.missing.push_back(
        "Accuracy by history (the paper's figure 8) needs models of several histories; 'tactile reproduce' trains them.");
}

}  // namespace

ReportInput read_models(const std::vector<ModelToReport>& reported, const fs::path& data) {
  const std::vector<ModelFolder> folders(reported.begin(), reported.end());
  const ModelFolder& first = folders.front();
  ReportInput input;
  input.data = data;
  if (std::isfinite(first.history_ms())) input.history_ms = first.history_ms();
  std::vector<TableRow> models;
  for (const ModelFolder& folder : folders) {
    const results::JsonView model = folder.model();
    const std::string name = folder.name();
    if (const std::string other = other_settings(first.document(), folder.document(), model.where()); !other.empty())
      input.remarks.push_back(fmt::format("{} and {} differ in more than their history: {}.", first.name(), name, other));
    input.simulated = input.simulated || folder.is_simulated();
    const fs::path history = folder.path() / "history.csv";
    if (is_found(input, history, "The training of " + name)) input.trainings.push_back(training_in(history, name));
    models.push_back(
        {name, model["trained_at"].words(), model["samples"].words(), model["weights_sha256"].words().substr(0, 16)});
    read_unseen(input, folder.path());
  }
  read_evaluation(input, first);
  read_runs(input, first);
  add_histories(input, folders);
  input.found = found_of(input, first);
  input.title = fmt::format("Results of {}{}", first.name(), first.is_simulated() ? " (simulated runs)" : "");
  if (input.unseen.empty())
    input.missing.push_back("Unseen objects (the paper's figure 11) were not tested; 'tactile eval --unseen' tests them.");
  input.missing.push_back("Only 'tactile reproduce' tests the paper's claims, and records the machine and the times.");
  input.settings.push_back({.caption = "Settings and seeds", .head = {"setting", "value"}, .rows = settings_of(first)});
  input.settings.push_back(
      {.caption = "Models", .head = {"model", "trained at", "samples", "weights, SHA-256"}, .rows = std::move(models)});
  return input;
}

}  // namespace tactile::report
