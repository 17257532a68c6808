#include "tactile/model/bundle/pinned_bundle.hpp"

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/model/bundle/bundle_names.hpp"

namespace tactile::model {
namespace {

namespace fs = std::filesystem;

fs::path pin_of(const fs::path& models) { return models / "pinned"; }

fs::path last_of(const fs::path& models) { return models / "last"; }

std::string name_in(const fs::path& pin) {
  constexpr std::size_t longest_name = 4096;
  std::string name = read_text(pin, longest_name);
  while (!name.empty() && (name.back() == '\n' || name.back() == '\r')) name.pop_back();
  return name;
}

bool is_bundle(const fs::path& models, const std::string& name) {
  const std::vector<std::string> names = bundle_names(models);
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

std::optional<ModelBundle> pinned_bundle(const fs::path& models) {
  const fs::path pin = pin_of(models);
  if (!is_file(pin)) return std::nullopt;
  const std::string name = name_in(pin);
  if (!is_bundle(models, name)) {
    throw Error(pin.string() + ": names a model that is not there; expected the name of a model in " + models.string() +
                ": run 'tactile models pin NAME', or 'tactile models unpin'");
  }
  return ModelBundle{models / name};
}

void pin_bundle(const fs::path& models, const std::string& name) {
  if (!is_bundle(models, name))
    throw Error((models / name).string() + ": is no model; expected a name that 'tactile models' lists");
  write_whole(pin_of(models), name + "\n");
}

std::string unpin_bundle(const fs::path& models) {
  const fs::path pin = pin_of(models);
  if (!is_file(pin)) return {};
  std::string name = name_in(pin);
  fs::remove(pin);
  return name;
}

std::optional<ModelBundle> last_bundle(const fs::path& models) {
  const fs::path file = last_of(models);
  if (!is_file(file)) return std::nullopt;
  const std::string name = name_in(file);
  if (!is_bundle(models, name)) return std::nullopt;
  return ModelBundle{models / name};
}

void note_last_bundle(const ModelBundle& bundle) {
  const fs::path file = last_of(bundle.folder.parent_path());
  if (is_file(file) && name_in(file) == bundle.name()) return;
  write_whole(file, bundle.name() + "\n");
}

}  // namespace tactile::model
