#include <fmt/core.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "estimate_text.hpp"
#include "executor_arguments.hpp"
#include "experiment_output.hpp"
#include "field_options.hpp"
#include "model_arguments.hpp"
#include "option_checks.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/experiments/models_folder.hpp"
#include "tactile/experiments/run_division.hpp"
#include "tactile/experiments/trade/estimate_trade.hpp"
#include "tactile/experiments/trade/trade.hpp"
#include "tactile/pictures/gnuplot.hpp"
#include "tactile/report/budget_plot.hpp"
#include "tactile/report/trade_plots.hpp"
#include "tactile/results/experiment_file.hpp"
#include "tactile/windows/dataset.hpp"
#include "tactile/windows/dataset_settings.hpp"
#include "trade_text.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

struct TradeArguments {
  trade::TradeOptions options{.models = ""};
  bool verbose = false, no_figures = false, no_trial = false, strict = false, dry_run = false;
  std::string apply;
  ExecutorArguments executor;
};

/// Replaces a usual value that is not among the values to try by the first of them.
template <class T, class Values>
void take_usual(T& usual, const Values& values) {
  if (std::find(values.begin(), values.end(), usual) == values.end()) usual = values.front();
}

trade::TradeSetting usual_of(const trade::TradeLevels& levels) {
  trade::TradeSetting usual;
  take_usual(usual.rendering.history, levels.histories);
  take_usual(usual.rendering.tick, levels.ticks);
  take_usual(usual.rendering.factor, levels.factors);
  take_usual(usual.rendering.resize, levels.resizes);
  take_usual(usual.rendering.denoise, levels.denoises);
  take_usual(usual.augmentation, levels.augmentations);
  take_usual(usual.engine, levels.engines);
  take_usual(usual.precision, levels.precisions);
  take_usual(usual.kind, levels.kinds);
  return without_idle_values(usual);
}

constexpr std::string_view p90 = "p90:";

/// "30" or "p90:30". @throws Error
trade::DelayLimit delay_limit_in(const std::string& text) {
  const bool of_90 = text.starts_with(p90);
  const std::optional<double> ms = number_in(std::string_view(text).substr(of_90 ? p90.size() : 0));
  if (!ms || !(*ms > 0 && *ms <= 1e6))
    throw Error("'" + text + "' is no delay; expected milliseconds above 0 such as 30, or p90:30");
  return {*ms, of_90};
}

trade::TradeOptions options_of(const TradeArguments& args, const CommonArguments& common) {
  trade::TradeOptions options = args.options;
  options.models = experiments::models_folder(options.models, options.out);
  options.usual = usual_of(options.levels);
  if (args.no_trial) options.trial = std::chrono::milliseconds{0};
  options.program = fs::read_symlink("/proc/self/exe");
  options.threads = common.threads;
  options.slurm = slurm_of(args.executor);
  return options;
}

std::vector<std::string> draw_figures(const fs::path& out) {
  const results::Trade trade = results::read_experiment<results::Trade>(out / "trade.json");
  const std::vector<std::pair<std::string, pictures::Plot>> plots{{"trade-accuracy", report::trade_accuracy_plot(trade)},
                                                                  {"trade-delay", report::trade_delay_plot(trade)},
                                                                  {"trade-budgets", report::trade_budget_plot(trade)}};
  return draw_plots(plots, out / "figures");
}

/// Warns if the results in the folder are of another dataset: all is measured again, which may take hours.
void warn_of_another_dataset(const TradeArguments& args) {
  const fs::path file = args.options.out / "trade.json";
  if (!fs::exists(file)) return;
  nlohmann::json before;
  try {
    before = read_json(file).at("dataset");
    const windows::Dataset dataset(args.options.data / "dataset.h5");
    if (before.at("manifest_hash") == dataset.manifest_hash()) return;
    std::vector<std::string> differing;
    if (before.contains("settings"))
      differing = windows::differing_settings(windows::dataset_settings_in(dataset.settings()), before.at("settings"));
    spdlog::warn("{} is not the dataset that {} was measured on ({}): everything is measured again", dataset.file().string(),
                 args.options.out.string(),
                 differing.empty() ? "of other runs or labels" : fmt::format("{}", fmt::join(differing, ", ")));
  } catch (const nlohmann::json::exception&) {
  } catch (const Error&) {  // run_trade reports what is wrong with the dataset
  }
}

/// Warns if runs or objects are not those requested, or give no interval to confirm a setting with.
void warn_of_runs(const trade::TradeOptions& options, bool strict) {
  const windows::Dataset dataset(options.data / "dataset.h5");
  const windows::SplitOptions split{.kind = windows::SplitKind::single_run, .train_run = options.train_run};
  warn_of_splits(dataset, {&split, 1}, strict);
  for (const std::string& remark :
       experiments::remarks_on(dataset, experiments::divide_runs(dataset, options.train_run, options.choice_runs)))
    spdlog::warn("{}", remark);
  if (!options.constraints.any()) return;
  if (const std::string why = trade::why_unconfirmable(trade::completed(options, dataset), dataset); !why.empty())
    spdlog::warn("{}", why);
}

/// Before the first step of a new trade: how long all of them take.
void log_duration(const trade::TradeOptions& options, const CommonArguments& common) {
  if (common.quiet || options.budget_minutes || options.slurm || fs::exists(options.out / "steps")) return;
  spdlog::info("this takes about {} at most; --dry-run lists the parts, and --budget-minutes sets a limit",
               duration_text(trade::estimate_trade(options)));
}

void trade(const TradeArguments& args, const CommonArguments& common) {
  const trade::TradeOptions options = options_of(args, common);
  if (!args.apply.empty() && !options.constraints.any()) {
    throw Error(
        "--apply: no constraint given; expected also --at-most-us, --at-least-accuracy, --at-most-false-alarms-per-min, "
        "--at-most-delay-ms or --at-most-missed");
  }
  if (args.dry_run) return print_estimate(trade::estimate_trade(options), options.out, options.slurm.has_value(), common);
  const std::optional<windows::DatasetSummary> made = make_missing_dataset(args.options.data, args.strict, common);
  if (!made) warn_of_another_dataset(args);
  warn_of_runs(options, args.strict);
  log_duration(options, common);
  const trade::TradeSummary summary = resumable([&] {
    return trade::run_trade(
        options, [&] { return progress_line(common); }, log_step);
  });
  if (summary.trade.busy > 0) {
    spdlog::warn(
        "other programs interrupted more than 1 % of the ticks of {} of {} settings, so their p99 is the machine's; remove {} "
        "and run this again on an idle machine",
        summary.trade.busy, summary.trade.points.size(), (args.options.out / "times").string());
  }
  write_settings(common, args.options.out / "settings.json");
  nlohmann::json result = summary.trade;
  result["file"] = summary.file.string();
  result["steps_done"] = summary.done;
  result["steps_kept"] = summary.kept;
  result["figures"] = nlohmann::json::array();
  result["applied"] = nullptr;
  std::string text = args.verbose ? full_trade_text(summary) : short_trade_text(summary);
  const auto print_all = [&] { print_result(common, result, text); };
  const results::TradeRecommendation& recommendation = summary.trade.recommendation;
  try {
    if (!args.no_figures) {
      result["figures"] = draw_figures(args.options.out);
      text += fmt::format("Figures: {}\n", (args.options.out / "figures").string());
    }
    if (!args.apply.empty()) {
      if (!summary.detect_options) throw Error("no setting to apply: " + recommendation.sentence);
      nlohmann::json config = *summary.detect_options;
      config["comment"] = (recommendation.met ? "" : "Not confirmed. ") + recommendation.sentence;
      write_json(args.apply, config);
      result["applied"] = args.apply;
      text += wrapped(fmt::format("{}{}: for 'tactile detect --config {}'", args.apply,
                                  recommendation.met ? "" : " (a setting that is not confirmed)", shell_word(args.apply))) +
              "\n";
    }
  } catch (const Error&) {
    // The measurements are complete: print them before the error.
    print_all();
    throw;
  }
  print_all();
  if (made) end_with(made->errors);
  if (!args.apply.empty() && !recommendation.met) throw CheckFailed{};
}

}  // namespace

void add_trade_command(CLI::App& app) {
  // A long list of one option per line, in the order of --help: divided, it would no longer show the whole.
  auto args = std::make_shared<TradeArguments>();
  Command command = add_command(app, "trade", "Measure speed against accuracy, delay and false alarms, and recommend settings",
                                [args](const CommonArguments& common) { trade(*args, common); });
  trade::TradeOptions& options = args->options;
  trade::TradeConstraints& constraints = options.constraints;
  trade::TradeLevels& levels = options.levels;
  command.add_path_option("data", options.data, "Data folder with dataset.h5; a missing dataset is made").show_default();
  command.add_option("--at-most-us", constraints.at_most_us, "Constraint: 99 % of ticks take at most this long [us]")
      .check(in_range(0.001, 1e9))
      .type_name("US");
  command.add_option("--at-least-accuracy", constraints.at_least_accuracy, "Constraint: lowest accuracy")
      .check(in_range(0.0, 1.0))
      .type_name("SHARE");
  command
      .add_option("--at-most-false-alarms-per-min", constraints.at_most_false_alarms_per_min,
                  "Constraint: highest number of false alarms per minute outside of touches")
      .check(in_range(0.0, 1e9))
      .type_name("N");
  command
      .add_text_option(
          "--at-most-delay-ms", [] { return std::string(); },
          [&constraints](const std::string& text) { constraints.at_most_delay = delay_limit_in(text); },
          "Constraint: longest median delay of all presses and slips [ms]; one that is missed or early is later than all others. "
          "p90:MS limits the 90 % quantile")
      .check(readable_by(delay_limit_in))
      .type_name("[p90:]MS");
  command
      .add_option("--at-most-missed", constraints.at_most_missed,
                  "Constraint: largest share of presses and slips missed or early")
      .check(in_range(0.0, 1.0))
      .type_name("SHARE");
  command
      .add_option("--apply", args->apply,
                  "Write the chosen setting as a config file for 'detect', also one that is not confirmed")
      .type_name("FILE.json");
  command.add_flag("--full", options.full,
                   "Try every combination, not only single changes and promising combinations; takes many hours");
  command.add_option("--budget-minutes", options.budget_minutes, "Time limit of the whole command. The next call resumes")
      .check(in_range(0.0, 1e6))
      .type_name("MINUTES");
  command.add_option("--corners", options.corners, "Promising combinations to try for each of the two Pareto fronts")
      .check(in_range(0U, 1000U))
      .show_default();
  add_word_list(command, "--kind", levels.kinds, model::trained_kinds, "Kinds of models to try");
  add_histories_option(command, levels.histories, "Histories t_h to try [ms]");
  add_duration_list(command, "--tick-us", levels.ticks, 1, 1'000'000, 1, "Ticks to try [us]");
  add_number_list(command, "--factor", levels.factors, 0.001, 1, "Heatmap sizes to try, divided by sensor size");
  add_word_list(command, "--resize", levels.resizes, heatmaps::resize_names, "Resizing methods to try");
  add_word_list(command, "--denoise", levels.denoises, heatmaps::denoise_names, "Noise reductions to try");
  add_list(command, "--augment", levels.augmentations, trade::joined_text_of, trade::joined_augmentation_named,
           "Augmentations of the training to try, with + where 'train' has commas: none, flip, flip+shift")
      .type_name("NAME")
      .check(readable_by(trade::joined_augmentation_named));
  add_word_list(command, "--engine", levels.engines, model::training_engines, "Inference engines to try");
  add_word_list(command, "--precision", levels.precisions, model::precision_names,
                "Precisions of the fast engine's largest layer to try");
  command.add_option("--train-run", options.train_run, "Run of each object to train on; the next one if it has no samples")
      .type_name("NN")
      .show_default();
  add_strict_option(command, args->strict);
  command
      .add_option("--choice-runs", options.choice_runs,
                  "Runs to choose settings on, separated by commas; results are reported on all others")
      .delimiter(',')
      .type_name("NN")
      .show_default();
  command.add_option("--epochs", options.epochs, "Training epochs of a LeNet").check(in_range(1U, 100'000U)).show_default();
  command.add_option("--steps", options.steps, "Training steps of a stream").check(in_range(1U, 100'000U)).show_default();
  command
      .add_option("--trainings", options.trainings,
                  "Trainings of each setting that is compared, each on another run and with another seed; default: 2 for "
                  "runs of the preset tiny, else 5")
      .check(in_range(1U, 1000U))
      .type_name("N");
  command.add_option("--timed-ticks", options.timing.ticks, "Lowest number of ticks to time for each setting")
      .check(in_range(std::uint64_t{1}, std::uint64_t{1'000'000'000}))
      .show_default();
  command.add_option("--seed", options.seed, "Seed of the first training").check(is_seed()).show_default();
  command.add_flag("--no-trial", args->no_trial, "Do not run the recommended setting in detect for 20 s");
  command.add_flag("--dry-run", args->dry_run, "Only print the number of steps, their hours and their size; needs the dataset");
  command.add_flag("--no-figures", args->no_figures, "Do not draw figures");
  add_executor_options(command, args->executor);
  command.add_flag("--verbose", args->verbose, "Print every setting");
  command.add_path_option("--models", options.models, "Folder of the models that it trains")
      .type_name("DIR")
      .default_text("models/ in --out");
  command.add_path_option("--out", options.out, "Output folder").type_name("DIR").show_default();
}

}  // namespace tactile::cli
