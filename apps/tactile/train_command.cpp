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
#include "rendering_arguments.hpp"
#include "tactile/core/error.hpp"
#include "tactile/heatmaps/render_samples.hpp"
#include "tactile/model/train_model.hpp"
#include "text_table.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;

struct TrainArguments {
  std::string data = "data";
  double history_ms = 40;
  RenderingArguments rendering;
  std::string split = "single-run", train_run = "01";
  std::vector<std::string> held_out = default_held_out();
  TrainingOptions training;
  std::string models = "models", name;
  bool force = false;
};

ModelSettings settings_of(const TrainArguments& args) {
  ModelSettings settings;
  settings.rendering = heatmap_options(args.history_ms, args.rendering);
  settings.split = {.kind = split_named(args.split), .train_run = args.train_run, .held_out = args.held_out};
  settings.training = args.training;
  return settings;
}

std::string text_of(const ModelBundle& bundle, const ModelDescription& model, const std::string& outcome,
                    const TrainingSummary& summary) {
  std::vector<std::vector<std::string>> rows;
  for (const EpochResult& epoch : summary.history) {
    rows.push_back({std::to_string(epoch.epoch), fmt::format("{:.4f}", epoch.loss), fmt::format("{:.2f}", 100 * epoch.accuracy),
                    fmt::format("{:.0f}", epoch.images_per_s), fmt::format("{:.1f}", epoch.seconds)});
  }
  std::string text = rows.empty() ? "" : text_table({"epoch", "loss", "accuracy [%]", "images/s", "seconds"}, rows) + "\n";
  text += wrapped(fmt::format("{}: {}, learned from {} samples of {} {} runs; {} runs are left to test it on, by 'tactile eval'",
                              bundle.folder.string(), outcome, model.samples, model.train_runs.size(),
                              model.simulated ? "simulated" : "real", model.test_runs.size())) +
          "\n";
  return text;
}

nlohmann::json json_of(const ModelBundle& bundle, const ModelDescription& model, const std::string& outcome, bool dataset_made,
                       const TrainingSummary& summary) {
  nlohmann::json history = nlohmann::json::array();
  for (const EpochResult& epoch : summary.history) {
    history.push_back({{"epoch", epoch.epoch},
                       {"loss", epoch.loss},
                       {"accuracy", epoch.accuracy},
                       {"images_per_s", epoch.images_per_s},
                       {"seconds", epoch.seconds}});
  }
  return {{"model", bundle.folder.string()},
          {"name", bundle.name()},
          {"outcome", outcome},
          {"dataset", model.dataset},
          {"dataset_made", dataset_made},
          {"simulated", model.simulated},
          {"samples", model.samples},
          {"train_runs", model.train_runs},
          {"test_runs", model.test_runs},
          {"settings", model.settings},
          {"threads", model.threads},
          {"weights_sha256", model.weights_sha256},
          {"seconds", summary.seconds},
          {"history", history}};
}

void train(const TrainArguments& args, const CommonArguments& common) {
  let_openmp_threads_sleep();
  const ModelSettings settings = settings_of(args);
  const bool dataset_made = make_missing_dataset(args.data, common);
  const Dataset dataset(dataset_file(args.data));
  const ModelBundle bundle{fs::path(args.models) / (args.name.empty() ? default_name(settings) : args.name)};
  const BundleState state = state_of(bundle, dataset, settings);
  if (state == BundleState::unchanged && !args.force) {
    const ModelDescription model = read_description(bundle);
    print_result(common, json_of(bundle, model, "unchanged", dataset_made, {}), text_of(bundle, model, "unchanged", {}));
    return;
  }
  if (state == BundleState::changed && !args.force) {
    throw Error(fmt::format(
        "{}: is there, with other settings, of another dataset or damaged; expected a new --name, or --force to replace it",
        bundle.folder.string()));
  }
  check_renders(dataset, settings.rendering);
  spdlog::info("training {}: {}", bundle.name(), training_estimate(dataset, settings, {}, common.threads));
  const TrainingSummary summary = train_model(dataset, settings, bundle, common.threads, progress_line(common));
  const std::string outcome = state == BundleState::missing ? "trained" : "replaced";
  const ModelDescription model = read_description(bundle);
  print_result(common, json_of(bundle, model, outcome, dataset_made, summary), text_of(bundle, model, outcome, summary));
}

std::string check_bundle_name(const std::string& name) {
  const bool plain = !name.empty() && name.front() != '.' && name.find('/') == std::string::npos;
  return plain ? "" : fmt::format("'{}' is no model's name; expected that of a folder: no '/', and no '.' in front", name);
}

}  // namespace

void add_train_command(CLI::App& app) {
  auto args = std::make_shared<TrainArguments>();
  CLI::App* command = add_command(app, "train", "Train LeNet on the heatmaps of one run per object",
                                  [args](const CommonArguments& common) { train(*args, common); });
  command->add_option("data", args->data, "Folder whose dataset.h5 is meant, or a dataset; a missing one is made")
      ->capture_default_str();
  command->add_option("--th", args->history_ms, "History t_h [ms], a whole number of ticks")
      ->check(in_range(0.001, 1e5))
      ->capture_default_str();
  command->add_option("--split", args->split, "single-run: one run of every object; unseen: one run of those not held out")
      ->check(one_of({"single-run", "unseen"}))
      ->capture_default_str();
  command->add_option("--train-run", args->train_run, "Run to train on, of each object")->capture_default_str();
  command->add_option("--held-out", args->held_out, "Objects that --split unseen does not train on, a list with commas")
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--seed", args->training.seed, "Of the first weights and the order of samples")
      ->check(is_seed())
      ->capture_default_str();
  command->add_option("--epochs", args->training.epochs, "Passes over the training samples")
      ->check(in_range(1U, 100'000U))
      ->capture_default_str();
  command->add_option("--batch", args->training.batch, "Samples to a step")->check(in_range(1U, 65'536U))->capture_default_str();
  command->add_option("--lr", args->training.learning_rate, "Learning rate of Adam")
      ->check(in_range(1e-12, 10.0))
      ->capture_default_str();
  add_rendering_options(*command, args->rendering);
  command->add_option("--models", args->models, "Folder of models")->capture_default_str();
  command->add_option("--name", args->name, "Folder of this model below it; told from history, split, run and seed if not given")
      ->check(CLI::Validator(check_bundle_name, ""));
  command->add_flag("--force", args->force, "Train again and replace what is there");
}

}  // namespace tactile
