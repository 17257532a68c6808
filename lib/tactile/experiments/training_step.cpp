#include "tactile/experiments/training_step.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include "tactile/core/text_lines.hpp"
#include "tactile/experiments/milliseconds.hpp"
#include "tactile/model/training/checkpoint.hpp"
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
  std::vector<std::string> words{"train",     places.data.string(),
                                 "--th",      ms_text(rendering.history),
                                 "--seed",    std::to_string(settings.training.seed),
                                 "--epochs",  std::to_string(settings.training.epochs),
                                 "--threads", "1",
                                 "--models",  places.models.string()};
  const nlohmann::json rendered = rendering;
  if (rendering.tick != defaults.tick) words.insert(words.end(), {"--tick-us", std::to_string(rendering.tick.count())});
  if (rendering.factor != defaults.factor) words.insert(words.end(), {"--factor", fmt::format("{}", rendering.factor)});
  if (rendering.resize != defaults.resize) words.insert(words.end(), {"--resize", rendered.at("resize")});
  if (rendering.denoise != defaults.denoise) words.insert(words.end(), {"--denoise", rendered.at("denoise")});
  if (settings.network.width != model::LeNetOptions{}.width)
    words.insert(words.end(), {"--width", fmt::format("{:g}", settings.network.width)});
  if (settings.network.last_pool != model::LeNetOptions{}.last_pool)
    words.insert(words.end(), {"--last-pool", std::to_string(settings.network.last_pool)});
  if (settings.training.engine != model::EngineKind::fast)
    words.insert(words.end(), {"--engine", std::string(name_of(settings.training.engine))});
  if (settings.split.train_run != "01") words.insert(words.end(), {"--train-run", settings.split.train_run});
  if (settings.split.kind == windows::SplitKind::unseen)
    words.insert(words.end(), {"--split", "unseen", "--held-out", fmt::format("{}", fmt::join(settings.split.held_out, ","))});
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
              [words, bundle](const StepPast& past) {
                std::error_code ignored;
                if (past.begun_with_other_inputs)
                  std::filesystem::remove_all(model::CheckpointFolder::beside(bundle.folder), ignored);
                std::vector<std::string> all = words;
                all.insert(all.end(), {"--quiet", "--resume"});
                if (past.made_outputs) all.emplace_back("--force");
                return all;
              }};
}

}  // namespace tactile::experiments
