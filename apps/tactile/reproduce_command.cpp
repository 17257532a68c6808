#include <fmt/core.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "estimate_text.hpp"
#include "executor_arguments.hpp"
#include "experiment_output.hpp"
#include "field_options.hpp"
#include "model_arguments.hpp"
#include "option_checks.hpp"
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
#include "tactile/results/whole_runs_tables.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

struct ReproduceArguments {
  study::StudyOptions options{.models = "", .objects = {"all"}};
  bool without_report = false, verbose = false, dry_run = false;
  ExecutorArguments executor;
};

study::StudyOptions options_of(const ReproduceArguments& args, const CommonArguments& common) {
  study::StudyOptions options = args.options;
  options.models = experiments::models_folder(options.models, options.out);
  if (std::find(options.objects.begin(), options.objects.end(), "all") != options.objects.end()) options.objects.clear();
  options.program = fs::read_symlink("/proc/self/exe");
  options.threads = common.threads;
  options.slurm = slurm_of(args.executor);
  return options;
}

/// Commands that use the stream of the first world.
std::string next_commands(const ReproduceArguments& args, const results::Study& study) {
  const auto stream = std::find_if(study.models.begin(), study.models.end(),
                                   [](const results::StudiedModel& model) { return model.setting == "stream"; });
  const fs::path out = args.options.out;
  const std::string folder = shell_word((out / stream->folder).lexically_normal().string());
  const std::string data = shell_word((out / study.worlds[stream->world].data).lexically_normal().string());
  return fmt::format("To use its first stream:\n  tactile eval {} --model {}\n  tactile detect --model {}\n", data, folder,
                     folder);
}

std::string accuracies_text(const results::Study& study) {
  std::vector<std::vector<std::string>> rows;
  for (const results::StudiedSetting& setting : study.results)
    rows.push_back({setting.text, figure_text(setting.accuracy.mean, 100, 2)});
  return "Accuracy on balanced samples [%]: mean over objects, and its 95 % interval\n\n" + text_table({"setting", ""}, rows) +
         "\n";
}

std::string whole_runs_text(const results::Study& study) {
  std::string text;
  for (const results::StudiedSetting& setting : study.results) {
    const results::WholeRuns& whole = setting.whole_runs;
    if (whole.runs.empty()) continue;
    text += wrapped(fmt::format("{}. {}", setting.text, results::runs_in_words(whole))) + "\n\n";
    for (const results::TextTable& table : {results::calm_table(whole), results::confirmed_table(whole),
                                            results::baseline_table(whole, setting.baselines), results::cause_table(whole)}) {
      if (!table.rows.empty()) text += wrapped(table.caption + ":") + "\n" + text_table(table.head, table.rows) + "\n";
    }
  }
  return text;
}

std::string unseen_text(const results::Study& study) {
  std::string text;
  for (const results::StudiedUnseen& unseen : study.unseen) {
    std::vector<std::vector<std::string>> rows;
    const auto add = [&](const std::string& name, const results::SeenAndHeldOut& of) {
      rows.push_back({name, figure_text(of.seen, 100, 2), figure_text(of.held_out, 100, 2), figure_text(of.difference, 100, 2)});
    };
    for (const auto& [object, of] : unseen.accuracy.objects) add(object, of);
    add("mean over objects", unseen.accuracy.mean);
    text += fmt::format("Objects held out of training, {}: accuracy [%]\n\n", unseen.text) +
            text_table({"object", "seen", "unseen", "difference"}, rows) + "\n";
  }
  return text;
}

std::string claims_text(const std::vector<results::Claim>& claims) {
  std::vector<std::vector<std::string>> rows;
  std::string sentences;
  for (const results::Claim& claim : claims) {
    rows.push_back({claim.id, fmt::format("{} of {}", claim.written, claim.replicates), std::string(name_of(claim.outcome))});
    sentences += wrapped(claim.id + ": " + words_of(claim), 2) + "\n";
  }
  return "The paper's sentences, and in how many replicates of its study they would be written\n\n" +
         text_table({"sentence", "written in", "outcome"}, rows) + "\n" + sentences + "\n";
}

std::string text_of(const study::StudySummary& summary) {
  const results::Study& study = summary.study;
  double seconds = 0;
  for (const results::StepRecord& step : study.steps) seconds += step.seconds;
  return study.title + "\n\n" + whole_runs_text(study) + accuracies_text(study) + unseen_text(study) + claims_text(study.claims) +
         wrapped(study.intervals) + "\n" +
         wrapped(fmt::format("{} steps done, {} kept: {} (min:s) of work in all. Trainings and judgements run side by side.",
                             summary.done, summary.kept, clock_text(seconds))) +
         "\n\n";
}

constexpr const char* note_on_simulated_runs = "Results on simulated runs say nothing about real ones.\n";

std::string short_line(const results::StudiedSetting& setting) {
  const results::OperatingPoint& point = setting.whole_runs.decided;
  return wrapped(fmt::format("{}: {} false alarms a minute, median {} ms, 90 % within {} ms, {} of {} missed", setting.text,
                             figure_text(point.alarms_per_min, 1, 1), results::value_text(point.median_ms),
                             results::value_text(point.p90_ms), point.misses + point.early, point.touches),
                 2) +
         "\n";
}

/// The figures that matter most.
std::string short_text(const study::StudySummary& summary) {
  const results::Study& study = summary.study;
  std::string text = wrapped(study.title) + "\n\n";
  for (const results::StudiedSetting& setting : study.results) {
    if (!setting.whole_runs.runs.empty()) text += short_line(setting);
  }
  text += wrapped(study.found.back()) + "\n";
  text += fmt::format("{} steps done, {} kept; --verbose prints all tables\n", summary.done, summary.kept);
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
  write_settings(common, args.options.out / "settings.json");
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
  study::StudyOptions& options = args->options;
  command.add_path_option("data", options.data, "Folder of runs; runs are simulated if it has none").show_default();
  command
      .add_option("--preset", options.preset,
                  "tiny: 1 simulated world of 2 runs per object, 2 trainings of 3 epochs and 100 steps; quick: 3 worlds of 3 "
                  "runs, 6 epochs, 800 steps; paper: 8 worlds of 10 runs, 10 epochs, 1600 steps. One training in each world; "
                  "on runs that are there, 5 trainings")
      .check(one_of({"paper", "quick", "tiny"}))
      .show_default();
  command.add_option("--worlds", options.worlds, "Simulated worlds, each with another seed; default: the preset's")
      .check(in_range(1U, 1000U))
      .type_name("N");
  command.add_option("--objects", options.objects, "Objects to simulate, separated by commas, or all")
      .delimiter(',')
      .type_name("NAME,...")
      .suggest(simulated_objects())
      .show_default();
  command.add_option("--runs", options.runs, "Simulated runs per object; default: the preset's")
      .check(in_range(1, 99))
      .type_name("N");
  command.add_flag("--force", options.force, "Replace runs that were simulated with other settings");
  add_histories_option(command, options.histories, "Histories t_h to train [ms]");
  command
      .add_option("--train-run", options.train_run,
                  "Run of each object that the first training learns from; the others learn from the runs after it")
      .check(is_run())
      .type_name("NN")
      .show_default();
  command
      .add_option("--held-out", options.held_out,
                  "Objects held out in the unseen test, separated by commas; default: those of the paper's five that exist, and "
                  "in every second world the others")
      .delimiter(',')
      .type_name("NAME,...");
  command.add_option("--epochs", options.epochs, "Training epochs of a LeNet; default: the preset's")
      .check(in_range(1U, 100'000U))
      .type_name("N");
  command.add_option("--steps", options.steps, "Training steps of a stream; default: the preset's")
      .check(in_range(1U, 1'000'000U))
      .type_name("N");
  command
      .add_option("--trainings", options.trainings,
                  "Trainings of each setting in each world, each on another run and seed; default: the preset's")
      .check(in_range(1U, 1000U))
      .type_name("N");
  command.add_option("--seed", options.seed, "Seed of the first world and its first training; the next ones add 1, 2, ...")
      .check(is_seed())
      .show_default();
  add_word(command, "--engine", options.engine, model::training_engines,
           "Engine for training and inference: fast (tactile's own) or libtorch");
  command.add_flag("--include-flagged", options.include_flagged, "Also use flagged runs and intervals");
  add_strict_option(command, options.strict);
  add_executor_options(command, args->executor);
  command.add_flag("--dry-run", args->dry_run, "Only print the study's steps, hours and size on the disk");
  command.add_flag("--verbose", args->verbose, "Print all tables and what was found");
  command.add_flag("--no-report", args->without_report, "Do not write the report");
  command.add_path_option("--models", options.models, "Folder of the models that it trains")
      .type_name("DIR")
      .default_text("models/ in --out");
  command.add_path_option("--out", options.out, "Output folder of the study").type_name("DIR").show_default();
}

}  // namespace tactile::cli
