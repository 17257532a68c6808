#include "chosen_model.hpp"

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

model::ModelBundle chosen_model(const std::string& model, const std::string& models) {
  if (!model.empty()) return named_model(model, models);
  if (auto pinned = model::pinned_bundle(models)) return *std::move(pinned);
  const auto is_single_run = [](const model::ModelDescription& found) {
    return found.settings.split.kind == windows::SplitKind::single_run;
  };
  if (const auto newest = model::newest_bundle(models, is_single_run)) return *newest;
  if (const auto newest = model::newest_bundle(models, [](const model::ModelDescription&) { return true; })) return *newest;
  throw Error(models + ": no model; expected one, run 'tactile train' first, or name it by --model");
}

std::string why_chosen(const model::ModelBundle& chosen, const std::string& models) {
  const auto pinned = model::pinned_bundle(models);
  return pinned && pinned->folder == chosen.folder ? "pinned" : "the newest";
}

}  // namespace tactile::cli
