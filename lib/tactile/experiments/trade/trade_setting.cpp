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
  bool of_every_kind = false;  ///< else only LeNet has it
};

std::vector<SettingWords> words_of(const TradeSetting& setting) {
  const results::SettingValues values = values_of(setting);
  return {{"kind", "", setting.kind == model::ModelKind::lenet ? "LeNet" : values.kind, true},
          {"th_ms", fmt::format("th{:g}", values.th_ms), fmt::format("t_h {:g} ms", values.th_ms)},
          {"tick_ms", fmt::format("tick{:g}", values.tick_ms), fmt::format("tick {:g} ms", values.tick_ms), true},
          {"factor", fmt::format("f{:.6g}", values.factor), fmt::format("factor {:g}", values.factor)},
          {"resize", values.resize, "resize " + values.resize},
          {"denoise", values.denoise, "denoise " + values.denoise},
          {"augment", "", values.augment == "none" ? "no augmentation" : "augment " + values.augment},
          {"engine", values.engine, "engine " + values.engine},
          {"precision", values.precision, values.precision}};
}

}  // namespace

TradeSetting without_idle_values(TradeSetting setting) {
  if (reads_heatmaps(setting.kind)) return setting;
  TradeSetting plain;
  plain.kind = setting.kind;
  plain.rendering.history = plain.rendering.tick = setting.rendering.tick;
  plain.rendering.mask = setting.rendering.mask;
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
          .engine = std::string(name_of(setting.engine)),
          .precision = std::string(name_of(setting.precision)),
          .augment = joined_text_of(setting.augmentation)};
}

void to_json(nlohmann::json& json, const TradeSetting& setting) { json = values_of(setting); }

std::string id_of(const TradeSetting& setting) {
  std::vector<std::string> parts;
  for (const SettingWords& words : words_of(setting)) {
    if (!words.id.empty()) parts.push_back(words.id);
  }
  if (setting.augmentation != model::Augmentation{}) {
    // The id is a part of file names.
    const std::string text = joined_text_of(setting.augmentation);
    parts.push_back(setting.augmentation.stress.empty() ? text : "augment-" + hash_of(text).substr(0, 8));
  }
  if (setting.kind != TradeSetting{}.kind) parts.emplace_back(name_of(setting.kind));
  return fmt::format("{}", fmt::join(parts, "-"));
}

std::string text_of(const TradeSetting& setting, const TradeSetting& base) {
  const nlohmann::json values = setting, usual = base;
  std::vector<std::string> differences;
  for (const SettingWords& words : words_of(setting)) {
    const bool has_it = words.of_every_kind || reads_heatmaps(setting.kind);
    if (has_it && values.at(words.key) != usual.at(words.key)) differences.push_back(words.text);
  }
  return differences.empty() ? "as usual" : fmt::format("{}", fmt::join(differences, ", "));
}

std::optional<std::string> why_impossible(const TradeSetting& setting) {
  const heatmaps::HeatmapOptions& rendering = setting.rendering;
  if (rendering.history % rendering.tick != microseconds{0})
    return fmt::format("t_h {:g} ms is no whole number of ticks of {:g} ms", in_ms(rendering.history), in_ms(rendering.tick));
  if (setting.engine == model::EngineKind::libtorch && setting.precision != model::Precision::fp32)
    return "libtorch computes in fp32";
  if (!(setting == without_idle_values(setting)))
    return fmt::format("a model of kind {} reads no heatmaps, and has one history, engine and precision", name_of(setting.kind));
  return std::nullopt;
}

}  // namespace tactile::trade
