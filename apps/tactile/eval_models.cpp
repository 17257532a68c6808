#include "eval_models.hpp"

#include <fmt/core.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <system_error>

#include "chosen_model.hpp"
#include "model_arguments.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/experiments/run_division.hpp"
#include "tactile/model/bundle/bundle_names.hpp"
#include "tactile/model/training/dataset_bundle.hpp"
#include "tactile/model/training/train_model.hpp"

namespace tactile::cli {

namespace fs = std::filesystem;

std::string train_command(const EvalArguments& args, const model::ModelSettings& settings) {
  std::string command = "tactile train";
  if (args.data != "data") command += " " + shell_word(args.data);
  for (const OptionValue& option : model::train_options(settings)) command += fmt::format(" {} {}", option.name, option.text);
  // With other objects held out, a training starts from another model, which only the user knows.
  if (settings.from)
    command += settings.split.kind == windows::SplitKind::unseen ? " --from MODEL" : " --from " + settings.from->name;
  if (args.models != "models") command += " --models " + shell_word(args.models);
  return command;
}

model::ModelBundle bundle_named(const EvalArguments& args) {
  model::ModelBundle bundle = named_model(args.model, args.models);
  if (fs::exists(bundle.description()) || model::is_own_network(bundle.folder)) return bundle;
  if (model::CheckpointFolder::holds_state(model::CheckpointFolder::beside(bundle.folder))) {
    throw Error(
        fmt::format("{}: its training was interrupted; expected a finished model: 'tactile train' with the same options and "
                    "--resume resumes it",
                    bundle.folder.string()));
  }
  const std::vector<std::string> names = model::bundle_names(args.models);
  throw Error(
      fmt::format("{}: no model; expected a folder with model.json{}", bundle.folder.string(),
                  names.empty() ? ", as 'tactile train' creates it" : fmt::format(", such as {}", fmt::join(names, ", "))));
}

model::ModelSettings with_split(model::ModelSettings settings, windows::SplitKind kind,
                                const std::vector<std::string>& held_out) {
  settings.split.kind = kind;
  if (kind == windows::SplitKind::unseen) settings.split.held_out = held_out;
  return settings;
}

model::ModelSettings with_training(model::ModelSettings settings, const windows::Dataset& dataset, unsigned training) {
  settings.split.train_run = experiments::rotated_run(dataset, settings.split.train_run, training);
  settings.training.seed += training;
  return settings;
}

model::ModelBundle partner_of(const EvalArguments& args, const CommonArguments& common, const windows::Dataset& dataset,
                              const model::ModelSettings& settings, bool exactly) {
  // If a model started from another model, its partner does, too, but from a different one that never saw the held-out objects.
  const auto like_ours = [&](model::ModelSettings model) {
    if (model.from && settings.from) model.from = settings.from;
    return model;
  };
  const auto same = [&](const model::ModelDescription& model) {
    return model.manifest_hash == dataset.manifest_hash() && same_settings(like_ours(model.settings), settings);
  };
  const auto same_but_held_out = [&](const model::ModelDescription& model) {
    model::ModelSettings alike = like_ours(model.settings);
    alike.split.held_out = settings.split.held_out;
    return model.manifest_hash == dataset.manifest_hash() && same_settings(alike, settings);
  };
  if (const auto found = model::newest_bundle(args.models, same)) return *found;
  if (args.held_out.empty() && !exactly) {
    if (const auto found = model::newest_bundle(args.models, same_but_held_out)) return *found;
  }
  model::ModelBundle bundle = model::bundle_for(args.models, dataset, settings);
  const std::string command = train_command(args, settings);
  if (settings.from) {
    const bool holds_out = settings.split.kind == windows::SplitKind::unseen;
    throw Error(
        fmt::format("{}: no model of these settings that starts from another{}. It is not trained automatically; expected it, "
                    "run '{}' first{}",
                    args.models, holds_out ? " and never saw the objects held out" : "", command,
                    holds_out ? ", with a MODEL that never saw them either" : ""));
  }
  if (args.no_train)
    throw Error(fmt::format("{}: missing; expected this model, run '{}' first", bundle.folder.string(), command));
  if (fs::exists(bundle.folder)) {
    throw Error(fmt::format("{}: exists, but has other settings or is damaged; expected a model of {}, run '{} --force' first",
                            bundle.folder.string(), dataset.file().string(), command));
  }
  spdlog::info("{} is missing: it is trained first, as with '{}': {}", bundle.folder.string(), command,
               training_size(dataset, settings));
  TrainingEstimate estimate(settings.training.epochs, progress_line(common));
  model::train_model(dataset, settings, bundle,
                     {.threads = common.threads,
                      .resume = true,
                      .begins = [&estimate](unsigned epoch, double done) { estimate.begin(epoch, done); }},
                     [&estimate](const Progress& progress) { estimate.see(progress); });
  return bundle;
}

}  // namespace tactile::cli
