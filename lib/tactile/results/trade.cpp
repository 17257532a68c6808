#include "tactile/results/trade.hpp"

#include <fmt/core.h>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"

namespace tactile::results {

void to_json(nlohmann::json& json, const UntriedPair& pair) {
  json = {{"th_ms", in_ms(pair.history)}, {"tick_ms", in_ms(pair.tick)}, {"why", pair.why}};
}

void from_json(const JsonView& json, UntriedPair& pair) {
  pair = {.history = json["th_ms"].milliseconds(), .tick = json["tick_ms"].milliseconds(), .why = json["why"].text()};
}

void to_json(nlohmann::json& json, const NotMeasured& one) { json = {{"setting", one.setting}, {"why", one.why}}; }

void from_json(const JsonView& json, NotMeasured& one) { one = {json["setting"].text(), json["why"].text()}; }

void to_json(nlohmann::json& json, const TradeRuns& runs) {
  json = {{"train", runs.train}, {"choice", runs.choice}, {"reported", runs.reported}};
}

void from_json(const JsonView& json, TradeRuns& runs) {
  runs = {.train = json["train"].texts(), .choice = json["choice"].texts(), .reported = json["reported"].texts()};
}

void to_json(nlohmann::json& json, const TradeDataset& dataset) {
  json = {{"file", dataset.file},
          {"manifest_hash", dataset.manifest_hash},
          {"settings", dataset.settings},
          {"samples", dataset.samples}};
}

void from_json(const JsonView& json, TradeDataset& dataset) {
  dataset = {.file = json["file"].text(),
             .manifest_hash = json["manifest_hash"].text(),
             .settings = json["settings"].copy(),
             .samples = json["samples"].count()};
}

void to_json(nlohmann::json& json, const MeasuredAgain& again) {
  json = again.result;
  json["model"] = again.model;
  json["trainings"] = again.trainings;
  json["runs"] = again.runs;
}

void from_json(const JsonView& json, MeasuredAgain& again) {
  again = {.result = json.get<TradeResult>(),
           .model = json["model"].text(),
           .trainings = json["trainings"].count(),
           .runs = json["runs"].texts()};
}

void to_json(nlohmann::json& json, const TradeRecommendation& recommendation) {
  json = {{"wish", recommendation.wish},
          {"id", text_or_null(recommendation.id)},
          {"setting", json_or_null(recommendation.setting)},
          {"met", recommendation.met},
          {"chosen_in_interval", json_or_null(recommendation.chosen_in_interval)},
          {"again", json_or_null(recommendation.again)},
          {"trial", recommendation.trial},
          {"sentence", recommendation.sentence}};
  if (recommendation.setting) json["model"] = recommendation.model;
}

void from_json(const JsonView& json, TradeRecommendation& recommendation) {
  const JsonView in_interval = json["chosen_in_interval"];
  recommendation = {.wish = json["wish"].copy(),
                    .id = json["id"].text(),
                    .setting = json["setting"].if_there<SettingValues>(),
                    .model = json["model"].text(),
                    .met = json["met"].truth(),
                    .chosen_in_interval = in_interval ? std::optional(in_interval.truth()) : std::nullopt,
                    .again = json["again"].if_there<MeasuredAgain>(),
                    .trial = json["trial"].copy(),
                    .sentence = json["sentence"].text()};
}

std::string Trade::cpu() const { return JsonView(machine, "machine")["cpu"].text(); }

void to_json(nlohmann::json& json, const Trade& trade) {
  nlohmann::json runs = trade.runs.empty() ? nlohmann::json::object() : nlohmann::json(trade.runs.front());
  runs["trainings"] = trade.runs;
  json = {{"format", trade_format},
          {"title", trade.title},
          {"simulated", trade.simulated},
          {"times_are", trade.times_are},
          {"judged_by", trade.judged_by},
          {"settings", trade.settings},
          {"software", trade.software},
          {"machine", trade.machine},
          {"bootstrap", trade.bootstrap},
          {"dataset", trade.dataset},
          {"runs", runs},
          {"usual", trade.usual},
          {"usual_is", trade.usual_is},
          {"interrupted", trade.interrupted},
          {"busy", trade.busy},
          {"points", trade.points},
          {"left_out", trade.left_out},
          {"not_measured", trade.not_measured},
          {"unfinished", text_or_null(trade.unfinished)},
          {"growth", json_or_null(trade.growth)},
          {"recommendation", trade.recommendation},
          {"steps", trade.steps}};
}

void from_json(const JsonView& json, Trade& trade) {
  if (json["format"].text() != trade_format)
    throw Error(
        fmt::format("{} is another one; expected {}, as 'tactile trade' writes it", json["format"].where(), trade_format));
  trade = {.title = json["title"].text(),
           .simulated = json["simulated"].truth(),
           .times_are = json["times_are"].text(),
           .judged_by = json["judged_by"].text(),
           .settings = json["settings"].copy(),
           .software = json["software"].copy(),
           .machine = json["machine"].copy(),
           .bootstrap = json["bootstrap"].get<BootstrapOptions>(),
           .dataset = json["dataset"].get<TradeDataset>(),
           .runs = json["runs"]["trainings"].list_of<TradeRuns>(),
           .usual = json["usual"].text(),
           .usual_is = json["usual_is"].text(),
           .interrupted = json["interrupted"].number_if_there().value_or(0),
           .busy = json["busy"].count(),
           .points = json["points"].list_of<TradedSetting>(),
           .left_out = json["left_out"].list_of<UntriedPair>(),
           .not_measured = json["not_measured"].list_of<NotMeasured>(),
           .unfinished = json["unfinished"].text(),
           .growth = json["growth"].if_there<CostGrowth>(),
           .recommendation = json["recommendation"].get<TradeRecommendation>(),
           .steps = json["steps"].list_of<StepRecord>()};
}

}  // namespace tactile::results
