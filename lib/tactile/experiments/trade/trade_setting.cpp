#include "tactile/experiments/trade/trade_setting.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"

namespace tactile::trade {
namespace {

/// One value of a setting in words.
struct SettingWords {
  const char* key;  ///< in JSON
  std::string id, text;
};

std::string kind_text(model::ModelKind kind) {
  return kind == model::ModelKind::lenet ? "LeNet" : kind == model::ModelKind::trees ? "trees" : "temporal convolution";
}

std::vector<SettingWords> words_of(const TradeSetting& setting) {
  const results::SettingValues values = values_of(setting);
  return {{"kind", "", kind_text(setting.kind)},
          {"th_ms", fmt::format("th{:g}", values.th_ms), fmt::format("t_h {:g} ms", values.th_ms)},
          {"tick_ms", fmt::format("tick{:g}", values.tick_ms), fmt::format("tick {:g} ms", values.tick_ms)},
          {"factor", fmt::format("f{:.6g}", values.factor), fmt::format("factor {:g}", values.factor)},
          {"resize", values.resize, "resize " + values.resize},
          {"denoise", values.denoise, "denoise " + values.denoise},
          {"width", "", fmt::format("width {:g}", values.width)},
          {"last_pool", "", fmt::format("last pooling {0} x {0}", values.last_pool)},
          {"augment", "", values.augment == "none" ? "no augmentation" : "augment " + values.augment},
          {"engine", values.engine, "engine " + values.engine},
          {"precision", values.precision, values.precision},
          {"pass", values.pass, values.pass},
          {"confirm", fmt::format("{}of{}", setting.confirmation.needed, setting.confirmation.of), "confirm " + values.confirm},
          {"filter", "", setting.alarm_cost ? "filter " + values.filter : "no filter"},
          {"gate", values.gate ? "gate" : "open", values.gate ? "gate" : "no gate"}};
}

}  // namespace

TradeSetting without_idle_values(TradeSetting setting) {
  if (reads_heatmaps(setting.kind)) return setting;
  TradeSetting plain;
  plain.kind = setting.kind;
  plain.rendering.history = setting.rendering.history;
  plain.rendering.tick = setting.rendering.tick;
  plain.rendering.mask = setting.rendering.mask;
  plain.confirmation = setting.confirmation;
  plain.alarm_cost = setting.alarm_cost;
  plain.gate = setting.gate;
  return plain;
}

std::string joined_text_of(const model::Augmentation& augmentation) {
  std::string text = text_of(augmentation);
  std::replace(text.begin(), text.end(), ',', '+');
  return text;
}

model::Augmentation joined_augmentation_named(std::string text) {
  const std::string given = text;
  std::replace(text.begin(), text.end(), '+', ',');
  try {
    return model::augmentation_named(text);
  } catch (const Error& error) {
    throw Error(given == text ? error.what() : fmt::format("augmentation '{}', joined by +: {}", given, error.what()));
  }
}

results::SettingValues values_of(const TradeSetting& setting) {
  const nlohmann::json rendering = setting.rendering;
  return {.kind = std::string(name_of(setting.kind)),
          .th_ms = in_ms(setting.rendering.history),
          .tick_ms = in_ms(setting.rendering.tick),
          .factor = setting.rendering.factor,
          .resize = rendering.at("resize"),
          .denoise = rendering.at("denoise"),
          .width = setting.width,
          .last_pool = setting.last_pool,
          .engine = std::string(name_of(setting.engine)),
          .precision = std::string(name_of(setting.precision)),
          .pass = setting.sparse ? "sparse" : "dense",
          .confirm = text_of(setting.confirmation),
          .filter = setting.alarm_cost ? fmt::format("{:g}", *setting.alarm_cost) : "off",
          .gate = setting.gate,
          .augment = joined_text_of(setting.augmentation)};
}

void to_json(nlohmann::json& json, const TradeSetting& setting) { json = values_of(setting); }

std::string id_of(const TradeSetting& setting) {
  std::vector<std::string> parts;
  for (const SettingWords& words : words_of(setting)) {
    if (!words.id.empty()) parts.push_back(words.id);
  }
  if (setting.width != TradeSetting{}.width) parts.push_back(fmt::format("w{:g}", setting.width));
  if (setting.last_pool != TradeSetting{}.last_pool) parts.push_back(fmt::format("p{}", setting.last_pool));
  if (setting.augmentation != model::Augmentation{}) {
    // The id is a part of file names.
    const std::string text = joined_text_of(setting.augmentation);
    parts.push_back(setting.augmentation.stress.empty() ? text : "augment-" + hash_of(text).substr(0, 8));
  }
  if (setting.alarm_cost) parts.push_back(fmt::format("filter{:g}", *setting.alarm_cost));
  if (setting.kind != TradeSetting{}.kind) parts.emplace_back(name_of(setting.kind));
  return fmt::format("{}", fmt::join(parts, "-"));
}

std::string text_of(const TradeSetting& setting, const TradeSetting& base) {
  const nlohmann::json values = setting, usual = base;
  std::vector<std::string> differences;
  for (const SettingWords& words : words_of(setting)) {
    if (values.at(words.key) != usual.at(words.key)) differences.push_back(words.text);
  }
  return differences.empty() ? "as usual" : fmt::format("{}", fmt::join(differences, ", "));
}

model::Decision decision_of(const TradeSetting& setting, const model::ModelBundle& bundle) {
  model::Decision decision{.confirmation = setting.confirmation};
  if (setting.alarm_cost) decision.filter = model::filter_of(bundle, model::read_description(bundle), *setting.alarm_cost);
  return decision;
}

std::optional<std::string> why_impossible(const TradeSetting& setting) {
  const heatmaps::HeatmapOptions& rendering = setting.rendering;
  if (rendering.history % rendering.tick != microseconds{0})
    return fmt::format("t_h {:g} ms is no whole number of ticks of {:g} ms", in_ms(rendering.history), in_ms(rendering.tick));
  if (setting.engine == model::EngineKind::libtorch && (setting.precision != model::Precision::fp32 || !setting.sparse))
    return "libtorch computes all, in fp32";
  if (!(setting == without_idle_values(setting)))
    return fmt::format("a model of kind {} reads no heatmaps, and has one engine and precision", name_of(setting.kind));
  if (setting.alarm_cost && setting.confirmation.of > 1) return "the filter replaces the confirmation";
  return std::nullopt;
}

}  // namespace tactile::trade
