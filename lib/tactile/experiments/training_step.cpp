#include "tactile/experiments/training_step.hpp"

#include "tactile/core/text_lines.hpp"
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
  std::vector<std::string> words{"train", places.data.string()};
  const auto add = [&words](const std::string& option, const std::string& value) { words.insert(words.end(), {option, value}); };
  for (const OptionValue& option : model::train_options(settings)) add(option.name, option.text);
  const bool one_thread = model::depends_on_threads(settings);  // a study's models must not depend on the machine
  if (one_thread) add("--threads", "1");
  add("--models", places.models.string());
  add("--name", bundle.name());
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
