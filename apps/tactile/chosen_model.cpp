#include "chosen_model.hpp"

#include <spdlog/spdlog.h>

#include <filesystem>

#include "tactile/core/error.hpp"
#include "tactile/model/bundle/pinned_bundle.hpp"

namespace tactile::cli {

namespace fs = std::filesystem;

model::ModelBundle named_model(const std::string& model, const std::string& models) {
  const fs::path given(model);
  if (!fs::is_directory(given)) return {fs::path(models) / given};
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

void log_choice(const std::string& doing, const ChosenModel& chosen) {
  spdlog::info("{} {}{}", doing, chosen.bundle.folder.string(), chosen.why.empty() ? "" : ", " + chosen.why);
}

}  // namespace tactile::cli
