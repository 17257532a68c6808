#include "kind_arguments.hpp"

#include <fmt/core.h>

#include <utility>
#include <vector>

#include "option_checks.hpp"
#include "tactile/core/error.hpp"

namespace tactile::cli {

void add_kind_options(Command command, KindArguments& args) {
  command
      .add_option("--kind", args.kind,
                  "Kind of model: lenet, on heatmaps; stream, a recurrent network on the events of each tick, trained on whole "
                  "runs")
      .check(one_of({"lenet", "stream"}))
      .show_default();
  command.add_option("--steps", args.stream.steps, "With --kind stream: steps of the training")
      .check(in_range(1U, 100'000U))
      .show_default();
}

void check_options_of_kind(const model::ModelSettings& settings, bool starts_from_a_model) {
  using Options = std::vector<std::pair<const char*, bool>>;  // names, and whether they are off their defaults
  const model::ModelSettings usual;
  const model::TrainingOptions &training = settings.training, &usually = usual.training;
  const heatmaps::HeatmapOptions &rendering = settings.rendering, &rendered = usual.rendering;
  const auto refuse = [&](const Options& options, const char* others) {
    for (const auto& [name, is_given] : options) {
      if (is_given)
        throw Error(
            fmt::format("{}: a model of kind {} has none; expected --kind {} with it", name, name_of(settings.kind), others));
    }
  };
  if (settings.kind == model::ModelKind::lenet)
    return refuse({{"--steps", settings.stream.steps != usual.stream.steps}}, "stream");
  refuse({{"--engine", training.engine != usually.engine},
          {"--augment", training.augmentation != usually.augmentation},
          {"--early-stop", training.early_stop != usually.early_stop},
          {"--validation", training.validation_share != usually.validation_share},
          {"--activation", settings.network.activation != usual.network.activation},
          {"--pool", settings.network.pooling != usual.network.pooling},
          {"--denoise", rendering.denoise != rendered.denoise},
          {"--resize", rendering.resize != rendered.resize},
          {"--factor", rendering.factor != rendered.factor},
          {"--from", starts_from_a_model},
          {"--epochs", training.epochs != usually.epochs},
          {"--batch", training.batch != usually.batch},
          {"--lr", training.learning_rate != usually.learning_rate},
          {"--schedule", training.schedule != usually.schedule},
          {"--optimizer", training.optimizer != usually.optimizer},
          {"--class-weights", training.class_weights != usually.class_weights}},
         "lenet");
}

}  // namespace tactile::cli
