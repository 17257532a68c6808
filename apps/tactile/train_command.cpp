#include <fmt/core.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "chosen_model.hpp"
#include "command.hpp"
#include "commands.hpp"
#include "field_options.hpp"
#include "model_arguments.hpp"
#include "option_checks.hpp"
#include "quantity_text.hpp"
#include "rendering_arguments.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/heatmaps/render_samples.hpp"
#include "tactile/model/bundle/pinned_bundle.hpp"
#include "tactile/model/training/calibrate_model.hpp"
#include "tactile/model/training/dataset_bundle.hpp"
#include "tactile/model/training/train_model.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

struct TrainArguments {
  std::string data = "data";
  model::ModelSettings settings;
  std::string mask;
  std::vector<std::string> held_out;  ///< empty: those of the paper's five objects that the dataset has
  std::optional<double> validation_share;
  std::string models = "models", name, from, tensorboard;
  std::vector<std::string> calibrate;  ///< ids of runs to fit a temperature on; empty: none is fitted
  bool force = false, resume = false, strict = false, verbose = false;
  double save_every_s = 30;
};

/// @throws Error  that names an option which has no meaning for the kind of model
void check_options_of_kind(const model::ModelSettings& settings) {
  if (const std::vector<std::string> idle = idle_options(settings); !idle.empty()) {
    throw Error(fmt::format("{}: a model of kind {} has none; expected --kind {} with it", idle.front(), name_of(settings.kind),
                            settings.kind == model::ModelKind::lenet ? "stream" : "lenet"));
  }
}

model::ModelSettings settings_of(const TrainArguments& args) {
  model::ModelSettings settings = args.settings;
  settings.rendering = with_mask(settings.rendering, args.mask);
  settings.split.held_out = args.held_out;
  settings.training.validation_share =
      args.validation_share.value_or(settings.training.early_stop > 0 ? model::usual_validation_share : 0.0);
  if (!args.from.empty()) settings.from = {.name = args.from, .weights_sha256 = ""};  // `train` reads the model
  check_options_of_kind(settings);
  // A stream reads each tick once, and remembers.
  if (settings.kind == model::ModelKind::stream) settings.rendering.history = settings.rendering.tick;
  check(settings.training);
  if (!args.held_out.empty() && settings.split.kind != windows::SplitKind::unseen)
    throw Error("--held-out: a split of single-run holds no object out; expected --split unseen with it");
  return settings;
}

/// The command that evaluates the model.
std::string eval_command(const model::ModelBundle& bundle, const TrainArguments& args) {
  return fmt::format("tactile eval{}{} --model {}", args.data == "data" ? "" : " ",
                     args.data == "data" ? "" : shell_word(args.data),
                     shell_word(args.models == "models" ? bundle.name() : bundle.folder.string()));
}

std::string text_of(const model::ModelBundle& bundle, const TrainArguments& args, const model::ModelDescription& model,
                    const std::string& outcome, const model::TrainingSummary& summary) {
  const bool judged = summary.validation_samples > 0;
  constexpr std::size_t most_rows = 10;
  const std::size_t epochs = summary.history.size();
  const std::size_t step = args.verbose || epochs <= most_rows ? 1 : (epochs + most_rows - 3) / (most_rows - 2);
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < epochs; ++i) {
    const model::EpochResult& epoch = summary.history[i];
    if (i % step != 0 && i + 1 != epochs && epoch.epoch != summary.best_epoch) continue;
    std::vector<std::string> row{std::to_string(epoch.epoch), fmt::format("{:.4f}", epoch.loss),
                                 fmt::format("{:.2f}", 100 * epoch.accuracy)};
    if (judged) {
      row.push_back(fmt::format("{:.4f}", epoch.validation_loss.value_or(NAN)));
      row.push_back(fmt::format("{:.2f}", 100 * epoch.validation_accuracy.value_or(NAN)));
    }
    row.push_back(fmt::format("{:.0f}", epoch.images_per_s));
    row.push_back(fmt::format("{:.1f}", epoch.seconds));
    rows.push_back(row);
  }
  std::vector<std::string> titles{"epoch", "loss", "accuracy [%]"};
  if (judged) titles.insert(titles.end(), {"validation loss", "validation accuracy [%]"});
  titles.insert(titles.end(), {model::reads_heatmaps(model.settings.kind) ? "images/s" : "samples/s", "seconds"});
  if (model.settings.kind == model::ModelKind::stream) titles.front() = "100 steps";
  std::string text = rows.empty() ? "" : text_table(titles, rows) + "\n";
  if (step > 1)
    text += wrapped(fmt::format("{} of {} epochs; --verbose prints all, as history.csv has them.", rows.size(), epochs)) + "\n\n";
  if (summary.stopped_early) {
    text += wrapped(fmt::format("Stopped after epoch {}: the validation loss was smallest in epoch {}, whose weights are used.",
                                summary.history.back().epoch, summary.best_epoch)) +
            "\n\n";
  }
  text +=
      wrapped(fmt::format(
          "{}: {}, with {} of {}; {} left to test it, by '{}'", bundle.folder.string(), outcome, counted(model.samples, "sample"),
          counted(model.train_runs.size(), model.simulated ? "simulated run" : "real run"),
          counted(model.test_runs.size(), "run") + (model.test_runs.size() == 1 ? " is" : " are"), eval_command(bundle, args))) +
      "\n";
  return text;
}

nlohmann::json json_of(const model::ModelBundle& bundle, const model::ModelDescription& model, const std::string& outcome,
                       bool dataset_made, const std::vector<std::string>& warnings, const model::TrainingSummary& summary,
                       const model::Temperature& temperature) {
  return {{"model", bundle.folder.string()},
          {"name", bundle.name()},
          {"outcome", outcome},
          {"dataset", model.dataset},
          {"dataset_made", dataset_made},
          {"simulated", model.simulated},
          {"samples", model.samples},
          {"train_runs", model.train_runs},
          {"test_runs", model.test_runs},
          {"warnings", warnings},
          {"settings", model.settings},
          {"threads", model.threads},
          {"weights_sha256", model.weights_sha256},
          {"epoch", model.epoch},
          {"best_epoch", model.best_epoch},
          {"validation_samples", summary.validation_samples},
          {"stopped_early", summary.stopped_early},
          {"seconds", summary.seconds},
          {"temperature", temperature},
          {"history", summary.history}};
}

/// Whether to resume an interrupted training. @throws Error  if there is one, and neither --resume nor --force is given
bool resumes_training(const TrainArguments& args, const model::ModelBundle& bundle) {
  const fs::path folder = model::CheckpointFolder::beside(bundle.folder);
  if (!model::CheckpointFolder::holds_state(folder)) {
    if (args.resume) spdlog::info("{}: there is no interrupted training; a new one begins", bundle.folder.string());
    return false;
  }
  if (args.resume) return true;
  if (args.force) return false;
  throw Error(
      fmt::format("{}: an interrupted training; expected --resume to resume it, or --force to start again", folder.string()));
}

/// Why the existing bundle differs from the requested one: "with other settings (training.epochs: 10 before, 6 now)".
std::string difference_of(const model::ModelBundle& bundle, const windows::Dataset& dataset,
                          const model::ModelSettings& settings) {
  try {
    const model::ModelDescription there = model::read_description(bundle);
    if (const std::string other = differences(there.settings, settings); !other.empty())
      return "with other settings (" + other + ")";
    if (there.manifest_hash != dataset.manifest_hash()) return "of another dataset";
  } catch (const Error&) {
    // It cannot be read: it is damaged.
  }
  return "damaged";
}

/// A learning rate that is too large does not always lead to NaN. Units that are 0 for every heatmap learn nothing, and the loss
/// stays that of three equally likely classes, ln 3.
void warn_of_nothing_learned(const model::ModelBundle& bundle, const model::ModelSettings& settings,
                             const model::TrainingSummary& summary) {
  const double of_a_guess = std::log(static_cast<double>(touch_count));
  if (summary.history.empty() || summary.history.back().loss < of_a_guess) return;
  spdlog::warn(
      "{}: has learned nothing: its loss of {:.4f} is not below that of a guess, {:.4f}; try a smaller --lr than {}, or more "
      "than {}",
      bundle.folder.string(), summary.history.back().loss, of_a_guess, settings.training.learning_rate,
      counted(settings.training.epochs, "epoch"));
}

/// The bundle's temperature: fitted now with --calibrate, else the one it has.
model::Temperature calibrated(const TrainArguments& args, const CommonArguments& common, const windows::Dataset& dataset,
                              const model::ModelBundle& bundle, const model::ModelDescription& model) {
  if (args.calibrate.empty()) return model::read_temperature(bundle, model);
  return model::calibrate_model(dataset, bundle, args.calibrate, common.threads);
}

std::string text_of(const model::Temperature& temperature) {
  if (temperature.fitted_on.empty()) return {};
  return wrapped(fmt::format("Temperature {:.3f}, fitted on {} of {}: cross-entropy {:.4f} instead of {:.4f} nats. Logits are "
                             "divided by it; verdicts stay the same. 'eval' does not use these runs.",
                             temperature.value, counted(temperature.samples, "sample"),
                             counted(temperature.fitted_on.size(), "run"), temperature.loss_after, temperature.loss_before)) +
         "\n";
}

/// Makes it the model that other commands take. In a folder that cannot be written they take the newest.
void note_last(const model::ModelBundle& bundle) {
  try {
    model::note_last_bundle(bundle);
  } catch (const Error& e) {
    spdlog::warn("{}; commands without --model may take another model", e.what());
  }
}

/// Trains the bundle, or resumes its training, and logs how that goes.
model::TrainingSummary train_bundle(const TrainArguments& args, const CommonArguments& common, const windows::Dataset& dataset,
                                    const model::ModelSettings& settings, const model::ModelBundle& bundle, IfThere if_there) {
  heatmaps::check_renders(dataset, settings.rendering);
  const bool resumes = resumes_training(args, bundle);
  // A stream's steps are counted in hundreds.
  const unsigned epochs =
      settings.kind == model::ModelKind::stream ? (settings.stream.steps + 99) / 100 : settings.training.epochs;
  TrainingEstimate estimate(epochs, progress_line(common));
  const auto report_begin = [&](unsigned epoch, double done) {
    estimate.begin(epoch, done);
    if (resumes) {
      spdlog::info("resuming {} in epoch {} of {}, {:.0f} % of it done", bundle.name(), epoch, epochs, 100 * done);
    } else {
      spdlog::info("training {}: {}", bundle.name(), training_size(dataset, settings));
    }
  };
  model::TrainingSummary summary;
  try {
    summary =
        model::train_model(dataset, settings, bundle,
                           {.threads = common.threads,
                            .resume = resumes,
                            .save_every = std::chrono::duration<double>(args.save_every_s),
                            .from = named_model(args.from, args.models).folder,
                            .if_there = if_there,
                            .command_settings = common.settings,
                            .tensorboard = args.tensorboard.empty() ? fs::path() : fs::path(args.tensorboard) / bundle.name(),
                            .begins = report_begin},
                           [&estimate](const Progress& progress) { estimate.see(progress); });
  } catch (const Interrupted&) {
    if (model::CheckpointFolder::holds_state(model::CheckpointFolder::beside(bundle.folder)))
      spdlog::warn("{}: interrupted; the same command with --resume resumes it", bundle.folder.string());
    throw;
  }
  const unsigned threads = model::read_description(bundle).threads;
  if (resumes && threads != common.threads && model::depends_on_threads(settings))
    spdlog::info("resumed with {}, as it began: with libtorch's layers, another number changes the weights' last digits",
                 counted(threads, "thread"));
  warn_of_nothing_learned(bundle, settings, summary);
  return summary;
}

void train(const TrainArguments& args, const CommonArguments& common) {
  model::ModelSettings settings = settings_of(args);
  const std::optional<windows::DatasetSummary> made = make_missing_dataset(args.data, args.strict, common);
  const windows::Dataset dataset(dataset_file(args.data));
  if (settings.split.kind == windows::SplitKind::unseen) settings.split.held_out = objects_to_hold_out(args.held_out, dataset);
  const std::vector<std::string> warnings = warn_of_splits(dataset, {&settings.split, 1}, args.strict);
  const model::ModelBundle from = named_model(args.from, args.models);
  if (!args.from.empty()) settings.from = model::starting_point(from, dataset, settings);
  const model::ModelBundle bundle = args.name.empty() ? model::bundle_for(args.models, dataset, settings)
                                                      : model::ModelBundle{fs::path(args.models) / args.name};
  if (args.name.empty() && bundle.name().starts_with(model::default_name(settings) + "-"))
    spdlog::info("{} learned from another state of {}, or from another dataset, and stays; this model is {}",
                 model::default_name(settings), dataset.file().string(), bundle.name());
  const model::BundleState state = model::state_of(bundle, dataset, settings);
  if (state == model::BundleState::changed && !args.force) {
    throw Error(fmt::format("{}: exists already, {}; expected a new --name, or --force to replace it", bundle.folder.string(),
                            difference_of(bundle, dataset, settings)));
  }
  const bool is_missing = state == model::BundleState::missing;
  std::string outcome = "unchanged";
  model::TrainingSummary summary;
  if (state != model::BundleState::unchanged || args.force) {
    summary = train_bundle(args, common, dataset, settings, bundle, is_missing ? IfThere::refuse : IfThere::replace);
    outcome = is_missing ? "trained" : "replaced";
  }
  const model::ModelDescription model = model::read_description(bundle);
  const model::Temperature temperature = calibrated(args, common, dataset, bundle, model);
  note_last(bundle);
  print_result(common, json_of(bundle, model, outcome, made.has_value(), warnings, summary, temperature),
               text_of(bundle, args, model, outcome, summary) + text_of(temperature));
  if (made) end_with(made->errors);
}

std::string check_bundle_name(const std::string& name) {
  const bool plain = !name.empty() && name.front() != '.' && name.find('/') == std::string::npos;
  return plain ? "" : fmt::format("'{}' is not a name for a model; expected one without '/' and without '.' at the front", name);
}

void add_split_options(Command& command, TrainArguments& args) {
  command.add_option("data", args.data, "Data folder with dataset.h5, or a dataset file; a missing dataset is made")
      .show_default();
  add_field_options(command, args.settings.rendering);
  add_mask_option(command, args.mask);
  add_word(command, "--split", args.settings.split.kind, windows::split_names,
           "single-run: train on one run of every object; unseen: on one run of each object that is not held out");
  command
      .add_option("--train-run", args.settings.split.train_run,
                  "Run of each object to train on; the next one if it has no samples")
      .check(is_run())
      .type_name("NN")
      .show_default();
  command
      .add_option("--held-out", args.held_out,
                  "Objects held out by --split unseen, separated by commas; default: those of the paper's five that exist")
      .delimiter(',')
      .type_name("NAME,...");
  add_strict_option(command, args.strict);
}

void add_training_options(Command& command, TrainArguments& args) {
  add_word(command, "--kind", args.settings.kind, model::trained_kinds,
           "Kind of model: lenet, on heatmaps; stream, a recurrent network on the events of each tick, trained on whole runs");
  add_field_options(command, args.settings.stream);
  add_field_options(command, args.settings.training);
  add_field_options(command, args.settings.network);
}

void add_model_options(Command& command, TrainArguments& args) {
  command
      .add_option("--validation", args.validation_share,
                  "Share of training samples used for validation, the last ones of each class")
      .check(in_range(0.0, 0.5))
      .default_text("0, or 0.2 with --early-stop");
  command.add_option("--from", args.from, "Start from the weights of this model: a folder, or a name in --models")
      .type_name("MODEL");
  command
      .add_option(
          "--calibrate", args.calibrate,
          "Fit a temperature of the probabilities on these runs of each object, separated by commas; 'eval' leaves them out")
      .delimiter(',')
      .check(is_run())
      .type_name("NN,...");
  command.add_option("--models", args.models, "Folder of models").type_name("DIR").show_default();
  command
      .add_option("--name", args.name,
                  "Name of the model's folder; default: made of history, split and seed, such as th40-single-1")
      .check(Check{check_bundle_name, ""});
  command
      .add_option("--tensorboard", args.tensorboard,
                  "Write loss, accuracy and learning rate of each epoch for TensorBoard, in a folder of the model's name in DIR")
      .type_name("DIR");
  command.add_flag("--resume", args.resume, "Resume an interrupted training; the result is the same as without the interruption");
  command.add_flag("--verbose", args.verbose, "Print a line for each epoch");
  command.add_option("--save-every", args.save_every_s, "Time between two checkpoints, in addition to one per epoch [s]")
      .check(in_range(0.0, 1e6))
      .show_default();
  command.add_flag("--force", args.force, "Train again and replace the existing model");
}

}  // namespace

void add_train_command(CLI::App& app) {
  auto args = std::make_shared<TrainArguments>();
  Command command = add_command(app, "train", "Train a model on one run per object: LeNet on heatmaps, or a stream",
                                [args](const CommonArguments& common) { train(*args, common); });
  add_split_options(command, *args);
  add_training_options(command, *args);
  add_model_options(command, *args);
}

}  // namespace tactile::cli
