#include "tactile/experiments/trade/trade_setting.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <vector>

#include "tactile/core/duration_units.hpp"

namespace tactile::trade {
namespace {

/// One value of a setting, in the form of each output.
struct SettingValue {
  const char* key;
  nlohmann::json value;
  std::string id, text;
};

std::string kind_text(model::ModelKind kind) {
  return kind == model::ModelKind::lenet ? "LeNet" : kind == model::ModelKind::trees ? "trees" : "temporal convolution";
}

std::vector<SettingValue> values_of(const TradeSetting& setting) {
  const double th_ms = in_ms(setting.rendering.history), tick_ms = in_ms(setting.rendering.tick);
  const double factor = setting.rendering.factor;
  const nlohmann::json rendering = setting.rendering;
  const std::string resize = rendering.at("resize"), denoise = rendering.at("denoise");
  const std::string engine(name_of(setting.engine)), precision(name_of(setting.precision));
  const std::string pass = setting.sparse ? "sparse" : "dense", confirm = text_of(setting.confirmation);
  const std::string filter = setting.alarm_cost ? fmt::format("{:g}", *setting.alarm_cost) : "off";
  const std::string kind(name_of(setting.kind));
  return {{"kind", kind, "", kind_text(setting.kind)},
          {"th_ms", th_ms, fmt::format("th{:g}", th_ms), fmt::format("t_h {:g} ms", th_ms)},
          {"tick_ms", tick_ms, fmt::format("tick{:g}", tick_ms), fmt::format("tick {:g} ms", tick_ms)},
          {"factor", factor, fmt::format("f{:.6g}", factor), fmt::format("factor {:g}", factor)},
          {"resize", resize, resize, "resize " + resize},
          {"denoise", denoise, denoise, "denoise " + denoise},
          {"width", setting.width, "", fmt::format("width {:g}", setting.width)},
          {"last_pool", setting.last_pool, "", fmt::format("last pooling {0} x {0}", setting.last_pool)},
          {"engine", engine, engine, "engine " + engine},
          {"precision", precision, precision, precision},
          {"pass", pass, pass, pass},
          {"confirm", confirm, fmt::format("{}of{}", setting.confirmation.needed, setting.confirmation.of), "confirm " + confirm},
          {"filter", filter, "", setting.alarm_cost ? "filter " + filter : "no filter"},
          {"gate", setting.gate, setting.gate ? "gate" : "open", setting.gate ? "gate" : "no gate"}};
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

void to_json(nlohmann::json& json, const TradeSetting& setting) {
  json = nlohmann::json::object();
  for (const SettingValue& value : values_of(setting)) json[value.key] = value.value;
}

std::string id_of(const TradeSetting& setting) {
  std::vector<std::string> parts;
  for (const SettingValue& value : values_of(setting)) {
    if (!value.id.empty()) parts.push_back(value.id);
  }
  if (setting.width != TradeSetting{}.width) parts.push_back(fmt::format("w{:g}", setting.width));
  if (setting.last_pool != TradeSetting{}.last_pool) parts.push_back(fmt::format("p{}", setting.last_pool));
  if (setting.alarm_cost) parts.push_back(fmt::format("filter{:g}", *setting.alarm_cost));
  if (setting.kind != TradeSetting{}.kind) parts.emplace_back(name_of(setting.kind));
  return fmt::format("{}", fmt::join(parts, "-"));
}

std::string text_of(const TradeSetting& setting, const TradeSetting& base) {
  const std::vector<SettingValue> values = values_of(setting), usual = values_of(base);
  std::vector<std::string> words;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i].value != usual[i].value) words.push_back(values[i].text);
  }
  return words.empty() ? "as usual" : fmt::format("{}", fmt::join(words, ", "));
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
