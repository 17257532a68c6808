#include "tactile/trade/trade_setting.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <vector>

namespace tactile {
namespace {

double in_ms(microseconds us) { return static_cast<double>(us.count()) / 1000; }

std::string word_of(const HeatmapOptions& rendering, const char* key) { return nlohmann::json(rendering).at(key); }

}  // namespace

void to_json(nlohmann::json& json, const TradeSetting& setting) {
  json = {{"th_ms", in_ms(setting.rendering.history)},
          {"tick_ms", in_ms(setting.rendering.tick)},
          {"factor", setting.rendering.factor},
          {"resize", word_of(setting.rendering, "resize")},
          {"denoise", word_of(setting.rendering, "denoise")},
          {"engine", name_of(setting.engine)},
          {"precision", name_of(setting.precision)},
          {"pass", setting.sparse ? "sparse" : "dense"},
          {"confirm", text_of(setting.confirmation)},
          {"gate", setting.gate}};
}

std::string id_of(const TradeSetting& setting) {
  const HeatmapOptions& rendering = setting.rendering;
  return fmt::format("th{:g}-tick{:g}-f{:.6g}-{}-{}-{}-{}-{}-{}of{}-{}", in_ms(rendering.history), in_ms(rendering.tick),
                     rendering.factor, word_of(rendering, "resize"), word_of(rendering, "denoise"), name_of(setting.engine),
                     name_of(setting.precision), setting.sparse ? "sparse" : "dense", setting.confirmation.needed,
                     setting.confirmation.of, setting.gate ? "gate" : "open");
}

std::string text_of(const TradeSetting& setting, const TradeSetting& base) {
  const HeatmapOptions &rendering = setting.rendering, &usual = base.rendering;
  std::vector<std::string> words;
  if (rendering.history != usual.history) words.push_back(fmt::format("t_h {:g} ms", in_ms(rendering.history)));
  if (rendering.tick != usual.tick) words.push_back(fmt::format("tick {:g} ms", in_ms(rendering.tick)));
  if (rendering.factor != usual.factor) words.push_back(fmt::format("factor {:g}", rendering.factor));
  if (rendering.resize != usual.resize) words.push_back("resize " + word_of(rendering, "resize"));
  if (rendering.denoise != usual.denoise) words.push_back("denoise " + word_of(rendering, "denoise"));
  if (setting.engine != base.engine) words.push_back(fmt::format("engine {}", name_of(setting.engine)));
  if (setting.precision != base.precision) words.push_back(fmt::format("{}", name_of(setting.precision)));
  if (setting.sparse != base.sparse) words.emplace_back(setting.sparse ? "sparse" : "dense");
  if (setting.confirmation != base.confirmation) words.push_back("confirm " + text_of(setting.confirmation));
  if (setting.gate != base.gate) words.emplace_back(setting.gate ? "gate" : "no gate");
  return words.empty() ? "as usual" : fmt::format("{}", fmt::join(words, ", "));
}

std::optional<std::string> why_impossible(const TradeSetting& setting) {
  const HeatmapOptions& rendering = setting.rendering;
  if (rendering.history % rendering.tick != microseconds{0})
    return fmt::format("t_h {:g} ms is no whole number of ticks of {:g} ms", in_ms(rendering.history), in_ms(rendering.tick));
  if (setting.engine == EngineKind::libtorch && (setting.precision != Precision::fp32 || !setting.sparse))
    return "libtorch computes all, in fp32";
  return std::nullopt;
}

}  // namespace tactile
