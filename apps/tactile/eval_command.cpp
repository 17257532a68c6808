#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <string>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "model_arguments.hpp"
#include "openmp_threads.hpp"
#include "option_checks.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/evaluation/evaluation.hpp"
#include "tactile/model/train_model.hpp"
#include "text_table.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;

struct EvalArguments {
  std::string data = "data";
  std::string models = "models", model;
  bool unseen = false, no_train = false;
  double guard_ms = -1;
};

using Row = std::vector<std::string>;

std::string percent(const Figure& figure) {
  return std::isfinite(figure.value) ? fmt::format("{:.2f}", 100 * figure.value) : "-";
}

/// "[lower, upper]", both times `scale`.
std::string bounds(const Figure& figure, double scale) {
  return figure.low ? fmt::format("[{:.2f}, {:.2f}]", scale * *figure.low, scale * *figure.high) : "-";
}

std::string baselines_not_below(const Evaluation& evaluation) {
  std::string names;
  for (const BaselineScore& baseline : evaluation.baselines) {
    if (*baseline.accuracy.mean.high >= *evaluation.accuracy.mean.low) names += (names.empty() ? "" : ", ") + baseline.name;
  }
  return names;
}

std::string number(const Figure& figure) { return std::isfinite(figure.value) ? fmt::format("{:.2f}", figure.value) : "-"; }

std::string accuracy_text(const Evaluation& evaluation) {
  std::vector<Row> rows;
  for (const auto& [name, figure] : evaluation.accuracy.objects)
    rows.push_back({name, percent(figure), bounds(figure, 100), std::to_string(figure.n) + (figure.n == 1 ? " run" : " runs")});
  const Figure& mean = evaluation.accuracy.mean;
  rows.push_back({"mean over objects", percent(mean), bounds(mean, 100), std::to_string(mean.n) + " objects"});
  std::string text = text_table({"accuracy on balanced samples [%]", "", "95 %", ""}, rows) + "\n";

  rows.clear();
  rows.push_back({"network", percent(mean), bounds(mean, 100)});
  for (const BaselineScore& baseline : evaluation.baselines)
    rows.push_back({baseline.name, percent(baseline.accuracy.mean), bounds(baseline.accuracy.mean, 100)});
  text += text_table({"beside the baselines, mean over objects [%]", "", "95 %"}, rows);
  const auto above = evaluation.above_baselines();
  text += !above ? "Too few objects to tell whether the network's accuracy lies above every baseline's.\n\n"
          : *above
              ? "The network's accuracy interval lies above every baseline's.\n\n"
              : wrapped("The network's accuracy interval does not lie above that of " + baselines_not_below(evaluation) + ".") +
                    "\n\n";

  rows.clear();
  for (const Touch truth : all_touches) {
    Row row{std::string(name_of(truth))};
    for (const std::uint64_t count : evaluation.confusion.counts[static_cast<std::size_t>(truth)])
      row.push_back(std::to_string(count));
    rows.push_back(row);
  }
  return text + text_table({"true \\ said", "none", "press", "slip"}, rows) + "\n";
}

constexpr const char* delay_legend =
    "One tick is the best delay possible; it is averaged over the intervals that were detected. miss: not detected within 500 ms "
    "or the interval; early: said long before it began. 95 %: bootstrap interval, sem: standard error of the mean; - : too few "
    "to "
    "tell. In brackets, detectors that know nothing: one that detects at once by chance pays with false alarms. From gross slip: "
    "below 0 where told before it.";

constexpr const char* false_alarm_legend =
    "A false alarm begins in no interval; one that begins within the guard after an interval is counted apart, and so is one in "
    "real motion that nobody labels. However long it lasts, it counts once: a detector that always says the same has one a run.";

Row delay_row(const std::string& name, const DelaySummary& delay) {
  return {name,
          number(delay.mean_ms),
          bounds(delay.mean_ms, 1),
          std::isfinite(delay.sem_ms) ? fmt::format("{:.2f}", delay.sem_ms) : "-",
          number(delay.median_ms),
          std::to_string(delay.intervals),
          std::to_string(delay.misses),
          std::to_string(delay.early)};
}

std::string delay_text(const std::string& title, const DelayTable& network,
                       const std::vector<std::pair<std::string, const DelayTable*>>& others) {
  std::vector<Row> rows;
  for (const auto& [name, delay] : network.objects) rows.push_back(delay_row(name, delay));
  rows.push_back(delay_row("all", network.all));
  for (const auto& [name, table] : others) rows.push_back(delay_row(name, table->all));
  return text_table({title, "mean", "95 %", "sem", "median", "of", "misses", "early"}, rows) + "\n";
}

std::string delays_text(const Evaluation& evaluation) {
  std::vector<std::pair<std::string, const DelayTable*>> press, slip;
  for (const auto& [name, score] : evaluation.trivial) {
    press.emplace_back("(" + name + ")", &score.press);
    slip.emplace_back("(" + name + ")", &score.slip);
  }
  if (evaluation.true_press) {
    press.emplace_back("from the true onset", &*evaluation.true_press);
    slip.emplace_back("from the true onset", &*evaluation.true_slip);
    slip.emplace_back("from gross slip", &*evaluation.gross_slip);
  }
  return delay_text("delay of press [ms]", evaluation.network.press, press) +
         delay_text("delay of slip [ms]", evaluation.network.slip, slip) + wrapped(delay_legend) + "\n\n";
}

std::string false_alarms_text(const Evaluation& evaluation) {
  const auto minutes = [](microseconds us) { return fmt::format("{:.3f}", static_cast<double>(us.count()) / 60e6); };
  const auto row = [&](const std::string& name, const FalseAlarmTable& table) {
    const FalseAlarms& total = table.total;
    return Row{name,
               number(table.per_min),
               bounds(table.per_min, 1),
               fmt::format("{} in {}", total.alarms, minutes(total.none_time)),
               fmt::format("{} in {}", total.after_intervals, minutes(total.after_intervals_time)),
               fmt::format("{} in {}", total.unlabelled, minutes(total.unlabelled_time))};
  };
  std::vector<Row> rows{row("network", evaluation.network.false_alarms)};
  for (const auto& [name, score] : evaluation.trivial) rows.push_back(row("(" + name + ")", score.false_alarms));
  return text_table({"false alarms per min", "", "95 %", "in min", "after", "unlabelled"}, rows) + wrapped(false_alarm_legend) +
         "\n";
}

std::string text_of(const Evaluation& evaluation) {
  return title_of(evaluation) + "\n\n" + accuracy_text(evaluation) + delays_text(evaluation) + false_alarms_text(evaluation);
}

std::string text_of(const UnseenComparison& comparison, bool simulated) {
  std::vector<Row> rows;
  const auto row = [&](const std::string& name, const Figure& seen, const Figure& held_out, const Figure& difference) {
    rows.push_back({name, percent(seen), bounds(seen, 100), percent(held_out), bounds(held_out, 100), percent(difference),
                    bounds(difference, 100)});
  };
  for (const auto& [name, seen] : comparison.seen.objects)
    row(name, seen, comparison.held_out.objects.at(name), comparison.difference.objects.at(name));
  row("mean over objects", comparison.seen.mean, comparison.held_out.mean, comparison.difference.mean);
  return fmt::format("Objects seen in training ({}) and held out ({}), on {} {} runs that neither learned from\n\n",
                     comparison.seen_model, comparison.held_out_model, comparison.runs.size(), simulated ? "simulated" : "real") +
         text_table({"accuracy on balanced samples [%]", "seen", "95 %", "held out", "95 %", "difference", "95 %"}, rows) + "\n";
}

EvaluationOptions options_of(const EvalArguments& args, const CommonArguments& common) {
  EvaluationOptions options;
  if (args.guard_ms >= 0) options.guard = microseconds{std::llround(args.guard_ms * 1000)};
  options.threads = common.threads;
  return options;
}

std::string train_command(const EvalArguments& args, const ModelSettings& settings) {
  std::string command = "tactile train";
  const ModelSettings defaults;
  const auto add = [&](const std::string& option, const auto& value, const auto& usual) {
    if (value != usual) command += fmt::format(" --{} {}", option, value);
  };
  if (args.data != "data") command += " " + args.data;
  command += fmt::format(" --th {}", static_cast<double>(settings.rendering.history.count()) / 1000);
  if (settings.split.kind == SplitKind::unseen) {
    command += " --split unseen";
    nlohmann::json ours = settings, usual = settings;
    ModelSettings with_default = settings;
    with_default.split.held_out = default_held_out();
    usual = with_default;
    if (ours != usual) command += fmt::format(" --held-out {}", fmt::join(settings.split.held_out, ","));
  }
  add("train-run", settings.split.train_run, defaults.split.train_run);
  add("seed", settings.training.seed, defaults.training.seed);
  add("epochs", settings.training.epochs, defaults.training.epochs);
  add("batch", settings.training.batch, defaults.training.batch);
  add("lr", settings.training.learning_rate, defaults.training.learning_rate);
  const nlohmann::json rendering = settings.rendering, usual = defaults.rendering;
  add("denoise", rendering.at("denoise").get<std::string>(), usual.at("denoise").get<std::string>());
  add("resize", rendering.at("resize").get<std::string>(), usual.at("resize").get<std::string>());
  add("factor", settings.rendering.factor, defaults.rendering.factor);
  add("tick-us", settings.rendering.tick.count(), defaults.rendering.tick.count());
  add("models", args.models, std::string("models"));
  return command;
}

ModelBundle bundle_named(const EvalArguments& args) {
  const fs::path given(args.model);
  if (fs::exists(given)) return {given.filename().empty() ? given.parent_path() : given};
  return {fs::path(args.models) / given};
}

std::optional<ModelBundle> newest_of(const EvalArguments& args, const Dataset& dataset, SplitKind kind) {
  return newest_bundle(args.models, [&](const ModelDescription& model) {
    return model.manifest_hash == dataset.manifest_hash() && model.settings.split.kind == kind;
  });
}

void evaluate_one(const EvalArguments& args, const CommonArguments& common) {
  let_openmp_threads_sleep();
  const fs::path file = dataset_file(args.data);
  if (!fs::exists(file)) {
    throw Error(fmt::format("{}: no such dataset; expected one with a model of it, run '{}' first", file.string(),
                            train_command(args, {})));
  }
  const Dataset dataset(file);
  const auto bundle = args.model.empty() ? newest_of(args, dataset, SplitKind::single_run) : bundle_named(args);
  if (!bundle) {
    throw Error(fmt::format("{}: no single-run model of {}; expected one, run '{}' first", args.models, file.string(),
                            train_command(args, {})));
  }
  spdlog::info("evaluating {}", bundle->folder.string());
  const Classifier classifier(bundle->folder, common.threads);
  const Split split = split_of(dataset, classifier.model().settings.split);
  const Evaluation evaluation = evaluate(dataset, classifier, split.test_runs, options_of(args, common), progress_line(common));
  const nlohmann::json json = evaluation;
  write_json(bundle->evaluation(), json);
  print_result(common, json, text_of(evaluation) + "\nWritten to " + bundle->evaluation().string() + "\n");
}

ModelSettings with_split(ModelSettings settings, SplitKind kind) {
  settings.split.kind = kind;
  if (kind == SplitKind::unseen) settings.split.held_out = default_held_out();
  return settings;
}

/// The model of the same settings that holds objects out, or does not; trained where it is missing.
ModelBundle partner_of(const EvalArguments& args, const CommonArguments& common, const Dataset& dataset,
                       const ModelSettings& settings, const std::optional<ModelBundle>& other) {
  const auto same = [&](const ModelDescription& model) {
    return model.manifest_hash == dataset.manifest_hash() && same_settings(model.settings, settings);
  };
  const auto same_but_held_out = [&](const ModelDescription& model) {
    ModelSettings alike = model.settings;
    alike.split.held_out = settings.split.held_out;
    return model.manifest_hash == dataset.manifest_hash() && same_settings(alike, settings);
  };
  if (const auto found = newest_bundle(args.models, same)) return *found;
  if (const auto found = newest_bundle(args.models, same_but_held_out)) return *found;
  const ModelBundle bundle{fs::path(args.models) / default_name(settings)};
  const std::string command = train_command(args, settings);
  if (args.no_train)
    throw Error(fmt::format("{}: missing; expected this model, run '{}' first", bundle.folder.string(), command));
  if (fs::exists(bundle.folder)) {
    throw Error(fmt::format("{}: is there, but of another dataset or damaged; expected it of {}, run '{} --force' first",
                            bundle.folder.string(), dataset.file().string(), command));
  }
  const auto rate = other ? images_per_s(*other) : std::nullopt;
  spdlog::info("{} is missing: it is trained first, as by '{}': {}", bundle.folder.string(), command,
               training_estimate(dataset, settings, rate, common.threads));
  train_model(dataset, settings, bundle, {.threads = common.threads, .resume = true}, progress_line(common));
  return bundle;
}

void evaluate_unseen(const EvalArguments& args, const CommonArguments& common) {
  let_openmp_threads_sleep();
  const fs::path file = dataset_file(args.data);
  if (args.no_train && !fs::exists(file)) {
    throw Error(fmt::format("{}: no such dataset; expected one with models of it, run '{}' first", file.string(),
                            train_command(args, {})));
  }
  make_missing_dataset(args.data, common);
  const Dataset dataset(file);
  std::optional<ModelBundle> known = args.model.empty() ? newest_of(args, dataset, SplitKind::single_run) : bundle_named(args);
  if (!known) known = newest_of(args, dataset, SplitKind::unseen);
  ModelSettings settings;
  if (known) settings = read_description(*known).settings;
  const bool knows_unseen = known && settings.split.kind == SplitKind::unseen;
  const ModelBundle seen =
      known && !knows_unseen ? *known : partner_of(args, common, dataset, with_split(settings, SplitKind::single_run), known);
  const ModelBundle held_out =
      knows_unseen ? *known : partner_of(args, common, dataset, with_split(settings, SplitKind::unseen), seen);
  spdlog::info("evaluating {} beside {}", held_out.folder.string(), seen.folder.string());

  const Classifier with(seen.folder, common.threads), without(held_out.folder, common.threads);
  const auto runs = runs_neither_saw(dataset, with.model().settings.split, without.model().settings.split);
  const EvaluationOptions options = options_of(args, common);
  const UnseenComparison comparison =
      compare_unseen(dataset, with, without, runs, options.bootstrap, common.threads, progress_line(common));
  const Evaluation evaluation = evaluate(dataset, without, runs, options, progress_line(common));
  nlohmann::json json = evaluation;
  json["unseen"] = comparison;
  write_json(seen.unseen_evaluation(), json);
  print_result(common, json,
               text_of(comparison, evaluation.simulated) + "The model that never saw these objects:\n\n" + text_of(evaluation) +
                   "\nWritten to " + seen.unseen_evaluation().string() + "\n");
}

}  // namespace

void add_eval_command(CLI::App& app) {
  auto args = std::make_shared<EvalArguments>();
  CLI::App* command = add_command(
      app, "eval", "Evaluate a model: accuracy, detection delay, false alarms, baselines",
      [args](const CommonArguments& common) { args->unseen ? evaluate_unseen(*args, common) : evaluate_one(*args, common); });
  command->add_option("data", args->data, "Folder whose dataset.h5 is meant, or a dataset; its run folders are read too")
      ->capture_default_str();
  command->add_option("--model", args->model,
                      "Model, a folder or a name below --models; the newest single-run model of the dataset if not given");
  command->add_option("--models", args->models, "Folder of models")->capture_default_str();
  command->add_flag("--unseen", args->unseen,
                    "Compare held-out objects with the same objects seen in training; trains what is missing");
  command->add_flag("--no-train", args->no_train,
                    "With --unseen: a missing model is an error that names the command to train it");
  command
      ->add_option("--guard-ms", args->guard_ms,
                   "For so long after an interval, alarms are counted apart [ms]; the dataset's own guard if not given")
      ->check(in_range(0.0, 1e6));
}

}  // namespace tactile
