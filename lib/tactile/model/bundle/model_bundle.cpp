#include "tactile/model/bundle/model_bundle.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "tactile/core/changed_values.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/json_object.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/event_digest.hpp"
#include "tactile/model/definition/model_network.hpp"

namespace tactile::model {
namespace {

namespace fs = std::filesystem;

constexpr int format_version = 2;

/// @throws Error  if a member that others are read from is no object
void check_members(const nlohmann::json& json, const std::string& where) {
  check_object(json, where + ":");
  const auto check_member = [&](const char* key, bool may_be_null) {
    const auto found = json.find(key);
    if (found != json.end() && !(may_be_null && found->is_null())) check_object(*found, fmt::format("{}: '{}'", where, key));
  };
  for (const char* key : {"dataset", "network", "rendering", "software", "split", "training"}) check_member(key, false);
  check_member("scene", true);
}

nlohmann::json learned_json(const std::vector<LearnedRun>& runs) {
  nlohmann::json json = nlohmann::json::array();
  for (const LearnedRun& run : runs) json.push_back(run);
  return json;
}

}  // namespace

void to_json(nlohmann::json& json, const LearnedRun& run) {
  json = {{"run", run.run}, {"events_sha256", run.events_sha256}, {"event_digest", run.event_digest}};
}

LearnedRun learned_run_in(const nlohmann::json& json, const std::string& where) {
  check_object(json, where + ": an entry of 'learned_from'");
  return {member<std::string>(json, "run", where), member<std::string>(json, "events_sha256", where),
          json.value("event_digest", "")};
}

void to_json(nlohmann::json& json, const ModelDescription& description) {
  json = description.settings;
  json["network"] = network_json(description.settings, description.input);
  json.update({{"format", format_version},
               {"classes", class_names()},
               {"dataset",
                {{"file", description.dataset},
                 {"manifest_hash", description.manifest_hash},
                 {"simulated", description.simulated},
                 {"manifest", description.manifest}}},
               {"train_runs", description.train_runs},
               {"test_runs", description.test_runs},
               {"learned_from", learned_json(description.learned_from)},
               {"samples", description.samples},
               {"scene", description.scene ? nlohmann::json(*description.scene) : nlohmann::json()},
               {"threads", description.threads},
               {"trained_at", description.trained_at},
               {"software", {{"name", "tactile"}, {"version", description.version}, {"revision", description.revision}}},
               {"weights_sha256", description.weights_sha256},
               {"epoch", description.epoch},
               {"best_epoch", description.best_epoch}});
}

void from_json(const nlohmann::json& json, ModelDescription& description) {
  const std::string where = "model.json";
  check_members(json, where);
  if (const int format = member<int>(json, "format", where); format != format_version) {
    throw Error(fmt::format("{}: of format {}; expected {}", where, format, format_version));
  }
  if (member<nlohmann::json>(json, "classes", where) != class_names()) {
    throw Error(where + ": its classes are not none, press and slip; expected these, in this order");
  }
  const auto input = member<nlohmann::json>(member<nlohmann::json>(json, "network", where), "input", where);
  description.input = {member<int>(input, "width", where), member<int>(input, "height", where)};
  try {
    description.settings = json.get<ModelSettings>();
  } catch (const Error& e) {
    throw Error(where + ": " + e.what());
  }
  if (!reads_heatmaps(description.settings.kind)) {
    const auto places = member<std::size_t>(input, "places", where), features = member<std::size_t>(input, "features", where);
    if (places != StreamLayout::places || features != StreamLayout::inputs_of_place)
      throw Error(fmt::format("{}: reads {} x {} features; expected {} x {}", where, places, features, StreamLayout::places,
                              StreamLayout::inputs_of_place));
  }
  const auto dataset = member<nlohmann::json>(json, "dataset", where);
  description.dataset = member<std::string>(dataset, "file", where);
  description.manifest_hash = member<std::string>(dataset, "manifest_hash", where);
  description.simulated = member<bool>(dataset, "simulated", where);
  description.manifest = member<nlohmann::json>(dataset, "manifest", where);
  description.train_runs = member<std::vector<std::string>>(json, "train_runs", where);
  description.test_runs = member<std::vector<std::string>>(json, "test_runs", where);
  for (const auto& run : member<std::vector<nlohmann::json>>(json, "learned_from", where))
    description.learned_from.push_back(learned_run_in(run, where));
  description.samples = member<std::uint64_t>(json, "samples", where);
  if (json.contains("scene") && !json.at("scene").is_null())
    description.scene = json.at("scene").get<characterise::SceneRanges>();
  description.threads = member<unsigned>(json, "threads", where);
  description.trained_at = member<std::string>(json, "trained_at", where);
  const auto software = member<nlohmann::json>(json, "software", where);
  description.version = member<std::string>(software, "version", where);
  description.revision = member<std::string>(software, "revision", where);
  description.weights_sha256 = member<std::string>(json, "weights_sha256", where);
  description.epoch = member<unsigned>(json, "epoch", where);
  description.best_epoch = member<unsigned>(json, "best_epoch", where);
}

namespace {

/// Checks the ranges of the settings, because anyone may have edited the file.
void check_description(const ModelDescription& description) {
  constexpr int longest_side = 32'767;  // [px]
  const auto within = [](const std::string& member, const auto& work) {
    try {
      work();
    } catch (const Error& e) {
      throw Error("model.json: " + member + ": " + e.what());
    }
  };
  const events::SensorSize& input = description.input;
  if (std::min(input.width, input.height) < 1 || std::max(input.width, input.height) > longest_side)
    throw Error(
        fmt::format("model.json: network.input: {} x {}; expected sides of 1 to {}", input.width, input.height, longest_side));
  within("rendering", [&] { check(description.settings.rendering); });
  within("training", [&] { check(description.settings.training); });
  if (description.threads < 1) throw Error("model.json: threads: 0; expected at least 1");
}

/// Checks what "network" repeats of the network that the weights are read for. Older bundles have less.
void check_network(const nlohmann::json& network, const ModelDescription& description) {
  const bool has_layers = network.contains("layers");
  for (const ChangedValue& value : changed_values(network, network_json(description.settings, description.input))) {
    const bool is_in_one_only = value.before.is_null() || value.now.is_null();
    if (is_in_one_only && !(has_layers && value.path.starts_with("layers."))) continue;
    throw Error(fmt::format("model.json: network.{} is {}; expected {}, as in the network of its weights", value.path,
                            value.before.dump(), value.now.dump()));
  }
}

}  // namespace

void write_bundle(const ModelBundle& bundle, ModelDescription description, const TrainedWeights& weights,
                  const TrainingSummary& summary, IfThere if_there, const nlohmann::json& command_settings) {
  WholeFile whole(bundle.folder, if_there);
  const ModelBundle written{whole.path()};
  const auto metadata = weights_metadata(description);
  write_weights(written.weights(), weights.weights, metadata);
  const bool uses_best = description.settings.training.early_stop > 0;
  if (!weights.other.empty()) write_weights(uses_best ? written.last_weights() : written.best_weights(), weights.other, metadata);
  const unsigned last_epoch = summary.history.empty() ? 0 : summary.history.back().epoch;
  description.weights_sha256 = sha256_of_file(written.weights());
  description.best_epoch = summary.best_epoch;
  description.epoch = uses_best ? summary.best_epoch : last_epoch;
  write_whole(written.history(), history_csv(summary.history));
  nlohmann::json json = description;
  const EpochResult last = summary.history.empty() ? EpochResult{} : summary.history.back();
  json["result"] = {{"loss", last.loss},
                    {"accuracy", last.accuracy},
                    {"seconds", summary.seconds},
                    {"validation_samples", summary.validation_samples},
                    {"stopped_early", summary.stopped_early}};
  if (!command_settings.is_null()) write_json(written.settings(), command_settings);
  write_json(written.description(), json);
  whole.commit();
}

std::vector<std::string> names_of(const std::vector<LearnedRun>& runs) {
  std::vector<std::string> names;
  names.reserve(runs.size());
  for (const LearnedRun& run : runs) names.push_back(run.run);
  return names;
}

LearnedRun learned_run_of(const windows::DatasetRun& run) {
  return {name_of(run), run.events_sha256, run.recording ? run.recording->digest : ""};
}

bool contains_recording(std::span<const LearnedRun> runs, const LearnedRun& run) {
  return std::any_of(runs.begin(), runs.end(), [&](const LearnedRun& one) {
    return one.events_sha256 == run.events_sha256 || (!one.event_digest.empty() && one.event_digest == run.event_digest);
  });
}

bool learned_from(const ModelDescription& model, const windows::DatasetRun& run) {
  return contains_recording(model.learned_from, learned_run_of(run));
}

bool learned_from(const ModelDescription& model, const std::filesystem::path& recording) {
  const auto& runs = model.learned_from;
  LearnedRun run{.run = {}, .events_sha256 = sha256_of_file(recording), .event_digest = {}};
  if (contains_recording(runs, run)) return true;
  const auto has_digest = [](const LearnedRun& learned) { return !learned.event_digest.empty(); };
  if (std::none_of(runs.begin(), runs.end(), has_digest)) return false;
  run.event_digest = events::event_digest_of(recording);
  return contains_recording(runs, run);
}

std::map<std::string, std::string> weights_metadata(const ModelDescription& description) {
  const nlohmann::json rendering = description.settings.rendering;
  const events::SensorSize input = description.input;
  const nlohmann::json of_heatmaps{
      {"shape", {1, input.height, input.width}}, {"type", "float32"}, {"scale", "heatmap / 255, in [0, 1]"}};
  const nlohmann::json of_stream{{"shape", {StreamLayout::places, StreamLayout::inputs_of_place}},
                                 {"type", "float32"},
                                 {"sensor", {{"height", input.height}, {"width", input.width}}}};
  return {{"format", "pt"},  // PyTorch's order of a tensor's values
          {"classes", class_names().dump()},
          {"input", (reads_heatmaps(description.settings.kind) ? of_heatmaps : of_stream).dump()},
          {"network", network_json(description.settings, input).dump()},
          {"rendering", rendering.dump()},
          {"split", nlohmann::json(description.settings).at("split").dump()},
          {"learned_from", nlohmann::json(names_of(description.learned_from)).dump()},
          {"dataset", nlohmann::json{{"manifest_hash", description.manifest_hash}, {"simulated", description.simulated}}.dump()},
          {"software", nlohmann::json{{"name", "tactile"}, {"version", description.version}}.dump()}};
}

namespace {

/// Of a network of one's own: what its description says, and its hash.
ModelDescription description_of_own(const fs::path& network) {
  ModelDescription description;
  description.own = read_own_description(network);
  description.settings.kind = ModelKind::own;
  description.settings.rendering = description.own->rendering;
  description.input = description.own->sensor;
  for (const nlohmann::json& run : description.own->learned_from)
    description.learned_from.push_back(learned_run_in(run, own_description_file(network).string()));
  description.train_runs = names_of(description.learned_from);
  description.weights_sha256 = sha256_of_file(network);
  return description;
}

}  // namespace

ModelDescription read_description(const ModelBundle& bundle) {
  if (is_own_network(bundle.folder)) return description_of_own(bundle.folder);
  if (!fs::is_regular_file(bundle.description())) {
    throw Error(bundle.folder.string() + ": no model; expected a folder with model.json, as 'tactile train' makes it");
  }
  try {
    const nlohmann::json json = read_json(bundle.description());
    auto description = json.get<ModelDescription>();
    check_description(description);
    check_network(json.at("network"), description);
    return description;
  } catch (const Error& e) {
    throw Error(bundle.folder.string() + ": " + e.what());
  }
}

Weights read_bundle_weights(const ModelBundle& bundle, const ModelDescription& description) {
  const std::vector<ParameterShape> parameters = parameters_of(description.settings, description.input);
  if (!fs::is_regular_file(bundle.weights())) {
    throw Error(bundle.weights().string() + ": missing; expected the weights in the folder of model.json");
  }
  if (sha256_of_file(bundle.weights()) != description.weights_sha256) {
    throw Error(bundle.weights().string() + ": its hash differs from model.json; expected the bundle as it was written");
  }
  Weights weights = read_weights(bundle.weights(), parameters);
  check_finite(weights, bundle.weights().string(), largest_weight);
  return weights;
}

std::optional<ModelBundle> newest_bundle(const fs::path& models, const std::function<bool(const ModelDescription&)>& wanted) {
  std::optional<ModelBundle> newest;
  std::string trained_at;
  std::error_code failed;
  if (!fs::is_directory(models, failed)) return newest;
  std::vector<fs::path> folders;
  for (fs::directory_iterator entry(models, failed), end; !failed && entry != end; entry.increment(failed))
    folders.push_back(entry->path());
  if (failed) throw Error(models.string() + ": cannot be read (" + failed.message() + "); expected a folder of models");
  std::sort(folders.begin(), folders.end());
  for (const fs::path& folder : folders) {
    const ModelBundle bundle{folder};
    if (bundle.name().front() == '.' || !fs::is_regular_file(bundle.description(), failed)) continue;
    try {
      const ModelDescription description = read_description(bundle);
      if (!wanted(description) || (newest && description.trained_at < trained_at)) continue;
      newest = bundle;
      trained_at = description.trained_at;
    } catch (const Error&) {
      // Not a model, or damaged. An explicit use of it reports the error.
    }
  }
  return newest;
}

ModelBundle free_bundle(const fs::path& models, const std::string& name,
                        const std::function<bool(const ModelBundle&, const ModelDescription&)>& is_in_the_way) {
  ModelBundle bundle{models / name};
  for (unsigned number = 2;; ++number) {
    std::error_code unknown;
    if (!fs::exists(bundle.description(), unknown)) return bundle;
    try {
      if (!is_in_the_way(bundle, read_description(bundle))) return bundle;
    } catch (const Error&) {
      return bundle;
    }
    bundle.folder = models / fmt::format("{}-{}", name, number);
  }
}

}  // namespace tactile::model
