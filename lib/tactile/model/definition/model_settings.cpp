#include "tactile/model/definition/model_settings.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <string_view>
#include <utility>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/json.hpp"

namespace tactile::model {
namespace {

nlohmann::json network_options(const ModelSettings& settings) {
  if (settings.kind == ModelKind::lenet) return json_of_fields(settings.network);
  nlohmann::json json = settings.kind == ModelKind::own ? nlohmann::json::object() : json_of_fields(settings.stream);
  json["kind"] = name_of(settings.kind);
  return json;
}

nlohmann::json training_options(const ModelSettings& settings) {
  if (settings.kind == ModelKind::lenet) return json_of_fields(settings.training);
  return {{"seed", settings.training.seed}};
}

/// Reads what `training_options` and `network_options` give. A bundle's "network" also describes the layers.
void read_options(const nlohmann::json& network, const nlohmann::json& training, ModelSettings& settings) {
  const std::string where = "model settings";
  settings.kind = network.contains("kind") ? kind_named(member<std::string>(network, "kind", where)) : ModelKind::lenet;
  FieldReader of_network(network, "network settings", {}, FieldReader::Missing::is_an_error);
  FieldReader of_training(training, "training settings", {}, FieldReader::Missing::is_an_error);
  if (settings.kind == ModelKind::lenet) {
    list_fields(of_network, settings.network);
    list_fields(of_training, settings.training);
  } else {
    if (settings.kind == ModelKind::stream) list_fields(of_network, settings.stream);
    settings.training.seed = member<std::uint64_t>(training, "seed", where);
  }
}

}  // namespace

void to_json(nlohmann::json& json, const ModelSettings& settings) {
  nlohmann::json split = {{"kind", name_of(settings.split.kind)}, {"train_run", settings.split.train_run}};
  if (settings.split.kind == windows::SplitKind::unseen) {
    auto held_out = settings.split.held_out;
    std::sort(held_out.begin(), held_out.end());
    held_out.erase(std::unique(held_out.begin(), held_out.end()), held_out.end());
    split["held_out"] = held_out;
  }
  json = {{"rendering", settings.rendering},
          {"split", split},
          {"network", network_options(settings)},
          {"training", training_options(settings)}};
  json["training"]["from"] = nullptr;
  if (settings.from)
    json["training"]["from"] = {{"name", settings.from->name}, {"weights_sha256", settings.from->weights_sha256}};
}

void from_json(const nlohmann::json& json, ModelSettings& settings) {
  const std::string where = "model settings";
  settings.rendering = member<nlohmann::json>(json, "rendering", where).get<heatmaps::HeatmapOptions>();
  const auto network = member<nlohmann::json>(json, "network", where);
  const auto training = member<nlohmann::json>(json, "training", where);
  read_options(network, training, settings);
  if (const auto from = member<nlohmann::json>(training, "from", where); !from.is_null())
    settings.from = StartingPoint{member<std::string>(from, "name", where), member<std::string>(from, "weights_sha256", where)};
  const auto split = member<nlohmann::json>(json, "split", where);
  settings.split.kind = windows::split_named(member<std::string>(split, "kind", where));
  settings.split.train_run = member<std::string>(split, "train_run", where);
  if (settings.split.kind == windows::SplitKind::unseen)
    settings.split.held_out = member<std::vector<std::string>>(split, "held_out", where);
}

std::vector<OptionValue> train_options(const ModelSettings& settings) {
  const ModelSettings usual;
  const std::vector<std::string> idle = idle_options(settings);
  std::vector<OptionValue> options;
  const auto add = [&](const std::string& name, const std::string& text) { options.push_back({name, text}); };
  if (settings.kind != usual.kind) add("--kind", std::string(name_of(settings.kind)));
  if (reads_heatmaps(settings.kind)) add("--th", fmt::format("{}", in_ms(settings.rendering.history)));
  if (settings.split.kind != usual.split.kind) {
    add("--split", std::string(name_of(settings.split.kind)));
    ModelSettings with_default = settings;
    with_default.split.held_out = windows::default_held_out();
    if (!same_settings(settings, with_default)) add("--held-out", fmt::format("{}", fmt::join(settings.split.held_out, ",")));
  }
  if (settings.split.train_run != usual.split.train_run) add("--train-run", settings.split.train_run);
  for (const std::vector<OptionValue>& some : {options_off(settings.rendering), options_off(settings.stream),
                                               options_off(settings.network), options_off(settings.training)}) {
    std::copy_if(some.begin(), some.end(), std::back_inserter(options), [&](const OptionValue& option) {
      return option.name != "--th" && std::find(idle.begin(), idle.end(), option.name) == idle.end();
    });
  }
  const TrainingOptions& training = settings.training;
  if (reads_heatmaps(settings.kind) && training.validation_share != (training.early_stop > 0 ? usual_validation_share : 0))
    add("--validation", fmt::format("{}", training.validation_share));
  return options;
}

std::vector<std::string> idle_options(const ModelSettings& settings) {
  std::vector<std::string> idle;
  const auto add = [&](const std::vector<OptionValue>& options) {
    for (const OptionValue& option : options) idle.push_back(option.name);
  };
  if (settings.kind == ModelKind::lenet) {
    add(options_off(settings.stream));
    return idle;
  }
  add(options_off(settings.training));
  add(options_off(settings.network));
  add(options_off(settings.rendering));
  if (settings.training.validation_share > 0) idle.emplace_back("--validation");
  if (settings.from) idle.emplace_back("--from");
  std::erase_if(idle, [](const std::string& name) { return name == "--seed" || name == "--th" || name == "--tick-us"; });
  return idle;
}

bool depends_on_threads(const ModelSettings& settings) {
  return settings.kind == ModelKind::lenet && (settings.training.engine != EngineKind::fast || !settings.network.is_fast());
}

bool same_settings(const ModelSettings& a, const ModelSettings& b) { return nlohmann::json(a) == nlohmann::json(b); }

namespace {

/// The settings that differ from the defaults and that no name has: history, kind, split, run and seed are parts of every name.
nlohmann::json off_default(const ModelSettings& settings) {
  ModelSettings plain;
  plain.kind = settings.kind;
  plain.split.kind = settings.split.kind;
  plain.split.train_run = settings.split.train_run;
  plain.training.seed = settings.training.seed;
  plain.rendering.history = settings.rendering.history;
  const nlohmann::json ours = settings, defaults = plain;
  nlohmann::json off = nlohmann::json::object();
  for (const auto& [group, options] : ours.items()) {
    for (const auto& [key, value] : options.items()) {
      if (!defaults.at(group).contains(key) || value != defaults.at(group).at(key)) off[group][key] = value;
    }
  }
  return off;
}

/// The option that sets it, as a part of a name.
std::string word_of(const std::string& key) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 4> shorter{
      {{"learning_rate", "lr"}, {"tick_us", "tick"}, {"validation_share", "validation"}, {"held_out", "without"}}};
  for (const auto& [member, word] : shorter) {
    if (member == key) return std::string(word);
  }
  std::string word = key;
  std::replace(word.begin(), word.end(), '_', '-');
  return word;
}

/// "epochs3", "denoise-none", "without-fan"; nothing if the value is no short word or number.
std::optional<std::string> words_of(const std::string& key, const nlohmann::json& value) {
  const nlohmann::json& one = value.is_array() && value.size() == 1 ? value.front() : value;
  if (one.is_number()) return word_of(key) + one.dump();
  if (!one.is_string()) return std::nullopt;
  const auto text = one.get<std::string>();
  const auto is_plain = [](char c) { return ('a' <= c && c <= 'z') || ('0' <= c && c <= '9') || c == '-'; };
  if (text.empty() || text.size() > 20 || !std::all_of(text.begin(), text.end(), is_plain)) return std::nullopt;
  return word_of(key) + "-" + text;
}

/// "-epochs3-denoise-none", or "-" and a hash; empty without such settings.
std::string suffix_of(const nlohmann::json& off) {
  constexpr std::size_t most_words = 3;
  std::string words;
  std::size_t count = 0;
  for (const auto& [group, options] : off.items()) {
    for (const auto& [key, value] : options.items()) {
      const std::optional<std::string> more = words_of(key, value);
      if (!more || ++count > most_words) return "-" + hash_of(off).substr(0, 8);
      words += "-" + *more;
    }
  }
  return words;
}

}  // namespace

std::string default_name(const ModelSettings& settings) {
  const windows::SplitOptions& split = settings.split;
  const std::string history = fmt::format("th{:g}", in_ms(settings.rendering.history));
  const std::string kind = settings.kind == ModelKind::lenet ? history : std::string(name_of(settings.kind));
  return fmt::format("{}-{}-{}{}{}", kind, split.kind == windows::SplitKind::unseen ? "unseen" : "single",
                     split.train_run == windows::SplitOptions{}.train_run ? "" : "run" + split.train_run + "-",
                     settings.training.seed, suffix_of(off_default(settings)));
}

}  // namespace tactile::model
