#include "tactile/report/reported_trade.hpp"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/results/json_view.hpp"

namespace tactile::report {
namespace {

ReportedSetting setting_in(const results::JsonView& json) {
  const results::JsonView reported = json["reported"], difference = json["difference"], delay = reported["delay_us"],
                          probability = json["front"]["probability"], choice = json["choice"];
  const std::string kind = json["setting"]["kind"].text();
  return {.text = json["text"].text(),
          .design = json["design"].text(),
          .kind = kind.empty() ? "lenet" : kind,
          .choice_accuracy = choice["accuracy"].get<results::Figure>(),
          .choice_us_p99 = choice["us"]["p99"].get<results::Figure>(),
          .trainings = json["trainings"].count(),
          .accuracy = reported["accuracy"].get<results::Figure>(),
          .us_p50 = reported["us"]["p50"].get<results::Figure>(),
          .us_p99 = reported["us"]["p99"].get<results::Figure>(),
          .us_p999 = reported["us"]["p999"].get<results::Figure>(),
          .delay_us = delay["median"].get<results::Figure>(),
          .delay_p90_us = delay["p90"].get<results::Figure>(),
          .missed = delay["missed"].get<results::Figure>(),
          .episodes_per_min = reported["episodes_per_min"].get<results::Figure>(),
          .accuracy_difference = difference ? difference["accuracy"].get<results::Figure>() : results::Figure{},
          .delay_difference_us = difference ? difference["delay_us"].get<results::Figure>() : results::Figure{},
          .episodes_difference = difference ? difference["episodes_per_min"].get<results::Figure>() : results::Figure{},
          .on_accuracy_front = json["front"]["accuracy"].truth(),
          .on_delay_front = json["front"]["delay"].truth(),
          .accuracy_front_probability = probability["accuracy"].number(),
          .delay_front_probability = probability["delay"].number()};
}

}  // namespace

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
                      .settings = {},
                      .left_out = {},
                      .growth = json["growth"].get<results::CostGrowth>(),
                      .sentence = json["recommendation"]["sentence"].text()};
  for (const results::JsonView& point : json["points"].items()) trade.settings.push_back(setting_in(point));
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
