#include "tactile/model/model_bundle.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <stdio.h>

#include <algorithm>
#include <sstream>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;

constexpr int format_version = 1;

nlohmann::json class_names() {
  nlohmann::json names = nlohmann::json::array();
  for (const Touch touch : all_touches) names.push_back(name_of(touch));
  return names;
}

std::string history_csv(const std::vector<EpochResult>& history) {
  std::string text = "epoch,loss,accuracy,images_per_s,seconds\n";
  for (const EpochResult& epoch : history) {
    text += fmt::format("{},{:.9g},{:.9g},{:.1f},{:.3f}\n", epoch.epoch, epoch.loss, epoch.accuracy, epoch.images_per_s,
                        epoch.seconds);
  }
  return text;
}

/// Puts a whole folder where another one lies, at once; the old one then lies where the new one did.
void exchange(const fs::path& folder, const fs::path& other) {
  if (::renameat2(AT_FDCWD, folder.c_str(), AT_FDCWD, other.c_str(), RENAME_EXCHANGE) == 0) return;
  // Not every file system exchanges: then the old folder steps aside first.
  const fs::path aside = folder.string() + ".old";
  std::error_code failed;
  fs::rename(other, aside, failed);
  if (!failed) fs::rename(folder, other, failed);
  if (!failed) fs::rename(aside, folder, failed);
  if (failed) throw Error(other.string() + ": cannot be replaced (" + failed.message() + "); expected a writable folder");
}

}  // namespace

void to_json(nlohmann::json& json, const ModelDescription& description) {
  json = {{"format", format_version},
          {"network", lenet_layers(description.input)},
          {"classes", class_names()},
          {"dataset",
           {{"file", description.dataset},
            {"manifest_hash", description.manifest_hash},
            {"simulated", description.simulated},
            {"manifest", description.manifest}}},
          {"train_runs", description.train_runs},
          {"test_runs", description.test_runs},
          {"samples", description.samples},
          {"threads", description.threads},
          {"trained_at", description.trained_at},
          {"software", {{"name", "tactile"}, {"version", description.version}, {"revision", description.revision}}},
          {"weights_sha256", description.weights_sha256}};
  json.update(nlohmann::json(description.settings));
}

void from_json(const nlohmann::json& json, ModelDescription& description) {
  const std::string where = "model.json";
  if (const int format = member<int>(json, "format", where); format != format_version) {
    throw Error(fmt::format("{}: of format {}; expected {}", where, format, format_version));
  }
  if (member<nlohmann::json>(json, "classes", where) != class_names()) {
    throw Error(where + ": its classes are not none, press and slip; expected these, in this order");
  }
  const auto input = member<nlohmann::json>(member<nlohmann::json>(json, "network", where), "input", where);
  description.input = {member<int>(input, "width", where), member<int>(input, "height", where)};
  description.settings = json.get<ModelSettings>();
  const auto dataset = member<nlohmann::json>(json, "dataset", where);
  description.dataset = member<std::string>(dataset, "file", where);
  description.manifest_hash = member<std::string>(dataset, "manifest_hash", where);
  description.simulated = member<bool>(dataset, "simulated", where);
  description.manifest = member<nlohmann::json>(dataset, "manifest", where);
  description.train_runs = member<std::vector<std::string>>(json, "train_runs", where);
  description.test_runs = member<std::vector<std::string>>(json, "test_runs", where);
  description.samples = member<std::uint64_t>(json, "samples", where);
  description.threads = member<unsigned>(json, "threads", where);
  description.trained_at = member<std::string>(json, "trained_at", where);
  const auto software = member<nlohmann::json>(json, "software", where);
  description.version = member<std::string>(software, "version", where);
  description.revision = member<std::string>(software, "revision", where);
  description.weights_sha256 = member<std::string>(json, "weights_sha256", where);
}

void write_bundle(const ModelBundle& bundle, ModelDescription description, const Weights& weights,
                  const TrainingSummary& summary) {
  WholeFile whole(bundle.folder);
  const ModelBundle written{whole.path()};
  write_weights(written.weights(), weights);
  description.weights_sha256 = sha256_of_file(written.weights());
  write_whole(written.history(), history_csv(summary.history));
  nlohmann::json json = description;
  const EpochResult last = summary.history.empty() ? EpochResult{} : summary.history.back();
  json["result"] = {{"loss", last.loss}, {"accuracy", last.accuracy}, {"seconds", summary.seconds}};
  write_json(written.description(), json);
  if (!fs::exists(bundle.folder)) return whole.commit();
  sync_to_disk(written.folder);
  exchange(written.folder, bundle.folder);  // what lay there is removed with the temporary folder
  sync_to_disk(bundle.folder.has_parent_path() ? bundle.folder.parent_path() : ".");
}

ModelDescription read_description(const ModelBundle& bundle) {
  if (!fs::is_regular_file(bundle.description())) {
    throw Error(bundle.folder.string() + ": no model; expected a folder with model.json, as 'tactile train' makes it");
  }
  try {
    return read_json(bundle.description()).get<ModelDescription>();
  } catch (const Error& e) {
    throw Error(bundle.folder.string() + ": " + e.what());
  }
}

Weights read_bundle_weights(const ModelBundle& bundle, const ModelDescription& description) {
  const LeNetLayers layers = lenet_layers(description.input);
  if (!fs::is_regular_file(bundle.weights())) {
    throw Error(bundle.weights().string() + ": missing; expected the weights of the model beside its model.json");
  }
  if (sha256_of_file(bundle.weights()) != description.weights_sha256) {
    throw Error(bundle.weights().string() +
                ": not the weights that model.json names by their hash; expected the bundle as it was written");
  }
  return read_weights(bundle.weights(), layers.parameters());
}

std::optional<double> images_per_s(const ModelBundle& bundle) {
  if (!fs::is_regular_file(bundle.history())) return std::nullopt;
  std::istringstream lines(read_text(bundle.history()));
  std::string line, last;
  while (std::getline(lines, line)) last = line;
  std::istringstream cells(last);
  for (int column = 0; column < 4; ++column) {
    if (!std::getline(cells, line, ',')) return std::nullopt;
  }
  return number_in(line);
}

std::optional<ModelBundle> newest_bundle(const fs::path& models, const std::function<bool(const ModelDescription&)>& wanted) {
  std::optional<ModelBundle> newest;
  std::string trained_at;
  if (!fs::is_directory(models)) return newest;
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(models)) folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end());
  for (const fs::path& folder : folders) {
    const ModelBundle bundle{folder};
    if (bundle.name().front() == '.' || !fs::is_regular_file(bundle.description())) continue;
    try {
      const ModelDescription description = read_description(bundle);
      if (!wanted(description) || (newest && description.trained_at < trained_at)) continue;
      newest = bundle;
      trained_at = description.trained_at;
    } catch (const Error&) {
      // Someone else's folder, or one that is damaged: whoever names it is told so.
    }
  }
  return newest;
}

}  // namespace tactile
