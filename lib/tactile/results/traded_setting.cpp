#include "tactile/results/traded_setting.hpp"

namespace tactile::results {

void to_json(nlohmann::json& json, const TradeResult& result) {
  const TradeFigures& figures = result.figures;
  json = {{"accuracy", figures.accuracy},
          {"delay_us",
           {{"median", figures.delay_median_us},
            {"p90", figures.delay_p90_us},
            {"median_is_bound", figures.median_is_bound},
            {"p90_is_bound", figures.p90_is_bound},
            {"mean", result.delay_mean_us},
            {"missed", figures.missed},
            {"intervals", result.intervals},
            {"misses", result.misses},
            {"early", result.early}}},
          {"episodes_per_min", figures.episodes_per_min},
          {"episodes", result.episodes},
          {"us",
           {{"p50", figures.us_p50},
            {"p99", figures.us_p99},
            {"p999", figures.us_p999},
            {"ticks", result.ticks},
            {"interrupted", figures.interrupted}}}};
}

void from_json(const JsonView& json, TradeResult& result) {
  const JsonView delay = json["delay_us"], us = json["us"];
  result = {.figures = {.accuracy = json["accuracy"].get<Figure>(),
                        .us_p50 = us["p50"].get<Figure>(),
                        .us_p99 = us["p99"].get<Figure>(),
                        .us_p999 = us["p999"].get<Figure>(),
                        .delay_median_us = delay["median"].get<Figure>(),
                        .delay_p90_us = delay["p90"].get<Figure>(),
                        .median_is_bound = delay["median_is_bound"].truth(),
                        .p90_is_bound = delay["p90_is_bound"].truth(),
                        .missed = delay["missed"].get<Figure>(),
                        .episodes_per_min = json["episodes_per_min"].get<Figure>(),
                        .interrupted = us["interrupted"].number_if_there().value_or(0)},
            .delay_mean_us = delay["mean"].get<Figure>(),
            .intervals = delay["intervals"].count(),
            .misses = delay["misses"].count(),
            .early = delay["early"].count(),
            .episodes = json["episodes"].count(),
            .ticks = us["ticks"].count()};
}

void to_json(nlohmann::json& json, const TradeDifference& difference) {
  json = {{"accuracy", difference.accuracy},
          {"delay_us", difference.delay_us},
          {"missed", difference.missed},
          {"episodes_per_min", difference.episodes_per_min},
          {"us", {{"p50", difference.us_p50}, {"p99", difference.us_p99}}}};
}

void from_json(const JsonView& json, TradeDifference& difference) {
  const JsonView us = json["us"];
  difference = {.accuracy = json["accuracy"].get<Figure>(),
                .delay_us = json["delay_us"].get<Figure>(),
                .missed = json["missed"].get<Figure>(),
                .episodes_per_min = json["episodes_per_min"].get<Figure>(),
                .us_p50 = us["p50"].get<Figure>(),
                .us_p99 = us["p99"].get<Figure>()};
}

void to_json(nlohmann::json& json, const SettingValues& values) {
  json = {{"kind", values.kind},     {"th_ms", values.th_ms},     {"tick_ms", values.tick_ms}, {"factor", values.factor},
          {"resize", values.resize}, {"denoise", values.denoise}, {"engine", values.engine},   {"precision", values.precision},
          {"pass", values.pass},     {"confirm", values.confirm}, {"augment", values.augment}};
}

void from_json(const JsonView& json, SettingValues& values) {
  const auto or_usual = [](const std::string& text, const std::string& usual) { return text.empty() ? usual : text; };
  const SettingValues usual;
  values = {.kind = or_usual(json["kind"].text(), usual.kind),
            .th_ms = json["th_ms"].number(),
            .tick_ms = json["tick_ms"].number(),
            .factor = json["factor"].number(),
            .resize = json["resize"].text(),
            .denoise = json["denoise"].text(),
            .engine = json["engine"].text(),
            .precision = json["precision"].text(),
            .pass = json["pass"].text(),
            .confirm = json["confirm"].text(),
            .augment = or_usual(json["augment"].text(), usual.augment)};
}

void to_json(nlohmann::json& json, const TradedSetting& setting) {
  const FrontProbability& probability = setting.front_probability;
  json = {{"id", setting.id},
          {"text", setting.text},
          {"design", setting.design},
          {"setting", setting.values},
          {"models", setting.models},
          {"trainings", setting.trainings},
          {"choice", setting.choice},
          {"reported", setting.reported},
          {"difference", json_or_null(setting.difference)},
          {"front",
           {{"accuracy", setting.on_accuracy_front},
            {"delay", setting.on_delay_front},
            {"probability", {{"accuracy", json_or_null(probability.accuracy)}, {"delay", json_or_null(probability.delay)}}}}}};
}

void from_json(const JsonView& json, TradedSetting& setting) {
  const JsonView front = json["front"], probability = front["probability"];
  setting = {.id = json["id"].text(),
             .text = json["text"].text(),
             .design = json["design"].text(),
             .values = json["setting"].get<SettingValues>(),
             .models = json["models"].texts(),
             .trainings = json["trainings"].count(),
             .choice = json["choice"].get<TradeResult>(),
             .reported = json["reported"].get<TradeResult>(),
             .difference = json["difference"].if_there<TradeDifference>(),
             .on_accuracy_front = front["accuracy"].truth(),
             .on_delay_front = front["delay"].truth(),
             .front_probability = {.accuracy = probability["accuracy"].number_if_there(),
                                   .delay = probability["delay"].number_if_there()}};
}

}  // namespace tactile::results
