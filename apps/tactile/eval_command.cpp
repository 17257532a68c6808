#include <fmt/core.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <deque>
#include <string>
#include <vector>

#include "camera_time.hpp"
#include "chosen_model.hpp"
#include "command.hpp"
#include "commands.hpp"
#include "eval_models.hpp"
#include "eval_run.hpp"
#include "eval_summary.hpp"
#include "eval_tables.hpp"
#include "model_arguments.hpp"
#include "option_checks.hpp"
#include "quantity_text.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/evaluation/evaluation.hpp"
#include "tactile/evaluation/scene_remarks.hpp"
#include "tactile/evaluation/tick_speed.hpp"
#include "tactile/experiments/usual_trainings.hpp"
#include "tactile/model/bundle/bundle_evaluations.hpp"
#include "tactile/model/training/open_classifier.hpp"
#include "tactile/model/training/split_remarks.hpp"
#include "tactile/model/training/train_model.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

evaluation::EvaluationOptions options_of(const EvalArguments& args, const CommonArguments& common, model::ModelKind kind) {
  evaluation::EvaluationOptions options;
  options.confirmation = confirmation_of(args.decision);
  options.thresholds = thresholds_of(args.decision, kind);
  options.onset_visible = args.onset == "visible";
  options.threads = common.threads;
  return options;
}

/// Writes the result to `file`, and next to it its cells and the settings. @return  a sentence that names result and cells
std::string write_result(const fs::path& file, const nlohmann::json& json, std::span<const results::Cell> cells,
                         const CommonArguments& common, const model::ModelBundle& bundle) {
  fs::path table = file, settings = file;
  table.replace_filename(file.stem().string() + "-cells.csv");
  settings.replace_filename(file.stem().string() + "-settings.json");
  write_json(file, json);
  write_whole(table, results::cells_csv(cells));
  write_settings(common, settings, {{"model", bundle.folder.string()}});
  return fmt::format("Written to {} and {}\n", file.string(), table.filename().string());
}

/// The file of results. Options that change the figures have their own file, so that none replaces another.
fs::path result_file(const fs::path& usual, const evaluation::EvaluationOptions& options, model::ModelKind kind) {
  std::string name = usual.stem().string();
  if (options.onset_visible) name += "-onset-visible";
  if (options.confirmation != Confirmation{})
    name += fmt::format("-confirm-{}-of-{}", options.confirmation.needed, options.confirmation.of);
  if (options.thresholds != model::usual_thresholds(kind) && options.confirmation == Confirmation{}) {
    std::string text = options.thresholds ? text_of(*options.thresholds) : "off";
    std::replace(text.begin(), text.end(), ':', '-');
    name += "-thresholds-" + text;
  }
  return usual.parent_path() / (name + ".json");
}

/// Called first, because an evaluation can take an hour.
void check_writable(const fs::path& folder) {
  if (::access(folder.c_str(), W_OK) != 0)
    throw Error(folder.string() + ": results cannot be written there (" + std::strerror(errno) + "); expected a writable folder");
}

/// Adds and prints a remark if the scene of judged runs leaves that of the training runs. The runs are unchanged, as `evaluate`
/// has checked.
void warn_of_scenes(const windows::Dataset& dataset, const model::ModelDescription& model, std::span<const std::uint32_t> runs,
                    unsigned threads, std::vector<std::string>& warnings) {
  std::vector<evaluation::WatchedRun> watched;
  for (const std::uint32_t run : runs)
    watched.push_back({name_of(dataset.runs()[run]), dataset.run_folder(run) / "events.aedat4"});
  const std::string remark = evaluation::scene_remark(model, watched, threads);
  if (remark.empty()) return;
  spdlog::warn("{}", remark);
  warnings.push_back(remark);
}

/// What a model learned from, and which runs of this dataset are therefore left out.
nlohmann::json json_of_learning(const windows::Dataset& dataset, const model::ModelDescription& model) {
  return {{"dataset", model.dataset},
          {"manifest_hash", model.manifest_hash},
          {"runs", names_of(model.learned_from)},
          {"left_out", names_of(dataset, model::learned_runs_of(dataset, model))}};
}

/// The same of a model of another dataset, as a sentence. @param judged  number of runs
std::string sentence_on_learning(const windows::Dataset& dataset, const model::ModelDescription& model, std::size_t judged) {
  if (model.own)
    return fmt::format("Learned from {}, as its description says. Judged on the {} of {} runs that it has not seen.",
                       counted(model.learned_from.size(), "run"), judged, dataset.runs().size());
  const std::string of_manifest = "manifest " + model.manifest_hash.substr(0, 8);
  return fmt::format("Learned from {}. Judged on the {} of {} runs that it has not seen.",
                     model.dataset == dataset.file().string() ? of_manifest : model.dataset + " with " + of_manifest, judged,
                     dataset.runs().size());
}

/// Measures how long a tick takes, on the first test run, and keeps it for `tactile models`.
std::optional<evaluation::TickSpeed> measured_speed(const windows::Dataset& dataset, std::uint32_t run,
                                                    const model::Classifier& classifier, const model::ModelBundle& bundle) {
  const auto speed = evaluation::measure_tick_speed(dataset.run_folder(run) / "events.aedat4", classifier);
  if (!speed) return speed;
  nlohmann::json json = *speed;
  json["engine"] = name_of(classifier.engine());
  write_json(evaluation::speed_file(bundle), json);
  return speed;
}

void evaluate_one(const EvalArguments& args, const CommonArguments& common) {
  const fs::path file = dataset_file(args.data);
  if (!fs::exists(file)) {
    throw Error(
        fmt::format("{}: no such dataset; expected one with a model, run '{}' first", file.string(), train_command(args, {})));
  }
  const windows::Dataset dataset(file);
  const std::string& hash = dataset.manifest_hash();
  std::optional<ChosenModel> chosen =
      args.model.empty() ? model_without_name(args.models, &hash) : ChosenModel{bundle_named(args), {}};
  if (!chosen) chosen = model_without_name(args.models);
  if (!chosen) {
    throw Error(fmt::format("{}: no model; expected one, run '{}' first", args.models, train_command(args, {})));
  }
  const model::ModelBundle& bundle = chosen->bundle;
  fs::create_directories(bundle.results());  // of a bundle it is there
  check_writable(bundle.results());
  log_choice("evaluating", *chosen);
  const model::Classifier classifier = model::open_classifier(bundle.folder, common.threads, args.engine);
  auto runs = model::test_runs_of(dataset, classifier.model());
  evaluation::leave_out_calibration_runs(runs, dataset, classifier);
  evaluation::EvaluationOptions options = options_of(args, common, classifier.kind());
  options.of_another_dataset = classifier.model().manifest_hash != dataset.manifest_hash();
  const std::vector<windows::SplitOptions> splits(options.of_another_dataset ? 0 : 1, classifier.model().settings.split);
  std::vector<std::string> warnings = warn_of_splits(dataset, splits, args.strict);
  const evaluation::Evaluated evaluated = evaluation::evaluate(dataset, classifier, runs, options, progress_line(common));
  const results::Evaluation& evaluation = evaluated.evaluation;
  warn_of_scenes(dataset, classifier.model(), runs, common.threads, warnings);
  nlohmann::json json = evaluation;
  json["warnings"] = warnings;
  json["learned_from"] = json_of_learning(dataset, classifier.model());
  const fs::path usual = model::evaluation_on(bundle, classifier.model().manifest_hash, hash);
  const std::string written = write_result(result_file(usual, options, classifier.kind()), json, evaluated.cells, common, bundle);
  const std::string learning =
      options.of_another_dataset ? wrapped(sentence_on_learning(dataset, classifier.model(), runs.size())) + "\n" : "";
  const auto speed = measured_speed(dataset, runs.front(), classifier, bundle);
  print_result(common, json, (args.verbose ? text_of(evaluation) : summary_of(evaluation, speed)) + learning + written);
}

/// Trainings with and without objects, and the runs to compare them on.
struct UnseenTrainings {
  std::deque<model::Classifier> classifiers;
  std::vector<evaluation::UnseenPair> pairs;
  std::vector<evaluation::ModelOnRuns> unseen;  ///< those without the objects
  std::vector<std::string> warnings;
};

/// Of one of the trainings of a model; `first` is training 0.
model::ModelSettings settings_of(const model::ModelBundle& first, const windows::Dataset& dataset, unsigned training) {
  const model::ModelSettings settings = model::read_description(first).settings;
  return training == 0 ? settings : with_training(settings, dataset, training);
}

/// The two models and, of each, the further trainings up to `count`; trains what is missing.
UnseenTrainings open_trainings(const EvalArguments& args, const CommonArguments& common, const windows::Dataset& dataset,
                               const model::ModelBundle& seen, const model::ModelBundle& held_out, unsigned count) {
  const model::EngineKind engine = args.engine;
  std::vector<windows::SplitOptions> splits;
  for (unsigned training = 0; training < count; ++training) {
    for (const model::ModelBundle& first : {seen, held_out}) splits.push_back(settings_of(first, dataset, training).split);
  }
  UnseenTrainings trainings{
      .classifiers = {}, .pairs = {}, .unseen = {}, .warnings = warn_of_splits(dataset, splits, args.strict)};
  for (unsigned training = 0; training < count; ++training) {
    const auto open = [&](const model::ModelBundle& first) {
      const model::ModelBundle bundle =
          training == 0 ? first : partner_of(args, common, dataset, settings_of(first, dataset, training), true);
      return &trainings.classifiers.emplace_back(model::open_classifier(bundle.folder, common.threads, engine));
    };
    const model::Classifier* with = open(seen);
    const model::Classifier* without = open(held_out);
    auto runs = evaluation::runs_neither_saw(dataset, with->model(), without->model());
    for (const model::Classifier* classifier : {with, without})
      evaluation::leave_out_calibration_runs(runs, dataset, *classifier);
    for (const std::string& object : model::objects_only_in(dataset, model::test_runs_of(dataset, without->model()), runs)) {
      const std::string warning = object + ": not compared, each of its runs with samples was used to train one of the models";
      if (std::find(trainings.warnings.begin(), trainings.warnings.end(), warning) != trainings.warnings.end()) continue;
      trainings.warnings.push_back(warning);
      spdlog::warn("{}", warning);
    }
    trainings.pairs.push_back({with, without, runs});
    trainings.unseen.push_back({without, runs});
  }
  return trainings;
}

/// The model to compare with one of the other split: the named one, else the one that commands take if it is of this dataset.
std::optional<ChosenModel> one_of_pair(const EvalArguments& args, const windows::Dataset& dataset) {
  if (!args.model.empty()) {
    const ChosenModel named{bundle_named(args), {}};
    if (model::is_own_network(named.bundle.folder))
      throw Error(args.model + ": is not trained by tactile; expected a model's folder, since --unseen trains others like it");
    return named;
  }
  const std::string& hash = dataset.manifest_hash();
  auto chosen = model_without_name(args.models, &hash);
  if (chosen && model::read_description(chosen->bundle).manifest_hash != hash) {
    spdlog::info("{} is pinned, but learned from another dataset; it is not compared", chosen->bundle.name());
    return std::nullopt;
  }
  return chosen;
}

void evaluate_unseen(const EvalArguments& args, const CommonArguments& common) {
  const fs::path file = dataset_file(args.data);
  if (args.no_train && !fs::exists(file)) {
    throw Error(
        fmt::format("{}: no such dataset; expected one with models, run '{}' first", file.string(), train_command(args, {})));
  }
  const std::optional<windows::DatasetSummary> made = make_missing_dataset(args.data, args.strict, common);
  const windows::Dataset dataset(file);
  const std::optional<ChosenModel> known = one_of_pair(args, dataset);
  model::ModelSettings settings;
  if (known) settings = model::read_description(known->bundle).settings;
  const bool knows_unseen = known && settings.split.kind == windows::SplitKind::unseen;
  const unsigned count = args.trainings.value_or(experiments::usual_trainings(dataset));
  spdlog::info("compares {} that saw all objects with {} that did not{}", counted(count, "model"), count,
               args.no_train ? "" : "; those that are missing are trained first (--trainings sets the number)");
  const model::ModelBundle seen =
      known && !knows_unseen ? known->bundle
                             : partner_of(args, common, dataset, with_split(settings, windows::SplitKind::single_run, {}));
  const auto unseen_settings = [&] {
    return with_split(settings, windows::SplitKind::unseen, objects_to_hold_out(args.held_out, dataset));
  };
  const model::ModelBundle held_out = knows_unseen ? known->bundle : partner_of(args, common, dataset, unseen_settings());
  check_writable(seen.folder);
  spdlog::info("evaluating {} and {}{}", held_out.folder.string(), seen.folder.string(),
               known && !known->why.empty() ? fmt::format("; {} is {}", known->bundle.name(), known->why) : "");

  const UnseenTrainings trainings = open_trainings(args, common, dataset, seen, held_out, count);
  const model::ModelKind kind = trainings.classifiers.front().kind();
  const evaluation::EvaluationOptions options = options_of(args, common, kind);
  const results::UnseenComparison comparison =
      evaluation::compare_unseen(dataset, trainings.pairs, options, progress_line(common));
  const evaluation::Evaluated evaluated = evaluation::evaluate(dataset, trainings.unseen, options, progress_line(common));
  const results::Evaluation& evaluation = evaluated.evaluation;
  nlohmann::json json = evaluation;
  json["unseen"] = comparison;
  json["warnings"] = trainings.warnings;
  const std::string written =
      write_result(result_file(seen.unseen_evaluation(), options, kind), json, evaluated.cells, common, seen);
  print_result(common, json,
               (args.verbose ? text_of(comparison, evaluation.simulated) + "\nThe model that never saw these objects:\n\n" +
                                   text_of(evaluation)
                             : summary_of(comparison, evaluation)) +
                   written);
  if (made) end_with(made->errors);
}

}  // namespace

void add_eval_command(CLI::App& app) {
  auto args = std::make_shared<EvalArguments>();
  Command command = add_command(app, "eval", "Evaluate a model: accuracy, detection delay, false alarms, baselines",
                                [args](const CommonArguments& common) {
                                  if (!args->runs.empty()) return show_runs(*args, common);
                                  args->unseen ? evaluate_unseen(*args, common) : evaluate_one(*args, common);
                                });
  command.add_option("data", args->data, "Data folder with dataset.h5, or a dataset file; its run folders are read too")
      .show_default();
  command.add_option("--model", args->model, default_model_help);
  command.add_option("--models", args->models, "Folder of models").type_name("DIR").show_default();
  const Option unseen = command.add_flag(
      "--unseen", args->unseen, "Compare held-out objects with the same objects seen in training; trains missing models");
  command
      .add_option("--held-out", args->held_out,
                  "With --unseen: held-out objects, separated by commas; default: those of the paper's five that exist")
      .delimiter(',')
      .type_name("NAME,...")
      .needs(unseen);
  command
      .add_option("--trainings", args->trainings,
                  "With --unseen: trainings with the objects, and without them, each on another run and with another seed; "
                  "default: 2 for runs of the preset tiny, else 5")
      .check(in_range(1U, 1000U))
      .type_name("N")
      .needs(unseen);
  command.add_flag("--verbose", args->verbose, "Print all tables");
  command.add_flag("--no-train", args->no_train, "With --unseen: do not train; a missing model is an error");
  add_strict_option(command, args->strict);
  add_confirm_option(command, args->decision);
  add_thresholds_option(command, args->decision);
  add_engine_option(command, args->engine);
  const Option onset = command
                           .add_option("--onset", args->onset,
                                       "From when delays count: first: the first motion; visible: the first time at which a "
                                       "person sees the touch in the events, as in the paper")
                           .type_name("NAME")
                           .check(one_of({"first", "visible"}))
                           .show_default();
  const Option run =
      command
          .add_option("--run", args->runs,
                      "Write every tick of these runs as CSV, PNG and SVG instead; object/run or folders, separated by commas")
          .delimiter(',')
          .type_name("RUN,...")
          .excludes(unseen)
          .excludes(onset);
  command.add_option("--out", args->out, "With --run: output folder; default: runs/ in the model's folder")
      .type_name("DIR")
      .needs(run);
  add_camera_time_option(command, args->camera_time).needs(run);
}

}  // namespace tactile::cli
