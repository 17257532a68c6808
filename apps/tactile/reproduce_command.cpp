#include <fmt/core.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "estimate_text.hpp"
#include "executor_arguments.hpp"
#include "experiment_output.hpp"
#include "model_arguments.hpp"
#include "option_checks.hpp"
#include "rendering_arguments.hpp"
#include "suggested_words.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/progress.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/experiments/models_folder.hpp"
#include "tactile/experiments/step_runner.hpp"
#include "tactile/experiments/study/estimate_study.hpp"
#include "tactile/experiments/study/study.hpp"
#include "tactile/report/report.hpp"
#include "tactile/results/figure_text.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

struct ReproduceArguments {
  std::string data = "data", models, out = "study";
  std::string preset = "quick";
  std::vector<std::string> objects{"all"};
  int runs = 0;
  bool force = false;
  std::vector<double> histories_ms{2, 10, 20, 30, 40, 50};
  std::string train_run = "01";
  std::vector<std::string> held_out;
  unsigned epochs = 0, trainings = 0;
  std::uint64_t seed = 1;
  std::string splits;
  std::string engine = "fast";
  bool include_flagged = false, strict = false;
  bool without_report = false, verbose = false, dry_run = false;
  ExecutorArguments executor;
};

/// "all", or a whole number >= 0.
std::size_t number_of_splits(const std::string& text) {
  if (text == "all") return std::numeric_limits<std::size_t>::max();
  std::size_t number = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (failed != std::errc{} || end != text.data() + text.size())
    throw Error(fmt::format("'{}' is no number of splits; expected a whole number from 0 on, or all", text));
  return number;
}

study::StudyOptions options_of(const ReproduceArguments& args, const CommonArguments& common) {
  study::StudyOptions options;
  options.data = args.data;
  options.models = experiments::models_folder(args.models, args.out);
  options.out = args.out;
  options.preset = args.preset;
  options.objects = args.objects;
  if (std::find(options.objects.begin(), options.objects.end(), "all") != options.objects.end()) options.objects.clear();
  if (args.runs > 0) options.runs = args.runs;
  options.force = args.force;
  options.include_flagged = args.include_flagged;
  options.strict = args.strict;
  options.histories.clear();
  for (const double history_ms : args.histories_ms) options.histories.push_back(heatmap_options(history_ms, {}).history);
  options.train_run = args.train_run;
  options.hold_out_each = args.held_out == std::vector<std::string>{"each"};
  if (!options.hold_out_each) options.held_out = args.held_out;
  if (args.epochs > 0) options.epochs = args.epochs;
  if (args.trainings > 0) options.trainings = args.trainings;
  options.seed = args.seed;
  if (!args.splits.empty()) options.splits = number_of_splits(args.splits);
  options.program = fs::read_symlink("/proc/self/exe");
  options.engine = model::engine_named(args.engine);
  options.threads = common.threads;
  options.slurm = slurm_of(args.executor);
  return options;
}

std::string mean_of(const std::optional<results::Accuracy>& accuracy) {
  return accuracy ? figure_text(accuracy->mean, 100, 2) : "-";
}

/// "3 of 10 objects", where a claim is counted over objects.
std::string kept_text(const results::Claim& claim) {
  return claim.kept && claim.of ? fmt::format("{} of {} objects", *claim.kept, *claim.of) : "-";
}

/// Commands that use the chosen model.
std::string next_commands(const ReproduceArguments& args, const results::Study& study) {
  // Each training is judged with the history that it chose.
  const bool is_judged = study.trainings.front().history_ms == study.choice.history_ms;
  const std::string folder = shell_word((experiments::models_folder(args.models, args.out) / study.choice.model).string());
  const std::string data = args.data == "data" ? "" : " " + shell_word(args.data);
  return fmt::format("To use the chosen model{}:\n  tactile eval{} --model {}\n  tactile export --model {} --onnx model.onnx\n",
                     is_judged ? "" : ", whose delays and false alarms 'eval' measures", data, folder, folder);
}

std::string histories_text(const results::Study& study) {
  std::vector<std::vector<std::string>> rows;
  for (const results::StudyHistory& history : study.histories) {
    rows.push_back({fmt::format("{}", history.history_ms), mean_of(history.accuracy.choice), mean_of(history.accuracy.reported),
                    mean_of(history.accuracy.all_test)});
  }
  return "Accuracy by history [%]: mean over objects, and its 95 % interval\n\n" +
         text_table({"t_h [ms]", "to choose on", "reported", "all test runs"}, rows) + "\n" +
         wrapped(study.choice.why + " As in the paper: " + study.paper_way.why) + "\n\n";
}

std::string unseen_text(const results::Study& study) {
  std::string text;
  if (study.unseen && study.unseen->on.reported) {
    std::vector<std::vector<std::string>> rows;
    for (const auto& [object, figures] : study.unseen->on.reported->objects) {
      rows.push_back({object, figure_text(figures.seen, 100, 2), figure_text(figures.held_out, 100, 2),
                      figure_text(figures.difference, 100, 2)});
    }
    text +=
        "Objects held out of training: accuracy [%]\n\n" + text_table({"object", "seen", "unseen", "difference"}, rows) + "\n";
  }
  if (!study.splits.empty()) {
    text += wrapped(fmt::format("{} random splits: unseen minus seen is {} points on the reported runs.", study.splits.size(),
                                figure_text(study.splits_mean.reported.value_or(results::Figure{}), 100, 2))) +
            "\n\n";
  }
  return text;
}

std::string claims_text(const std::vector<results::Claim>& claims) {
  std::vector<std::vector<std::string>> rows;
  std::string sentences;
  for (const results::Claim& claim : claims) {
    rows.push_back({claim.id, kept_text(claim), std::string(name_of(claim.outcome)),
                    claim.all_test ? std::string(name_of(claim.all_test->outcome)) : "-"});
    std::string words = claim.id + ":";
    if (!claim.in_words.empty()) words += " " + claim.in_words;
    if (!claim.why.empty()) words += fmt::format(" Not decided: {}.", claim.why);
    sentences += wrapped(words, 2) + "\n";
  }
  return "The paper's claims\n\n" + text_table({"claim", "true for", "outcome", "as in the paper"}, rows) + "\n" + sentences +
         "\n";
}

std::string text_of(const study::StudySummary& summary) {
  const results::Study& study = summary.study;
  double seconds = 0;
  for (const results::StepRecord& step : study.steps) seconds += step.seconds;
  std::string trainings = study.bootstrap.trainings;
  if (study.variance) trainings += fmt::format(" Of the variance of the mean accuracy, {}.", words_of(*study.variance));
  return study.title + "\n\n" + histories_text(study) + unseen_text(study) + claims_text(study.claims) + wrapped(trainings) +
         "\n" +
         wrapped(fmt::format("{} steps done, {} kept: {} (min:s) of work in all. Trainings and judgements run side by side.",
                             summary.done, summary.kept, clock_text(seconds))) +
         "\n\n";
}

/// The label, and its words in a column of their own.
std::string short_line(const std::string& label, const std::string& words) {
  constexpr std::size_t column = 12;
  return wrapped(fmt::format("{:<{}}{}", label, column, words), column) + "\n";
}

/// The claims' outcomes, counted: "4 holds, 2 does not, 5 cannot tell".
std::string outcomes_of(const std::vector<results::Claim>& claims) {
  std::map<std::string_view, std::size_t> outcomes;
  for (const results::Claim& claim : claims) ++outcomes[name_of(claim.outcome)];
  std::string text;
  for (const auto& [outcome, count] : outcomes) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, outcome);
  return text;
}

constexpr const char* note_on_simulated_runs = "Results on simulated runs say nothing about real ones.\n";

/// The figures that matter most: at most 9 lines.
std::string short_text(const study::StudySummary& summary) {
  const results::Study& study = summary.study;
  std::string text = wrapped(study.title) + "\n\n";
  for (const results::StudyHistory& history : study.histories) {
    if (history.history_ms != study.choice.history_ms) continue;
    text += short_line("accuracy", fmt::format("{} % with t_h {:g} ms, on the reported runs", mean_of(history.accuracy.reported),
                                               history.history_ms));
  }
  if (study.unseen && study.unseen->on.reported) {
    const results::SeenAndHeldOut& mean = study.unseen->on.reported->mean;
    text += short_line("held out", fmt::format("{} %, {} points from seen objects", figure_text(mean.held_out, 100, 2),
                                               figure_text(mean.difference, 100, 2)));
  }
  text += short_line("claims", fmt::format("of the paper's {}: {}", study.claims.size(), outcomes_of(study.claims)));
  text += short_line("steps", fmt::format("{} done, {} kept; --verbose prints all tables", summary.done, summary.kept));
  if (study.simulated) text += note_on_simulated_runs;
  return text;
}

/// What was found: the last screen.
std::string found_text(const results::Study& study) {
  std::string text = "What was found\n\n";
  for (const std::string& sentence : study.found) text += wrapped(sentence) + "\n";
  if (study.simulated) text += note_on_simulated_runs;
  return text;
}

/// Draws the study's report, unless it exists and was drawn from this study.
fs::path draw_report(const fs::path& study, const fs::path& program, const experiments::NewProgress& new_progress) {
  const fs::path out = study / "report";
  fs::path page = out / "report.html";
  const auto page_made = [&]() -> nlohmann::json {
    return fs::is_regular_file(page) ? nlohmann::json(sha256_of_file(page)) : nlohmann::json();
  };
  experiments::StepRunner runner({.folder = study, .program = program, .new_progress = new_progress, .on_step = log_step});
  runner.run({.name = "report",
              .command = "tactile report " + shell_word(study.string()),
              .inputs = {{"study_sha256", sha256_of_file(study / "study.json")}},
              .outputs = page_made,
              .work = [&](const ProgressCallback& progress) {
                report::write_report(study, out, [&](std::string_view figure) {
                  stop_if_interrupted();
                  report_progress(progress, 0, 0, fmt::format("report: drawing {}", figure));
                });
              }});
  return page;
}

void reproduce(const ReproduceArguments& args, const CommonArguments& common) {
  const study::StudyOptions options = options_of(args, common);
  if (args.dry_run) {
    const auto estimate = study::estimate_study(options);
    return print_estimate(estimate, options.out, options.slurm.has_value(), common);
  }
  const auto new_progress = [&] { return progress_line(common); };
  const study::StudySummary summary = resumable([&] {
    return study::run_study(options, new_progress, log_step, [](const std::string& sentence) { spdlog::warn("{}", sentence); });
  });
  write_settings(common, fs::path(args.out) / "settings.json");
  nlohmann::json result = summary.study;
  result["file"] = summary.file.string();
  result["steps_done"] = summary.done;
  result["steps_kept"] = summary.kept;
  result["report"] = nullptr;
  result["errors"] = summary.errors;
  std::string text = (args.verbose ? text_of(summary) + found_text(summary.study) : short_text(summary)) +
                     fmt::format("\nWritten to {}\n", summary.file.string()) + next_commands(args, summary.study);
  if (args.without_report) {
    print_result(common, result, text);
    return end_with(summary.errors);
  }
  try {
    const fs::path page = draw_report(options.out, options.program, new_progress);
    // The report is what this command writes from the study's folder.
    write_json(page.parent_path() / "settings.json", {{"what", options.out.string()}, {"out", page.parent_path().string()}});
    result["report"] = page.string();
    text += fmt::format("Report with figures: {}\n", page.string());
  } catch (const Error&) {
    // The study is complete: print it before the error.
    print_result(common, result, text);
    throw;
  }
  print_result(common, result, text);
  end_with(summary.errors);
}

}  // namespace

void add_reproduce_command(CLI::App& app) {
  // A long list of one option per line, in the order of --help: divided, it would no longer show the whole.
  auto args = std::make_shared<ReproduceArguments>();
  Command command = add_command(app, "reproduce", "Run the paper's whole study and compare its claims with measured results",
                                [args](const CommonArguments& common) { reproduce(*args, common); });
  command.add_option("data", args->data, "Folder of runs; runs are simulated if it has none").show_default();
  command
      .add_option("--preset", args->preset,
                  "tiny: 2 simulated runs per object, 3 epochs, 2 trainings, t_h is not chosen; quick: 3 runs, 6 epochs, "
                  "5 trainings, 1 run to choose on; paper: 10 runs, 10 epochs, 5 trainings, 2 runs to choose on, 20 splits")
      .check(one_of({"paper", "quick", "tiny"}))
      .show_default();
  command.add_option("--objects", args->objects, "Objects to simulate, separated by commas, or all")
      .delimiter(',')
      .type_name("NAME,...")
      .suggest(simulated_objects())
      .show_default();
  command.add_option("--runs", args->runs, "Simulated runs per object; default: the preset's")
      .check(in_range(1, 99))
      .type_name("N");
  command.add_flag("--force", args->force, "Replace runs that were simulated with other settings");
  command.add_option("--th", args->histories_ms, "Histories t_h to train [ms], separated by commas")
      .delimiter(',')
      .check(in_range(0.001, 1e5))
      .show_default();
  command
      .add_option("--train-run", args->train_run,
                  "Run of each object that the first training learns from; the others learn from the runs after it")
      .check(is_run())
      .type_name("NN")
      .show_default();
  command
      .add_option("--held-out", args->held_out,
                  "Objects held out in the unseen test, separated by commas, or each: one at a time; default: those of the "
                  "paper's five that exist")
      .delimiter(',')
      .type_name("NAME,...");
  command.add_option("--epochs", args->epochs, "Training epochs; default: the preset's")
      .check(in_range(1U, 100'000U))
      .type_name("N");
  command
      .add_option("--trainings", args->trainings,
                  "Trainings of each setting, each on another run and seed; claims need 5 or more; default: the preset's")
      .check(in_range(1U, 1000U))
      .type_name("N");
  command.add_option("--seed", args->seed, "Seed of simulation, samples, random splits and the first training")
      .check(is_seed())
      .show_default();
  command.add_option("--splits", args->splits, "Number of other splits to train, drawn at random, or all; default: the preset's")
      .check(readable_by(number_of_splits))
      .type_name("N|all");
  command.add_option("--engine", args->engine, "Engine for training and inference: fast (tactile's own) or libtorch")
      .check(one_of({"fast", "libtorch"}))
      .show_default();
  command.add_flag("--include-flagged", args->include_flagged, "Also use flagged runs and intervals");
  add_strict_option(command, args->strict);
  add_executor_options(command, args->executor);
  command.add_flag("--dry-run", args->dry_run, "Only print the study's steps, hours and size on the disk");
  command.add_flag("--verbose", args->verbose, "Print all tables and what was found");
  command.add_flag("--no-report", args->without_report, "Do not write the report");
  command.add_option("--models", args->models, "Folder of the models that it trains")
      .type_name("DIR")
      .default_text("models/ in --out");
  command.add_option("--out", args->out, "Output folder of the study").type_name("DIR").show_default();
}

}  // namespace tactile::cli
