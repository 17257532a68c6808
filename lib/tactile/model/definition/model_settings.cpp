#include "tactile/model/definition/model_settings.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <utility>

#include "tactile/core/json.hpp"

namespace tactile::model {
namespace {

nlohmann::json network_options(const ModelSettings& settings) {
  if (settings.kind == ModelKind::lenet) return settings.network;  // as before there were other kinds
  nlohmann::json json = settings.kind == ModelKind::own ? nlohmann::json::object() : nlohmann::json(settings.stream);
  json["kind"] = name_of(settings.kind);
  return json;
}

nlohmann::json training_options(const ModelSettings& settings) {
  if (settings.kind == ModelKind::lenet) return settings.training;
  return {{"seed", settings.training.seed}};
}

/// Reads what `training_options` and `network_options` give.
void read_options(const nlohmann::json& network, const nlohmann::json& training, ModelSettings& settings) {
  const std::string where = "model settings";
  settings.kind = network.contains("kind") ? kind_named(member<std::string>(network, "kind", where)) : ModelKind::lenet;
  if (settings.kind == ModelKind::lenet) {
    settings.network = network.get<LeNetOptions>();
    settings.training = training.get<TrainingOptions>();
  } else {
    settings.stream = network.get<StreamOptions>();
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

bool depends_on_threads(const ModelSettings& settings) {
  return settings.kind == ModelKind::lenet && (settings.training.engine != EngineKind::fast || !settings.network.is_fast());
}

bool same_settings(const ModelSettings& a, const ModelSettings& b) { return nlohmann::json(a) == nlohmann::json(b); }

namespace {

/// The settings that differ from the defaults and that no name has: history, kind, split, run and seed are parts of every name.
/// @param whole_ms  whether the name has the history in whole milliseconds only
nlohmann::json off_default(const ModelSettings& settings, bool whole_ms) {
  ModelSettings plain;
  plain.kind = settings.kind;
  plain.split.kind = settings.split.kind;
  plain.split.train_run = settings.split.train_run;
  plain.training.seed = settings.training.seed;
  plain.rendering.history = whole_ms ? microseconds{settings.rendering.history / 1ms * 1ms} : settings.rendering.history;
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
  const std::string history = fmt::format("th{:g}", static_cast<double>(settings.rendering.history.count()) / 1000);
  const std::string kind = settings.kind == ModelKind::lenet ? history : std::string(name_of(settings.kind));
  return fmt::format("{}-{}-{}{}{}", kind, split.kind == windows::SplitKind::unseen ? "unseen" : "single",
                     split.train_run == windows::SplitOptions{}.train_run ? "" : "run" + split.train_run + "-",
                     settings.training.seed, suffix_of(off_default(settings, false)));
}

std::string full_name(const ModelSettings& settings) {
  const std::string kind = settings.kind == ModelKind::lenet ? "" : fmt::format("{}-", name_of(settings.kind));
  const std::string name = fmt::format("{}th{:03}-{}-{}-s{}", kind, settings.rendering.history / 1ms,
                                       name_of(settings.split.kind), settings.split.train_run, settings.training.seed);
  const nlohmann::json off = off_default(settings, true);
  return off.empty() ? name : name + "-" + hash_of(off).substr(0, 8);
}

}  // namespace tactile::model
