#include "chosen_model.hpp"

#include <spdlog/spdlog.h>

#include <filesystem>

#include "tactile/core/error.hpp"
#include "tactile/model/bundle/pinned_bundle.hpp"

namespace tactile::cli {

namespace fs = std::filesystem;

model::ModelBundle named_model(const std::string& model, const std::string& models) {
  const fs::path given(model);
  if (model::is_own_network(given)) return {given};
  if (!fs::is_directory(given)) {
    const fs::path named = fs::path(models) / given;
    if ((given.extension() == ".pt" || given.extension() == ".onnx") && !fs::exists(named))
      throw Error(model + ": no such file; expected a network's file, or the name of a model in " + models);
    return {named};
  }
  return {given.filename().empty() ? given.parent_path() : given};
}

std::optional<ChosenModel> model_without_name(const std::string& models, const std::string* dataset) {
  if (auto pinned = model::pinned_bundle(models)) return ChosenModel{*std::move(pinned), "the pinned model"};
  const auto suits = [dataset](const model::ModelDescription& found) { return !dataset || found.manifest_hash == *dataset; };
  if (auto last = model::last_bundle(models)) {
    try {
      if (suits(model::read_description(*last))) return ChosenModel{*std::move(last), "the last one that 'train' made here"};
    } catch (const Error&) {
      // It is damaged. An explicit use of it reports the error.
    }
  }
  const auto is_single_run = [&](const model::ModelDescription& found) {
    return suits(found) && found.settings.split.kind == windows::SplitKind::single_run;
  };
  if (auto newest = model::newest_bundle(models, is_single_run))
    return ChosenModel{*std::move(newest), "the newest single-run model"};
  if (auto newest = model::newest_bundle(models, suits)) return ChosenModel{*std::move(newest), "the newest model"};
  return std::nullopt;
}

ChosenModel chosen_model(const std::string& model, const std::string& models) {
  if (!model.empty()) return {named_model(model, models), {}};
  if (auto chosen = model_without_name(models)) return *std::move(chosen);
  throw Error(models + ": no model; expected one, run 'tactile train' first, or name it by --model");
}

ChosenModel live_model(const std::string& model, const std::string& models) {
  if (model.empty() && !model::pinned_bundle(models)) {
    const auto is_stream = [](const model::ModelDescription& found) { return found.settings.kind == model::ModelKind::stream; };
    const auto knows_all = [&](const model::ModelDescription& found) {
      return is_stream(found) && found.settings.split.kind == windows::SplitKind::single_run;
    };
    const auto last = model_without_name(models);
    if (last && is_stream(model::read_description(last->bundle))) return *last;
    // A stream that never saw some objects is there to be evaluated.
    auto newest = model::newest_bundle(models, knows_all);
    if (!newest) newest = model::newest_bundle(models, is_stream);
    if (newest) return {*std::move(newest), "the newest model of kind stream"};
  }
  return chosen_model(model, models);
}

void log_choice(const std::string& doing, const ChosenModel& chosen) {
  spdlog::info("{} {}{}", doing, chosen.bundle.folder.string(), chosen.why.empty() ? "" : ", " + chosen.why);
}

}  // namespace tactile::cli
