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
#include "model_arguments.hpp"
#include "option_checks.hpp"
#include "rendering_arguments.hpp"
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
  std::string data = "data", models, out = "trade";
  std::string train_run = "01";
  std::vector<std::string> choice_runs{"02"};
  unsigned epochs = 10, steps = model::StreamOptions{}.steps;
  std::optional<unsigned> trainings;
  std::uint64_t seed = 1;
  std::vector<std::string> kinds{"lenet", "stream"};
  std::vector<double> histories_ms{2, 10, 20, 30, 40, 50};
  std::vector<std::int64_t> ticks_us{1000, 2000, 4000, 5000, 10'000};
  std::vector<double> factors{0.1, 0.2, 0.25};
  std::vector<std::string> resizes{"area", "linear"}, denoises{"mean", "literal", "none"};
  std::vector<std::string> augmentations{"none", "flip"};
  std::vector<std::string> engines{"fast", "libtorch"}, precisions{"fp32", "int8"};
  std::uint64_t timed_ticks = 20'000;
  bool full = false, verbose = false, no_figures = false, no_trial = false, strict = false, dry_run = false;
  unsigned corners = 6;
  std::optional<double> budget_minutes, at_most_us, at_least_accuracy, at_most_false_alarms, at_most_missed;
  std::string at_most_delay;
  std::string apply;
  ExecutorArguments executor;
};

/// The converted values, each once, in the order of the first.
template <class Value, class Convert>
auto each_once(const std::vector<Value>& values, Convert convert) {
  std::vector<std::decay_t<std::invoke_result_t<Convert, const Value&>>> levels;
  for (const Value& value : values) {
    const auto level = convert(value);
    if (std::find(levels.begin(), levels.end(), level) == levels.end()) levels.push_back(level);
  }
  return levels;
}

trade::TradeLevels levels_of(const TradeArguments& args) {
  return {.kinds = each_once(args.kinds, [](const auto& name) { return model::kind_named(name); }),
          .histories = each_once(args.histories_ms, [](double history_ms) { return whole_us(history_ms, "--th"); }),
          .ticks = each_once(args.ticks_us, [](std::int64_t tick_us) { return microseconds{tick_us}; }),
          .factors = each_once(args.factors, [](double factor) { return factor; }),
          .resizes = each_once(
              args.resizes, [](const auto& name) { return name == "area" ? heatmaps::Resize::area : heatmaps::Resize::linear; }),
          .denoises = each_once(args.denoises,
                                [](const auto& name) {
                                  return name == "mean"      ? heatmaps::Denoise::mean
                                         : name == "literal" ? heatmaps::Denoise::literal
                                                             : heatmaps::Denoise::none;
                                }),
          .augmentations = each_once(args.augmentations, [](const auto& text) { return trade::joined_augmentation_named(text); }),
          .engines = each_once(args.engines, [](const auto& name) { return model::engine_named(name); }),
          .precisions = each_once(args.precisions, [](const auto& name) { return model::precision_named(name); })};
}

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

/// "30" or "p90:30"; nothing of an empty text.
std::optional<trade::DelayLimit> delay_limit_in(const std::string& text) {
  if (text.empty()) return std::nullopt;
  const bool of_90 = text.starts_with(p90);
  const std::optional<double> ms = number_in(std::string_view(text).substr(of_90 ? p90.size() : 0));
  if (!ms || !(*ms > 0 && *ms <= 1e6)) return std::nullopt;
  return trade::DelayLimit{*ms, of_90};
}

Check is_delay_limit() {
  return Check{[](std::string& text) {
                 return delay_limit_in(text) ? std::string()
                                             : "'" + text + "' is no delay; expected milliseconds above 0 such as 30, or p90:30";
               },
               ""};
}

trade::TradeOptions options_of(const TradeArguments& args, const CommonArguments& common) {
  trade::TradeOptions options;
  options.data = args.data;
  options.models = experiments::models_folder(args.models, args.out);
  options.out = args.out;
  options.train_run = args.train_run;
  options.choice_runs = args.choice_runs;
  options.epochs = args.epochs;
  options.steps = args.steps;
  options.trainings = args.trainings.value_or(0);
  options.seed = args.seed;
  options.levels = levels_of(args);
  options.usual = usual_of(options.levels);
  options.full = args.full;
  options.corners = args.corners;
  options.budget_minutes = args.budget_minutes;
  options.timing.ticks = args.timed_ticks;
  if (args.no_trial) options.trial = std::chrono::milliseconds{0};
  options.constraints = {args.at_most_us, args.at_least_accuracy, args.at_most_false_alarms, delay_limit_in(args.at_most_delay),
                         args.at_most_missed};
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
  const fs::path file = fs::path(args.out) / "trade.json";
  if (!fs::exists(file)) return;
  nlohmann::json before;
  try {
    before = read_json(file).at("dataset");
    const windows::Dataset dataset(fs::path(args.data) / "dataset.h5");
    if (before.at("manifest_hash") == dataset.manifest_hash()) return;
    std::vector<std::string> differing;
    if (before.contains("settings"))
      differing = windows::differing_settings(windows::dataset_settings_in(dataset.settings()), before.at("settings"));
    spdlog::warn("{} is not the dataset that {} was measured on ({}): everything is measured again", dataset.file().string(),
                 args.out, differing.empty() ? "of other runs or labels" : fmt::format("{}", fmt::join(differing, ", ")));
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
  const std::optional<windows::DatasetSummary> made = make_missing_dataset(args.data, args.strict, common);
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
        summary.trade.busy, summary.trade.points.size(), (fs::path(args.out) / "times").string());
  }
  write_settings(common, fs::path(args.out) / "settings.json");
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
      result["figures"] = draw_figures(args.out);
      text += fmt::format("Figures: {}\n", (fs::path(args.out) / "figures").string());
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
  const auto add_list = [&command](const std::string& name, auto& values, const std::string& what) {
    return command.add_option(name, values, what + "; a list with commas").delimiter(',').show_default();
  };
  command.add_option("data", args->data, "Data folder with dataset.h5; a missing dataset is made").show_default();
  command.add_option("--at-most-us", args->at_most_us, "Constraint: 99 % of ticks take at most this long [us]")
      .check(in_range(0.001, 1e9))
      .type_name("US");
  command.add_option("--at-least-accuracy", args->at_least_accuracy, "Constraint: lowest accuracy")
      .check(in_range(0.0, 1.0))
      .type_name("SHARE");
  command
      .add_option("--at-most-false-alarms-per-min", args->at_most_false_alarms,
                  "Constraint: highest number of false alarms per minute outside of touches")
      .check(in_range(0.0, 1e9))
      .type_name("N");
  command
      .add_option("--at-most-delay-ms", args->at_most_delay,
                  "Constraint: longest median delay of all presses and slips [ms]; one that is missed or early is later than all "
                  "others. p90:MS limits the 90 % quantile")
      .check(is_delay_limit())
      .type_name("[p90:]MS");
  command.add_option("--at-most-missed", args->at_most_missed, "Constraint: largest share of presses and slips missed or early")
      .check(in_range(0.0, 1.0))
      .type_name("SHARE");
  command
      .add_option("--apply", args->apply,
                  "Write the chosen setting as a config file for 'detect', also one that is not confirmed")
      .type_name("FILE.json");
  command.add_flag("--full", args->full,
                   "Try every combination, not only single changes and promising combinations; takes many hours");
  command.add_option("--budget-minutes", args->budget_minutes, "Time limit of the whole command. The next call resumes")
      .check(in_range(0.0, 1e6))
      .type_name("MINUTES");
  command.add_option("--corners", args->corners, "Promising combinations to try for each of the two Pareto fronts")
      .check(in_range(0U, 1000U))
      .show_default();
  add_list("--kind", args->kinds, "Kinds of models to try: lenet, stream").check(one_of({"lenet", "stream"}));
  add_list("--th", args->histories_ms, "Histories t_h to try [ms]").check(in_range(0.001, 1e5));
  add_list("--tick-us", args->ticks_us, "Ticks to try [us]").check(in_range(std::int64_t{1}, std::int64_t{1'000'000}));
  add_list("--factor", args->factors, "Heatmap sizes to try, divided by sensor size").check(in_range(0.001, 1.0));
  add_list("--resize", args->resizes, "Resizing methods to try: area, linear").check(one_of({"area", "linear"}));
  add_list("--denoise", args->denoises, "Noise reductions to try: mean, literal, none")
      .check(one_of({"mean", "literal", "none"}));
  add_list("--augment", args->augmentations,
           "Augmentations of the training to try, with + where 'train' has commas: none, flip, flip+shift")
      .type_name("NAME")
      .check(readable_by(trade::joined_augmentation_named));
  add_list("--engine", args->engines, "Inference engines to try: fast, libtorch").check(one_of({"fast", "libtorch"}));
  add_list("--precision", args->precisions, "Precisions of the fast engine's largest layer to try: fp32, bf16, int8")
      .check(one_of({"fp32", "bf16", "int8"}));
  command.add_option("--train-run", args->train_run, "Run of each object to train on; the next one if it has no samples")
      .type_name("NN")
      .show_default();
  add_strict_option(command, args->strict);
  add_list("--choice-runs", args->choice_runs, "Runs to choose settings on; results are reported on all others").type_name("NN");
  command.add_option("--epochs", args->epochs, "Training epochs of a LeNet").check(in_range(1U, 100'000U)).show_default();
  command.add_option("--steps", args->steps, "Training steps of a stream").check(in_range(1U, 100'000U)).show_default();
  command
      .add_option("--trainings,--seeds", args->trainings,
                  "Trainings of each setting that is compared, each on another run and with another seed; default: 2 for "
                  "runs of the preset tiny, else 5")
      .check(in_range(1U, 1000U))
      .type_name("N");
  command.add_option("--timed-ticks", args->timed_ticks, "Lowest number of ticks to time for each setting")
      .check(in_range(std::uint64_t{1}, std::uint64_t{1'000'000'000}))
      .show_default();
  command.add_option("--seed", args->seed, "Seed of the first training").check(is_seed()).show_default();
  command.add_flag("--no-trial", args->no_trial, "Do not run the recommended setting in detect for 20 s");
  command.add_flag("--dry-run", args->dry_run, "Only print the number of steps, their hours and their size; needs the dataset");
  command.add_flag("--no-figures", args->no_figures, "Do not draw figures");
  add_executor_options(command, args->executor);
  command.add_flag("--verbose", args->verbose, "Print every setting");
  command.add_option("--models", args->models, "Folder of the models that it trains")
      .type_name("DIR")
      .default_text("models/ in --out");
  command.add_option("--out", args->out, "Output folder").type_name("DIR").show_default();
}

}  // namespace tactile::cli
