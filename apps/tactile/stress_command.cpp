#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "chosen_model.hpp"
#include "command.hpp"
#include "commands.hpp"
#include "estimate_text.hpp"
#include "eval_models.hpp"
#include "executor_arguments.hpp"
#include "experiment_output.hpp"
#include "model_arguments.hpp"
#include "option_checks.hpp"
#include "quantity_text.hpp"
#include "suggested_words.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/experiments/stress/estimate_stress.hpp"
#include "tactile/experiments/stress/simulated_worlds.hpp"
#include "tactile/experiments/stress/stress.hpp"
#include "tactile/experiments/stress/stress_judgements.hpp"
#include "tactile/pictures/contact_sheet.hpp"
#include "tactile/pictures/gnuplot.hpp"
#include "tactile/pictures/recipe_sheet.hpp"
#include "tactile/report/stress_plots.hpp"
#include "tactile/results/figure_text.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

struct StressArguments {
  std::string data = "data", models = "models", out = "stress";
  std::vector<std::string> model, recipes, worlds, quiet;
  std::string sensor;
  model::EngineKind engine = model::EngineKind::fast;
  std::optional<unsigned> runs;
  std::uint64_t seed = 1;
  ExecutorArguments executor;
  bool quick = false, force = false, verbose = false, no_figures = false, dry_run = false;
};

std::vector<stress::StressSeries> series_of(const StressArguments& args) {
  std::optional<recipes::SensorNoise> sensor;
  if (!args.sensor.empty()) sensor = recipes::read_sensor_noise(args.sensor);
  std::vector<stress::StressSeries> series;
  for (const std::string& text : args.recipes) series.push_back(stress::series_in(text, args.seed, sensor));
  if (args.recipes.empty()) series = stress::all_series(args.seed, sensor);
  for (const std::string& text : args.worlds) {
    if (text != "all") {
      series.push_back(stress::world_series_in(text));
      continue;
    }
    for (const stress::SimulatedWorld& world : stress::world_list())
      series.push_back(stress::world_series_in(std::string(world.name)));
  }
  for (std::size_t i = 0; i < series.size(); ++i) {
    if (args.quick) series[i] = stress::with_few_severities(series[i]);
    const auto has_name = [&](const stress::StressSeries& other) { return other.name == series[i].name; };
    if (std::any_of(series.begin(), series.begin() + static_cast<std::ptrdiff_t>(i), has_name))
      throw Error(fmt::format("{}: two recipes have this name; expected each once", series[i].name));
  }
  return series;
}

/// The named models; else the one that commands without --model take, with a dataset one of it.
std::vector<fs::path> models_of(const StressArguments& args, const std::optional<fs::path>& dataset) {
  std::vector<fs::path> models;
  for (const std::string& model : args.model) {
    EvalArguments named;
    named.models = args.models;
    named.model = model;
    models.push_back(bundle_named(named).folder);
  }
  if (!models.empty()) return models;
  ChosenModel chosen;
  if (dataset) {
    const std::string hash = windows::Dataset(*dataset).manifest_hash();
    auto of_dataset = model_without_name(args.models, &hash);
    if (!of_dataset) {
      throw Error(fmt::format("{}: no model of {}; expected one, run 'tactile train' first, or name one by --model", args.models,
                              dataset->string()));
    }
    chosen = *std::move(of_dataset);
  } else {
    chosen = chosen_model("", args.models);
  }
  log_choice("stressing", chosen);
  return {chosen.bundle.folder};
}

stress::StressOptions options_of(const StressArguments& args, const CommonArguments& common) {
  stress::StressOptions options;
  if (args.quiet.empty() || fs::exists(dataset_file(args.data))) options.dataset = dataset_file(args.data);
  options.out = args.out;
  options.models = models_of(args, options.dataset);
  options.series = series_of(args);
  for (const std::string& file : args.quiet) options.quiet.emplace_back(file);
  options.runs = args.runs;
  options.judging.threads = common.threads;
  options.engine = args.engine;
  options.seed = args.seed;
  options.force = args.force;
  options.program = fs::read_symlink("/proc/self/exe");
  options.slurm = slurm_of(args.executor);
  return options;
}

/// A name for each model that fits into a table.
std::string letter_of(std::size_t model) { return std::string(1, static_cast<char>('A' + model % 26)); }

std::string holds_table(const results::Stress& stress) {
  std::vector<std::string> head{"recipe", "last severity"};
  for (std::size_t i = 0; i < stress.models.size(); ++i) {
    const std::string of = stress.models.size() > 1 ? letter_of(i) + " " : "";
    for (const char* column : {"holds", "accuracy [%]", "in 50 ms [%]", "alarms/min"}) head.push_back(of + column);
  }
  std::vector<std::vector<std::string>> rows;
  const auto add_row = [&](const std::string& name, const std::string& severity, auto point_of, auto holds_of) {
    std::vector<std::string> row{name, severity};
    for (const results::StressedModel& model : stress.models) {
      const results::StressPoint& point = point_of(model);
      row.push_back(holds_of(model));
      row.push_back(results::value_text(point.accuracy, 100, 1));
      row.push_back(results::value_text(point.whole.within_50_ms, 100, 1));
      row.push_back(results::value_text(point.whole.alarms_per_min, 1, 1));
    }
    rows.push_back(std::move(row));
  };
  for (const bool quiet : {false, true}) {
    const auto of = [quiet](const results::StressedModel& model) -> const std::vector<results::StressCurve>& {
      return quiet ? model.quiet : model.curves;
    };
    for (std::size_t i = 0; i < of(stress.models.front()).size(); ++i) {
      const results::StressCurve& first = of(stress.models.front())[i];
      const bool begins = i == 0 || first.is_world != of(stress.models.front())[i - 1].is_world;
      if (begins) {
        add_row(
            quiet            ? "quiet, unchanged"
            : first.is_world ? "unchanged, by truth"
                             : "unchanged",
            "0", [&](const auto& model) -> const results::StressPoint& { return of(model)[i].points.front(); },
            [](const auto&) { return std::string(); });
      }
      add_row((quiet ? "quiet, " : "") + first.name, fmt::format("{:g} {}", first.points.back().severity, first.unit),
              [&](const auto& model) -> const results::StressPoint& { return of(model)[i].points.back(); },
              [&](const auto& model) { return quiet ? std::string() : results::words_of(of(model)[i]); });
    }
  }
  return text_table(head, rows);
}

std::string text_of(const stress::StressSummary& summary) {
  const results::Stress& stress = summary.stress;
  std::string text = stress.title + "\n\n" + wrapped(stress.judged_by) + "\n\n";
  for (std::size_t i = 0; i < stress.models.size(); ++i) {
    const results::StressedModel& model = stress.models[i];
    text += fmt::format("{}{}: {}, {} runs\n", stress.models.size() > 1 ? letter_of(i) + ": " : "", model.name,
                        counted(model.trainings.size(), "training"), model.runs.size());
  }
  text += "\n" +
          wrapped(fmt::format("Holds: the severity up to which the accuracy is at most {:g} points below that of the "
                              "unchanged runs. Figures are those at the last severity; all are in stress.csv.",
                              100 * stress.most_lost)) +
          "\n\n" + holds_table(stress);
  text +=
      fmt::format("\n{} steps done, {} kept. Written to {} and stress.csv\n", summary.done, summary.kept, summary.file.string());
  return text;
}

/// Where a curve ends, compared with its start: the loss of accuracy, or of quiet recordings the further alarms.
double harm_of(const results::StressCurve& curve, bool quiet) {
  const results::StressPoint &clean = curve.points.front(), &worst = curve.points.back();
  const double harm =
      quiet ? worst.whole.alarms_per_min.value - clean.whole.alarms_per_min.value : clean.accuracy.value - worst.accuracy.value;
  return std::isfinite(harm) ? harm : -std::numeric_limits<double>::infinity();
}

/// The first model's recipes that harm it most, the worst first: at most 13 lines.
std::string short_text(const stress::StressSummary& summary) {
  constexpr std::size_t most_rows = 7;
  const results::Stress& stress = summary.stress;
  const results::StressedModel& model = stress.models.front();
  const bool quiet = model.curves.empty();
  std::vector<results::StressCurve> curves = quiet ? model.quiet : model.curves;
  std::stable_sort(curves.begin(), curves.end(),
                   [quiet](const auto& a, const auto& b) { return harm_of(a, quiet) > harm_of(b, quiet); });
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < std::min(most_rows, curves.size()); ++i) {
    const results::StressPoint &clean = curves[i].points.front(), &worst = curves[i].points.back();
    const auto change = [](double from, double to, double factor) {
      return fmt::format("{} to {}", std::isfinite(from) ? fmt::format("{:.1f}", factor * from) : "-",
                         std::isfinite(to) ? fmt::format("{:.1f}", factor * to) : "-");
    };
    rows.push_back({curves[i].name, quiet ? "" : results::words_of(curves[i]),
                    change(clean.accuracy.value, worst.accuracy.value, 100),
                    change(clean.whole.alarms_per_min.value, worst.whole.alarms_per_min.value, 1)});
  }
  std::string text = wrapped(stress.title) + "\n\n" + text_table({"recipe", "holds", "accuracy [%]", "alarms/min"}, rows);
  if (const std::size_t more = curves.size() - rows.size(); more > 0) text += fmt::format("and {} less harmful\n", more);
  const std::size_t others = stress.models.size() - 1;
  return text + fmt::format("\nOf {}{}: --verbose prints all. {} steps done, {} kept. Written to {}\n", model.name,
                            others > 0 ? fmt::format(", and {} more", counted(others, "model")) : "", summary.done, summary.kept,
                            summary.file.string());
}

std::vector<std::string> draw_figures(const results::Stress& stress, const fs::path& out) {
  std::vector<std::pair<std::string, pictures::Plot>> plots;
  if (!stress.models.front().curves.empty()) {
    plots.emplace_back("stress-accuracy", report::stress_plot(stress, report::StressMeasure::accuracy));
    plots.emplace_back("stress-detected", report::stress_plot(stress, report::StressMeasure::within_50_ms));
    plots.emplace_back("stress-false-alarms", report::stress_plot(stress, report::StressMeasure::false_alarms));
  }
  if (!stress.models.front().quiet.empty())
    plots.emplace_back("stress-quiet", report::stress_plot(stress, report::StressMeasure::false_alarms, true));
  return draw_plots(plots, out / "figures");
}

/// The events until 50 ms after `t`, from a little more than a second before.
std::vector<events::Event> events_around(events::RecordingReader& recording, CameraTime t) {
  const CameraTime begin = before(t, microseconds{1'100'000}), end = after(t, microseconds{50'000});
  std::vector<events::Event> around;
  events::for_all_events(recording, events::event_stream(recording).id, [&](std::span<const events::Event> some) {
    std::copy_if(some.begin(), some.end(), std::back_inserter(around),
                 [&](const events::Event& event) { return begin <= event.t && event.t < end; });
  });
  return around;
}

/// A picture of each recipe at its middle severity, on the first run, 40 ms after the onset of its first interval; without runs,
/// in the middle of the first quiet recording.
void draw_recipes(const stress::StressOptions& options, const results::Stress& stress) {
  fs::path file;
  std::optional<CameraTime> t;
  if (!stress.models.front().runs.empty()) {
    const windows::Dataset dataset(*options.dataset);
    for (const windows::DatasetInterval& interval : dataset.intervals()) {
      if (t || name_of(dataset.runs()[interval.run_index]) != stress.models.front().runs.front()) continue;
      file = dataset.run_folder(interval.run_index) / "events.aedat4";
      t = after(interval.interval.start, microseconds{40'000});
    }
  } else {
    file = options.quiet.front();
  }
  if (file.empty()) return;
  events::RecordingReader recording(file);
  if (!t && !recording.packets().empty()) t = recording.packets()[recording.packets().size() / 2].first;
  const std::optional<events::SensorSize> size = events::event_stream(recording).size;
  if (!t || !size) return;
  const std::vector<events::Event> around = events_around(recording, *t);
  for (const stress::StressSeries& series : options.series) {
    stop_if_interrupted();
    if (series.recipes.size() != 1) continue;
    const double middle = series.severities[series.severities.size() / 2];
    pictures::write_png(options.out / "recipes" / (series.name + ".png"),
                        pictures::recipe_sheet(around, *size, recipes_at(series, middle).front(), *t));
  }
}

void run(const StressArguments& args, const CommonArguments& common) {
  std::optional<windows::DatasetSummary> made;
  if (args.quiet.empty() && !args.dry_run) made = make_missing_dataset(args.data, false, common);
  stress::StressOptions options = options_of(args, common);
  nlohmann::json models = nlohmann::json::array();
  for (const fs::path& model : options.models) models.push_back(model.string());
  const nlohmann::json decided = {{"model", models.size() == 1 ? models.front() : models}};
  nlohmann::json settings = common.settings;
  settings.merge_patch(decided);
  const fs::path of_tasks = options.out / "slurm" / ("settings-" + sha256_of(settings.dump()).substr(0, 8) + ".json");
  // Written when the first task is due, so by the command that has the folder, and never changed: tasks of other options have a
  // file of their own.
  options.task = [&settings, &of_tasks](const std::string& step, const fs::path& model) {
    if (!fs::exists(of_tasks)) write_json(of_tasks, settings);
    return std::vector<std::string>{"stress-step", step,           "--config",  of_tasks.string(),
                                    "--model",     model.string(), "--threads", "1"};
  };
  if (args.dry_run) return print_estimate(stress::estimate_stress(options), options.out, options.slurm.has_value(), common);
  const stress::StressSummary summary = resumable([&] {
    return stress::run_stress(
        options, [&] { return progress_line(common); }, log_step);
  });
  write_settings(common, options.out / "settings.json", decided);
  nlohmann::json result = summary.stress;
  result["file"] = summary.file.string();
  result["steps_done"] = summary.done;
  result["steps_kept"] = summary.kept;
  result["figures"] = nlohmann::json::array();
  std::string text = args.verbose ? text_of(summary) : short_text(summary);
  try {
    if (!args.no_figures) {
      result["figures"] = draw_figures(summary.stress, args.out);
      draw_recipes(options, summary.stress);
      text += fmt::format("Figures: {}; a picture of each recipe: {}\n", (fs::path(args.out) / "figures").string(),
                          (fs::path(args.out) / "recipes").string());
    }
  } catch (const Error&) {
    print_result(common, result, text);  // the measurements are complete
    throw;
  }
  print_result(common, result, text);
  if (made) end_with(made->errors);
}

std::vector<std::string> world_names() {
  std::vector<std::string> names{"all"};
  for (const stress::SimulatedWorld& world : stress::world_list()) names.emplace_back(world.name);
  return names;
}

void add_options(Command& command, const std::shared_ptr<StressArguments>& args) {
  command
      .add_option("data", args->data, "Data folder with dataset.h5; a missing dataset is made, unless --quiet-recording is given")
      .show_default();
  command
      .add_option("--recipe", args->recipes,
                  "A recipe of 'convert --stress' with severities: noise, noise:50,200, vibration:1,3:hz=120; or a JSON file of "
                  "recipes. May be repeated. Default: all, at their usual severities")
      .repeatable()
      .type_name("NAME[:SEVERITY,...]|FILE.json")
      .suggest(recipe_names());
  command
      .add_option("--world", args->worlds,
                  "Simulate the runs again in another world: camera-noisy, light-dim, light-flicker, motion-fast, motion-slow, "
                  "motion-ringing or all, with severities as --recipe. May be repeated")
      .repeatable()
      .type_name("NAME[:SEVERITY,...]")
      .suggest(world_names());
  command.add_option("--quiet-recording", args->quiet, "Recordings without a touch: every alarm is false. May be repeated")
      .repeatable()
      .type_name("FILE");
  command
      .add_option("--model", args->model,
                  "Model: a folder, or a name in --models. May be repeated: models that differ only in seed and training run "
                  "are trainings of one. Default: the pinned one, else the last one that 'train' made here")
      .repeatable();
  command.add_option("--models", args->models, "Folder of models").type_name("DIR").show_default();
  command.add_option("--runs", args->runs, "Use at most this many runs of each object").check(in_range(1U, 99U)).type_name("N");
  command.add_flag("--quick", args->quick, "Only three severities of each recipe: the first, the middle and the last");
  command.add_option("--sensor", args->sensor, "sensor.json of 'characterise': the noise for the recipes noise and hot-pixels")
      .check(is_existing_file())
      .type_name("FILE.json");
  command.add_option("--seed", args->seed, "Seed of the recipes").check(is_seed()).show_default();
  add_engine_option(command, args->engine);
  add_executor_options(command, args->executor);
  command.add_flag("--dry-run", args->dry_run, "Only print the number of judgements, their hours and their size");
  command.add_flag("--verbose", args->verbose, "Print every recipe, with all models and figures at its last severity");
  command.add_flag("--no-figures", args->no_figures, "Do not draw figures");
  command.add_flag("--force", args->force, "Do every step again, also those that are done");
  command.add_option("--out", args->out, "Output folder").type_name("DIR").show_default();
}

}  // namespace

void add_stress_command(CLI::App& app) {
  auto args = std::make_shared<StressArguments>();
  Command command = add_command(app, "stress", "Worsen recordings more and more, and judge models on them",
                                [args](const CommonArguments& common) { run(*args, common); });
  add_options(command, args);
}

void add_stress_step_command(CLI::App& app) {
  auto args = std::make_shared<StressArguments>();
  auto step = std::make_shared<std::string>();
  Command command = add_command(app, "stress-step", "Do one step of a stress that runs on a cluster",
                                [args, step](const CommonArguments& common) {
                                  stress::do_step(stress::plan_stress(options_of(*args, common)), *step, progress_line(common));
                                });
  command.add_option("step", *step, "Name of the step").required();
  add_options(command, args);
  command.hide();  // only 'stress --executor slurm' starts it
}

}  // namespace tactile::cli
