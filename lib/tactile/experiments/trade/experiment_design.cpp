#include "tactile/experiments/trade/experiment_design.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tactile/experiments/trade/pareto_front.hpp"

namespace tactile::trade {
namespace {

/// @param set  puts a value into a setting; its text is then that of the setting's JSON
template <class T, class Set>
TradeFactor factor_of(const std::string& name, const std::vector<T>& values, Set set) {
  TradeFactor factor{name, {}};
  for (const auto& value : values) {
    TradeSetting setting;
    set(setting, value);
    const nlohmann::json json = nlohmann::json(setting).at(name);
    const std::string text = json.is_string()    ? json.get<std::string>()
                             : json.is_boolean() ? std::string(json.get<bool>() ? "on" : "off")
                                                 : fmt::format("{:g}", json.get<double>());
    factor.levels.push_back({text, [value, set](TradeSetting& changed) { set(changed, value); }});
  }
  return factor;
}

void for_all_combinations(const std::vector<TradeFactor>& factors,
                          const std::function<void(const std::vector<std::size_t>&)>& use) {
  std::vector<std::size_t> levels(factors.size(), 0);
  if (std::any_of(factors.begin(), factors.end(), [](const TradeFactor& factor) { return factor.levels.empty(); })) return;
  for (;;) {
    use(levels);
    std::size_t i = factors.size();
    while (i > 0 && ++levels[i - 1] == factors[i - 1].levels.size()) levels[--i] = 0;
    if (i == 0) return;
  }
}

/// At most `most` of them, evenly spread, with both ends.
std::vector<std::size_t> thinned(const std::vector<std::size_t>& indexes, std::size_t most) {
  if (indexes.size() <= most) return indexes;
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < most; ++i) kept.push_back(indexes[most == 1 ? 0 : i * (indexes.size() - 1) / (most - 1)]);
  return kept;
}

}  // namespace

std::vector<TradeFactor> factors_of(const TradeLevels& levels) {
  return {
      factor_of("kind", levels.kinds,
                [](TradeSetting& s, model::ModelKind kind) {
                  s.kind = kind;
                  s = without_idle_values(s);
                }),
      factor_of("tick_ms", levels.ticks,
                [](TradeSetting& s, microseconds tick) {
                  s.rendering.tick = tick;
                  s = without_idle_values(s);
                }),
      factor_of("precision", levels.precisions, [](TradeSetting& s, model::Precision precision) { s.precision = precision; }),
      factor_of("engine", levels.engines, [](TradeSetting& s, model::EngineKind engine) { s.engine = engine; }),
      factor_of("th_ms", levels.histories, [](TradeSetting& s, microseconds history) { s.rendering.history = history; }),
      factor_of("factor", levels.factors, [](TradeSetting& s, double factor) { s.rendering.factor = factor; }),
      factor_of("resize", levels.resizes, [](TradeSetting& s, heatmaps::Resize resize) { s.rendering.resize = resize; }),
      factor_of("denoise", levels.denoises, [](TradeSetting& s, heatmaps::Denoise denoise) { s.rendering.denoise = denoise; }),
      factor_of("augment", levels.augmentations, [](TradeSetting& s, const model::Augmentation& a) { s.augmentation = a; })};
}

std::vector<LeftOutPair> left_out_pairs(const TradeLevels& levels) {
  std::vector<LeftOutPair> pairs;
  for (const microseconds history : levels.histories) {
    for (const microseconds tick : levels.ticks) {
      if (history % tick != microseconds{0}) pairs.push_back({history, tick});
    }
  }
  return pairs;
}

std::vector<TradeSetting> one_at_a_time(const TradeSetting& usual, const TradeLevels& levels) {
  std::vector<TradeSetting> settings{usual};
  for (const TradeFactor& factor : factors_of(levels)) {
    for (const TradeLevel& level : factor.levels) {
      TradeSetting setting = usual;
      level.set(setting);
      if (setting == usual || why_impossible(setting)) continue;
      if (std::find(settings.begin(), settings.end(), setting) == settings.end()) settings.push_back(setting);
    }
  }
  return settings;
}

std::vector<TradeSetting> all_combinations(const TradeSetting& usual, const TradeLevels& levels) {
  const std::vector<TradeFactor> factors = factors_of(levels);
  std::vector<TradeSetting> settings;
  std::set<std::string> known;
  for_all_combinations(factors, [&](const std::vector<std::size_t>& chosen) {
    TradeSetting setting = usual;
    for (std::size_t i = 0; i < factors.size(); ++i) factors[i].levels[chosen[i]].set(setting);
    setting = without_idle_values(setting);
    // Many combinations are one setting of a kind without heatmaps.
    const bool is_known = !reads_heatmaps(setting.kind) && !known.insert(id_of(setting)).second;
    if (!is_known && !why_impossible(setting)) settings.push_back(setting);
  });
  return settings;
}

std::vector<TradeSetting> promising_corners(const TradeSetting& usual, const TradeLevels& levels,
                                            const std::map<std::string, TradeOutcome>& measured, std::size_t most) {
  constexpr double some_alarms = 3;  // per minute: ratios of very few alarms are chance
  const auto of_usual = measured.find(id_of(usual));
  if (of_usual == measured.end()) return {};
  const TradeOutcome base = of_usual->second;
  // Of each parameter the usual value, and those whose effect is known.
  std::vector<TradeFactor> factors;
  std::vector<std::vector<TradeOutcome>> alone;
  for (const TradeFactor& factor : factors_of(levels)) {
    TradeFactor known{factor.name, {{"", [](TradeSetting&) {}}}};
    std::vector<TradeOutcome> outcomes{base};
    for (const TradeLevel& level : factor.levels) {
      TradeSetting setting = usual;
      level.set(setting);
      const auto found = measured.find(id_of(setting));
      if (setting == usual || found == measured.end()) continue;
      known.levels.push_back(level);
      outcomes.push_back(found->second);
    }
    factors.push_back(std::move(known));
    alone.push_back(std::move(outcomes));
  }
  std::vector<TradeSetting> settings;
  std::vector<std::size_t> off_default;
  std::vector<TradePlace> by_accuracy, by_delay;
  for_all_combinations(factors, [&](const std::vector<std::size_t>& chosen) {
    TradeSetting setting = usual;
    TradeOutcome expected = base;
    double alarms = base.alarms_per_min + some_alarms;
    std::size_t changed = 0;
    for (std::size_t i = 0; i < factors.size(); ++i) {
      if (chosen[i] == 0) continue;
      factors[i].levels[chosen[i]].set(setting);
      const TradeOutcome& other = alone[i][chosen[i]];
      expected.accuracy += other.accuracy - base.accuracy;
      expected.delay_ms += other.delay_ms - base.delay_ms;
      expected.missed += other.missed - base.missed;
      expected.us *= other.us / base.us;
      alarms *= (other.alarms_per_min + some_alarms) / (base.alarms_per_min + some_alarms);
      ++changed;
    }
    if (why_impossible(setting)) return;
    settings.push_back(setting);
    off_default.push_back(changed);
    by_accuracy.push_back({expected.us, -std::min(expected.accuracy, 1.0), 0});
    by_delay.push_back({alarms - some_alarms, expected.delay_ms, std::max(expected.missed, 0.0)});
  });
  std::vector<TradeSetting> corners;
  for (const auto* places : {&by_accuracy, &by_delay}) {
    std::vector<std::size_t> front = pareto_front(*places);
    std::erase_if(front, [&](std::size_t i) { return off_default[i] < 2; });
    for (const std::size_t i : thinned(front, most)) {
      if (std::find(corners.begin(), corners.end(), settings[i]) == corners.end()) corners.push_back(settings[i]);
    }
  }
  return corners;
}

}  // namespace tactile::trade
