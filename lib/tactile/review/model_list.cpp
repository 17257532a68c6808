#include "tactile/review/model_list.hpp"

#include <cmath>

#include "tactile/core/changed_values.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/model/bundle/bundle_evaluations.hpp"
#include "tactile/model/bundle/bundle_names.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/model/definition/lenet_layers.hpp"
#include "tactile/results/evaluation.hpp"

namespace tactile::review {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json json_of(const results::Figure& figure) { return figure_json(figure.value, figure.low, figure.high); }

/// Settings that differ from those of a training without options, as the bundle has them; the split is always there.
json settings_json(const model::ModelSettings& settings) {
  json named = json::object();
  const json now = settings;
  for (const ChangedValue& value : changed_values(json(model::ModelSettings{}), now)) {
    if (!value.path.starts_with("split.")) named[value.path] = value.now;
  }
  named["split"] = now.at("split").at("kind");
  return named;
}

json eval_json(const model::ModelBundle& bundle) {
  const std::optional<fs::path> file = model::newest_evaluation(bundle);
  if (!file) return nullptr;
  const json document = read_json(*file);
  const auto evaluation = results::JsonView(document, file->string()).get<results::Evaluation>();
  const results::DetectorScore& score = evaluation.network;
  return {{"file", file->filename().string()},
          {"dataset", evaluation.dataset.file},
          {"manifest_hash", evaluation.dataset.manifest_hash},
          {"accuracy", json_of(evaluation.accuracy.mean)},
          {"press_delay_ms", json_of(score.press.all.median_of_all_ms.ms)},
          {"slip_delay_ms", json_of(score.slip.all.median_of_all_ms.ms)},
          {"missed", {{"press", json_of(score.press.all.missed)}, {"slip", json_of(score.slip.all.missed)}}},
          {"false_alarms_per_min", json_of(evaluation.whole_runs.decided.alarms_per_min)}};
}

json history_json(const fs::path& file) {
  json epochs = json::array();
  if (!is_file(file)) return epochs;
  for (const model::EpochResult& epoch : model::read_history(file)) epochs.push_back(epoch);
  return epochs;
}

json model_json(const model::ModelBundle& bundle) {
  json entry = {
      {"name", bundle.name()}, {"error", nullptr}, {"parameters", nullptr}, {"eval", nullptr}, {"history", json::array()}};
  try {
    const model::ModelDescription description = model::read_description(bundle);
    model::read_bundle_weights(bundle, description);
    entry["settings"] = settings_json(description.settings);
    entry["trained"] = {
        {"when", description.trained_at}, {"dataset", description.dataset}, {"manifest_hash", description.manifest_hash},
        {"runs", description.train_runs}, {"samples", description.samples}, {"simulated", description.simulated}};
    entry["kind"] = model::name_of(description.settings.kind);
    if (description.settings.kind == model::ModelKind::lenet)
      entry["parameters"] = model::lenet_layers(description.input).parameter_count();
    entry["history"] = history_json(bundle.history());
    entry["eval"] = eval_json(bundle);
  } catch (const std::exception& e) {
    entry["error"] = sentence_of(e, bundle.name());
  }
  return entry;
}

}  // namespace

json figure_json(double value, const std::optional<double>& low, const std::optional<double>& high) {
  const auto number = [](double one) { return std::isfinite(one) ? json(one) : json(); };
  return {{"value", number(value)}, {"low", low ? number(*low) : json()}, {"high", high ? number(*high) : json()}};
}

json models_json(const fs::path& models) {
  json list = json::array();
  for (const std::string& name : model::bundle_names(models)) list.push_back(model_json({models / name}));
  return list;
}

}  // namespace tactile::review
