#include "tactile/experiments/training_step.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include "tactile/core/text_lines.hpp"
#include "tactile/experiments/milliseconds.hpp"
#include "tactile/model/training/checkpoint.hpp"
#include "tactile/model/training/dataset_bundle.hpp"
#include "tactile/model/training/train_model.hpp"

namespace tactile::experiments {

std::string command_of(const std::vector<std::string>& words) {
  std::string command = "tactile";
  for (const std::string& word : words) command += " " + shell_word(word);
  return command;
}

Step training_step(const windows::Dataset& dataset, const model::ModelSettings& settings, const model::ModelBundle& bundle,
                   const TrainingPlaces& places) {
  const heatmaps::HeatmapOptions &rendering = settings.rendering, defaults;
  const bool is_stream = settings.kind == model::ModelKind::stream;
  std::vector<std::string> words{"train", places.data.string()};
  const auto add = [&words](const std::string& option, const std::string& value) { words.insert(words.end(), {option, value}); };
  add(is_stream ? "--kind" : "--th", is_stream ? "stream" : ms_text(rendering.history));
  add("--seed", std::to_string(settings.training.seed));
  add(is_stream ? "--steps" : "--epochs", std::to_string(is_stream ? settings.stream.steps : settings.training.epochs));
  const bool one_thread = model::depends_on_threads(settings);  // a study's models must not depend on the machine
  if (one_thread) add("--threads", "1");
  add("--models", places.models.string());
  add("--name", bundle.name());
  const nlohmann::json rendered = rendering;
  if (rendering.tick != defaults.tick) add("--tick-us", std::to_string(rendering.tick.count()));
  if (rendering.factor != defaults.factor) add("--factor", fmt::format("{}", rendering.factor));
  if (rendering.resize != defaults.resize) add("--resize", rendered.at("resize"));
  if (rendering.denoise != defaults.denoise) add("--denoise", rendered.at("denoise"));
  if (settings.training.augmentation != model::Augmentation{}) add("--augment", text_of(settings.training.augmentation));
  if (settings.training.engine != model::EngineKind::fast) add("--engine", std::string(name_of(settings.training.engine)));
  if (settings.split.train_run != "01") add("--train-run", settings.split.train_run);
  if (settings.split.kind == windows::SplitKind::unseen) {
    add("--split", "unseen");
    add("--held-out", fmt::format("{}", fmt::join(settings.split.held_out, ",")));
  }
  return {.name = "train-" + bundle.name(),
          .command = command_of(words),
          .inputs = {{"manifest", dataset.manifest_hash()}, {"settings", settings}, {"models", places.models_from_study}},
          .outputs =
              [&dataset, settings, bundle] {
                return model::state_of(bundle, dataset, settings) == model::BundleState::unchanged
                           ? nlohmann::json(model::read_description(bundle).weights_sha256)
                           : nlohmann::json();
              },
          .arguments =
              [words, bundle, one_thread](const StepStart& start) {
                std::error_code ignored;
                if (start.begun_with_other_inputs)
                  std::filesystem::remove_all(model::CheckpointFolder::beside(bundle.folder), ignored);
                std::vector<std::string> all = words;
                all.insert(all.end(), {"--quiet", "--resume"});
                if (!one_thread) all.insert(all.end(), {"--threads", std::to_string(start.threads)});
                if (start.made_outputs) all.emplace_back("--force");
                return all;
              },
          .kind = "training"};
}

}  // namespace tactile::experiments
