#include "tactile/report/reported_trade.hpp"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/results/json_view.hpp"

namespace tactile::report {

ReportedTrade read_trade(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "trade.json";
  const auto document = nlohmann::json::parse(read_text(file), nullptr, false);
  if (document.is_discarded()) throw Error(file.string() + ": no JSON; expected what 'tactile trade' wrote");
  const results::JsonView json(document, file.string());
  if (json["format"].text() != "tactile-trade-1")
    throw Error(file.string() + ": another format; expected tactile-trade-1, as 'tactile trade' writes it");
  ReportedTrade trade{.title = json["title"].text(),
                      .times_are = json["times_are"].text(),
                      .judged_by = json["judged_by"].text(),
                      .usual_is = json["usual_is"].text(),
                      .machine = json["machine"]["cpu"].text(),
                      .simulated = json["simulated"].truth(),
                      .settings = json["points"].list_of<results::TradedSetting>(),
                      .left_out = {},
                      .growth = json["growth"].get<results::CostGrowth>(),
                      .sentence = json["recommendation"]["sentence"].text()};
  for (const results::JsonView& pair : json["left_out"].items()) {
    trade.left_out.push_back(fmt::format("t_h {:g} ms with a tick of {:g} ms: {}", pair["th_ms"].number(),
                                         pair["tick_ms"].number(), pair["why"].text()));
  }
  for (const results::JsonView& one : json["not_measured"].items())
    trade.left_out.push_back(fmt::format("{}: {}", one["setting"].text(), one["why"].text()));
  if (const results::JsonView unfinished = json["unfinished"]) trade.left_out.push_back(unfinished.text());
  return trade;
}

}  // namespace tactile::report
