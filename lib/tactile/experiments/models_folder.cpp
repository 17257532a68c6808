#include "tactile/experiments/models_folder.hpp"

#include <nlohmann/json.hpp>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/experiments/step_runner.hpp"

namespace tactile::experiments {

namespace fs = std::filesystem;

fs::path models_folder(const fs::path& named, const fs::path& out) {
  if (!named.empty()) return named;
  for (const nlohmann::json& step : step_records(out, "train-")) {
    try {
      return (out / member<std::string>(member<nlohmann::json>(step, "inputs", ""), "models", "")).lexically_normal();
    } catch (const Error&) {
      // The runner of the steps does a step again whose record is damaged.
    }
  }
  return out / "models";
}

namespace {

/// Whether a step of this experiment made the bundle of this name: then it may replace it.
bool made_here(const fs::path& out, const std::string& name) {
  const fs::path file = out / "steps" / ("train-" + name + ".json");
  if (!is_file(file)) return false;
  try {
    return member<bool>(read_json(file), "made_outputs", file.string());
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

model::ModelBundle training_bundle(const fs::path& models, const fs::path& out, const model::ModelSettings& settings,
                                   const std::string& manifest_hash) {
  const auto is_foreign = [&](const model::ModelBundle& bundle, const model::ModelDescription& model) {
    if (made_here(out, bundle.name())) return false;
    return model.manifest_hash != manifest_hash || !model::same_settings(model.settings, settings);
  };
  return model::free_bundle(models, model::default_name(settings), is_foreign);
}

}  // namespace tactile::experiments
