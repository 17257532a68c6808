#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/model/bundle/bundle_evaluations.hpp"
#include "tactile/model/bundle/pinned_bundle.hpp"
#include "tactile/report/report.hpp"
#include "tactile/results/experiment_file.hpp"
#include "tactile/results/json_view.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

struct ReportArguments {
  std::string what;
  std::string out;
  std::string models = "models";
  std::string trade, stress;
  bool verbose = false;
};

/// A model for a report.
struct FoundModel {
  fs::path folder, evaluation;
  bool preferred = false, single_run = false, evaluated = false;
  std::string trained_at;
};

struct PreferredModel {
  std::optional<model::ModelBundle> bundle;
  std::string why;
  bool is_pinned = false;
};

/// The model that a report of a dataset begins with, if it is of that dataset or was judged on it: the pinned one, else the last
/// one that `train` made here. Without an evaluation there is nothing to show: only a pin puts such a model first.
PreferredModel preferred_model(const fs::path& models) {
  if (auto pinned = model::pinned_bundle(models)) return {std::move(pinned), "the pinned model", true};
  return {model::last_bundle(models), "the last one that 'train' made here", false};
}

/// Models of the dataset; the first gives all its results: the preferred one, else the newest one of single runs with an
/// evaluation. Models with held-out objects appear in the comparison that the other model's folder has.
std::vector<report::ModelToReport> models_of(const std::string& manifest_hash, const ReportArguments& args) {
  const PreferredModel preferred = preferred_model(args.models);
  std::vector<FoundModel> found;
  std::error_code none;
  for (fs::directory_iterator entry(args.models, none), end; !none && entry != end; entry.increment(none)) {
    const fs::path file = entry->path() / "model.json";
    if (!is_file(file)) continue;
    try {
      const nlohmann::json document = read_json(file);
      const results::JsonView model(document, file.string());
      const std::string learned_from = model["dataset"]["manifest_hash"].text();
      const fs::path evaluation = model::evaluation_on({entry->path()}, learned_from, manifest_hash);
      const bool evaluated = is_file(evaluation);
      const bool is_preferred =
          preferred.bundle && preferred.bundle->folder == entry->path() && (preferred.is_pinned || evaluated);
      if (learned_from != manifest_hash && !(is_preferred && evaluated)) {
        if (is_preferred)
          spdlog::warn("{}, {}, learned from other data and was not judged on this; 'tactile eval' judges it",
                       entry->path().string(), preferred.why);
        continue;
      }
      found.push_back({.folder = entry->path(),
                       .evaluation = evaluation,
                       .preferred = is_preferred,
                       .single_run = model["split"]["kind"].text() == "single-run",
                       .evaluated = evaluated,
                       .trained_at = model["trained_at"].text()});
    } catch (const Error& e) {
      spdlog::warn("skipped: {}", e.what());
    }
  }
  std::sort(found.begin(), found.end(), [](const FoundModel& a, const FoundModel& b) {
    return std::tuple(a.preferred, a.single_run, a.evaluated, a.trained_at, b.folder) >
           std::tuple(b.preferred, b.single_run, b.evaluated, b.trained_at, a.folder);
  });
  if (!found.empty()) {
    const FoundModel& first = found.front();
    spdlog::info("reporting {}, {}", first.folder.string(),
                 first.preferred ? preferred.why : (first.evaluated ? "the newest one with an evaluation" : "the newest model"));
  }
  std::vector<report::ModelToReport> reported;
  for (const FoundModel& model : found) {
    if (model.single_run || reported.empty()) reported.emplace_back(model.folder, model.evaluation);
  }
  return reported;
}

/// The folder of the dataset that a model was judged on, else trained on, as it was given; empty where it does not exist from
/// here.
fs::path data_of(const report::ModelToReport& model) {
  const fs::path described = is_file(model.evaluation) ? model.evaluation : model.folder / "model.json";
  const nlohmann::json document = read_json(described);
  const fs::path file = results::JsonView(document, described.string())["dataset"]["file"].text();
  return is_file(file) ? (file.has_parent_path() ? file.parent_path() : fs::path(".")) : fs::path();
}

/// A report of a trade of speed for accuracy, or of worsened runs, alone.
/// @param part  the input's member for it
template <class Result>
report::ReportInput report_of(Result result, std::optional<Result> report::ReportInput::*part) {
  report::ReportInput input;
  input.title = result.title;
  input.simulated = result.simulated;
  input.*part = std::move(result);
  return input;
}

/// The folder of a trade or a stress to include: the one named, else the usual one where it exists.
fs::path folder_to_include(const std::string& named, const std::string& usual) {
  if (!named.empty()) return named;
  return is_file(fs::path(usual) / (usual + ".json")) ? usual : "";
}

/// What is reported if nothing is named.
fs::path usual_what() { return is_file("study/study.json") ? "study" : "data"; }

/// The input of the report, and its folder.
std::pair<report::ReportInput, fs::path> input_of(const fs::path& what, const ReportArguments& args) {
  if (what.filename() == "study.json" && is_file(what))
    return {report::read_study(what.parent_path()), what.parent_path() / "report"};
  if (is_file(what / "study.json")) return {report::read_study(what), what / "report"};
  if (is_file(what / "model.json")) {
    const report::ModelToReport model(what, model::newest_evaluation({what}).value_or(what / "eval.json"));
    return {report::read_models({model}, data_of(model)), what / "report"};
  }
  if (is_file(what / "trade.json"))
    return {report_of(results::read_experiment<results::Trade>(what / "trade.json"), &report::ReportInput::trade),
            what / "report"};
  if (is_file(what / "stress.json"))
    return {report_of(results::read_experiment<results::Stress>(what / "stress.json"), &report::ReportInput::stress),
            what / "report"};
  const fs::path dataset = is_file(what) ? what : what / "dataset.h5";
  if (!is_file(dataset)) {
    throw Error(
        fmt::format("{}: contains no study, model, trade, stress or dataset; expected a folder that 'tactile reproduce', "
                    "'train', 'trade', 'stress' or 'windows' wrote",
                    what.string()));
  }
  const std::vector<report::ModelToReport> models = models_of(windows::Dataset(dataset).manifest_hash(), args);
  if (models.empty()) {
    throw Error(fmt::format("{}: no model of {}; expected one, run 'tactile train' and 'tactile eval' first", args.models,
                            dataset.string()));
  }
  return {report::read_models(models, is_file(what) ? what.parent_path() : what), "report"};
}

void report(const ReportArguments& args, const CommonArguments& common) {
  const fs::path what = args.what.empty() ? usual_what() : fs::path(args.what);
  auto [input, place] = input_of(what, args);
  if (const fs::path trade = folder_to_include(args.trade, "trade"); !trade.empty() && !input.trade)
    input.trade = results::read_experiment<results::Trade>(trade / "trade.json");
  if (const fs::path stress = folder_to_include(args.stress, "stress"); !stress.empty() && !input.stress)
    input.stress = results::read_experiment<results::Stress>(stress / "stress.json");
  RunsBelow below;
  std::error_code unknown;
  if (!input.data.empty() && fs::is_directory(input.data, unknown)) below = look_for_runs(input.data);
  for (const std::string& misnamed : below.misnamed) spdlog::warn("{}", misnamed);
  const report::ReportSummary summary =
      report::write_report(input, args.out.empty() ? place : fs::path(args.out), [](std::string_view figure) {
        stop_if_interrupted();
        spdlog::info("drawing {}", figure);
      });
  write_settings(common, summary.page.parent_path() / "settings.json",
                 {{"what", what.string()}, {"out", summary.page.parent_path().string()}});
  std::string text = summary.title + "\n\n";
  if (summary.claims > 0) {
    text += fmt::format("Of the paper's {} claims {} hold, {} do not hold, and {} cannot be decided.\n\n", summary.claims,
                        summary.hold, summary.do_not, summary.claims - summary.hold - summary.do_not);
  }
  if (!summary.missing.empty() && !args.verbose) {
    text += fmt::format("{} not in it; --verbose lists {}.\n\n",
                        summary.missing.size() == 1 ? "1 part is" : fmt::format("{} parts are", summary.missing.size()),
                        summary.missing.size() == 1 ? "it" : "them");
  }
  if (!summary.missing.empty() && args.verbose) {
    text += "Missing:\n";
    for (const std::string& missing : summary.missing) text += wrapped("- " + missing, 2) + "\n";
    text += "\n";
  }
  text += fmt::format("{}: written, with {} figures; self-contained\n", summary.page.string(), summary.figures.size());
  print_result(common,
               {{"title", summary.title},
                {"simulated", summary.simulated},
                {"page", summary.page.string()},
                {"figures", summary.figures},
                {"missing", summary.missing},
                {"misnamed", below.misnamed},
                {"claims", {{"count", summary.claims}, {"hold", summary.hold}, {"do_not", summary.do_not}}}},
               text);
  below.unreadable.insert(below.unreadable.end(), summary.errors.begin(), summary.errors.end());
  end_with(below.unreadable);
}

}  // namespace

void add_report_command(CLI::App& app) {
  auto args = std::make_shared<ReportArguments>();
  Command command = add_command(app, "report", "Write figures and one self-contained page from results",
                                [args](const CommonArguments& common) { report(*args, common); });
  command
      .add_option("what", args->what,
                  "Folder that 'reproduce', 'trade' or 'stress' wrote, a model, or data; default: study/ if it exists, else data")
      .type_name("STUDY|MODEL|TRADE|STRESS|DATA");
  command.add_option("--out", args->out, "Output folder; default: report/ in the study or model").type_name("DIR");
  command.add_option("--trade", args->trade, "Folder of 'trade' results to include; default: trade/ if it exists")
      .type_name("DIR");
  command.add_option("--stress", args->stress, "Folder of 'stress' results to include; default: stress/ if it exists")
      .type_name("DIR");
  command.add_flag("--verbose", args->verbose, "List what is not in the report, and why");
  command.add_option("--models", args->models, "Folder of models, for DATA").type_name("DIR").show_default();
}

}  // namespace tactile::cli
