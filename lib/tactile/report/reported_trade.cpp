#include "tactile/report/reported_trade.hpp"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/results/json_view.hpp"

namespace tactile::report {
namespace {

ReportedSetting setting_in(const results::JsonView& json) {
  const results::JsonView reported = json["reported"], difference = json["difference"];
  return {.text = json["text"].text(),
          .design = json["design"].text(),
          .seeds = json["seeds"].count(),
          .accuracy = reported["accuracy"].get<results::Figure>(),
          .us_p50 = reported["us"]["p50"].get<results::Figure>(),
          .us_p99 = reported["us"]["p99"].get<results::Figure>(),
          .delay_us = reported["delay_us"]["mean"].get<results::Figure>(),
          .delay_p95_us = reported["delay_us"]["p95"].get<results::Figure>(),
          .missed = reported["delay_us"]["missed"].get<results::Figure>(),
          .false_alarms_per_min = reported["false_alarms_per_min"].get<results::Figure>(),
          .accuracy_difference = difference ? difference["accuracy"].get<results::Figure>() : results::Figure{},
          .delay_difference_us = difference ? difference["delay_us"].get<results::Figure>() : results::Figure{},
          .false_alarms_difference = difference ? difference["false_alarms_per_min"].get<results::Figure>() : results::Figure{},
          .on_accuracy_front = json["front"]["accuracy"].truth(),
          .on_delay_front = json["front"]["delay"].truth()};
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
                      .machine = json["machine"]["cpu"].text(),
                      .simulated = json["simulated"].truth(),
                      .choice_runs = json["runs"]["choice"].texts(),
                      .reported_runs = json["runs"]["reported"].texts(),
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
