#include "tactile/experiments/trade/trade_results.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "tactile/core/csv_table.hpp"
#include "tactile/core/json_text.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/experiments/experiment_json.hpp"
#include "tactile/experiments/milliseconds.hpp"
#include "tactile/experiments/run_division.hpp"
#include "tactile/experiments/trade/usual_judgement.hpp"
#include "tactile/windows/dataset_settings.hpp"

namespace tactile::trade {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Which trainings judge which runs, in words.
std::string judged_by(const TradePlan& plan) {
  const std::size_t trainings = plan.trainings.size();
  if (trainings == 1) {
    const experiments::RunDivision& runs = plan.trainings.front().runs;
    return fmt::format("One training learns from {} runs. Settings are chosen on {} others and reported on {} others.",
                       runs.train.size(), runs.choice.size(), runs.reported.size());
  }
  return fmt::format(
      "Up to {} trainings of each setting, each with another seed and other runs to learn from, to choose on and to report on. "
      "No "
      "network is judged on a run that it learned from or was chosen on; another network may have been.",
      trainings);
}

json point_json(const TradePoint& point, const TradeSetting& usual) {
  json entry = results::TradedSetting{.text = text_of(point.setting, usual),
                                      .design = point.design,
                                      .trainings = point.networks.size(),
                                      .choice = point.choice,
                                      .reported = point.reported,
                                      .difference = point.difference,
                                      .on_accuracy_front = point.on_accuracy_front,
                                      .on_delay_front = point.on_delay_front,
                                      .front_probability = point.front_probability};
  entry["id"] = id_of(point.setting);
  entry["setting"] = point.setting;
  entry["models"] = json::array();
  for (const TradeNetwork& network : point.networks) entry["models"].push_back(network.name());
  return entry;
}

/// The number of settings whose 99 % quantile of the time per tick is uncertain by more than a factor of four. The slowest
/// heatmap of a run takes about twice as long as usual; all else is other load on the machine.
std::size_t on_a_busy_machine(std::span<const TradePoint> points) {
  return static_cast<std::size_t>(std::count_if(points.begin(), points.end(), [](const TradePoint& point) {
    const auto is_uncertain = [](const results::Figure& us) { return us.has_interval() && *us.high > 4 * *us.low; };
    return is_uncertain(point.choice.figures.us_p99) || is_uncertain(point.reported.figures.us_p99);
  }));
}

json json_of(const TradeLevels& tried) {
  json levels = json::object();
  for (const TradeFactor& factor : factors_of(tried)) {
    levels[factor.name] = json::array();
    for (const TradeLevel& level : factor.levels) levels[factor.name].push_back(level.text);
  }
  return levels;
}

json settings_json(const TradeOptions& options) {
  return {{"data", experiments::from_folder(options.data, options.out)},
          {"models", experiments::from_folder(options.models, options.out)},
          {"train_run", options.train_run},
          {"choice_runs", options.choice_runs},
          {"epochs", options.epochs},
          {"trainings", options.trainings},
          {"seed", options.seed},
          {"full", options.full},
          {"budget_minutes", options.budget_minutes ? json(*options.budget_minutes) : json()},
          {"levels", json_of(options.levels)}};
}

/// Pairs of history and tick that fit no setting.
json left_out_json(const TradeLevels& levels) {
  json left_out = json::array();
  for (const LeftOutPair& pair : left_out_pairs(levels)) {
    left_out.push_back(
        {{"th_ms", in_ms(pair.history)}, {"tick_ms", in_ms(pair.tick)}, {"why", "the history is not a whole number of ticks"}});
  }
  return left_out;
}

/// Those of the first training, and of each.
json runs_json(const TradePlan& plan) {
  json trainings = json::array();
  for (const TradeTraining& training : plan.trainings) {
    trainings.push_back({{"train", names_of(plan.dataset, training.runs.train)},
                         {"choice", names_of(plan.dataset, training.runs.choice)},
                         {"reported", names_of(plan.dataset, training.runs.reported)}});
  }
  json runs = trainings.front();
  runs["trainings"] = trainings;
  return runs;
}

json not_measured_json(const TradeOptions& options, const TradeFindings& findings) {
  json not_measured = json::array();
  for (const TradePoint& point : findings.points) {
    if ((point.on_accuracy_front || point.on_delay_front) && point.networks.size() < options.trainings)
      not_measured.push_back(
          {{"setting", text_of(point.setting, options.usual)},
           {"why", fmt::format("with {} of {} trainings: the budget was used up", point.networks.size(), options.trainings)}});
  }
  for (const NotMeasured& one : findings.not_measured) not_measured.push_back({{"setting", one.setting}, {"why", one.why}});
  return not_measured;
}

}  // namespace

json trade_json(const TradePlan& plan, const TradeFindings& findings) {
  const TradeOptions& options = plan.options;
  const windows::Dataset& dataset = plan.dataset;
  const results::BootstrapOptions bootstrap;
  json points = json::array();
  for (const TradePoint& point : findings.points) points.push_back(point_json(point, options.usual));
  return {
      {"format", "tactile-trade-1"},
      {"title", fmt::format("Speed against accuracy on {} runs", dataset.simulated() ? "simulated" : "real")},
      {"simulated", dataset.simulated()},
      {"times_are",
       fmt::format("Time per tick is the computing time of counting events, rendering and network, on one thread of one process. "
                   "All of at least {} ticks of each setting count, over all tested runs. The settings take turns, so that other "
                   "load on the machine affects all of them equally. 'tactile detect' reports its own waiting times.",
                   options.timing.ticks)},
      {"judged_by", judged_by(plan)},
      {"settings", settings_json(options)},
      {"software", experiments::software_json()},
      {"machine", experiments::machine_json(options.threads)},
      {"bootstrap", {{"draws", bootstrap.draws}, {"confidence", bootstrap.confidence}, {"seed", bootstrap.seed}}},
      {"dataset",
       {{"file", experiments::from_folder(dataset.file(), options.out)},
        {"manifest_hash", dataset.manifest_hash()},
        {"settings", windows::dataset_settings_in(dataset.settings())},
        {"samples", dataset.samples().size()}}},
      {"runs", runs_json(plan)},
      {"usual", id_of(options.usual)},
      {"usual_is", judgement_of_usual(findings.points, options.usual)},
      {"busy", on_a_busy_machine(findings.points)},
      {"points", points},
      {"left_out", left_out_json(options.levels)},
      {"not_measured", not_measured_json(options, findings)},
      {"unfinished", findings.unfinished.empty() ? json() : json(findings.unfinished)},
      {"growth", findings.growth},
      {"recommendation", findings.recommendation},
      {"steps", std::vector(findings.steps.begin(), findings.steps.end())}};
}

void write_trade(const json& trade, const fs::path& folder) {
  write_whole(folder / "trade.csv", trade_csv(trade));
  write_whole(folder / "trade.json", json_text(trade, 2) + "\n");
}

std::string trade_csv(const json& trade) {
  CsvTable table(
      "id,design,trainings,kind,th_ms,tick_ms,factor,resize,denoise,width,last_pool,engine,precision,pass,confirm,filter,gate,"
      "runs,"
      "accuracy,accuracy_low,accuracy_high,delay_us,delay_us_low,delay_us_high,delay_p90_us,missed,"
      "episodes_per_min,episodes_per_min_low,episodes_per_min_high,us_p50,us_p50_low,us_p50_high,"
      "us_p99,us_p99_low,us_p99_high,us_p999,front_accuracy,front_delay,probability_accuracy,probability_delay");
  const auto number = [](const json& value) { return value.is_null() ? std::string() : csv_number(value.get<double>()); };
  const auto figure = [&](const json& value) {
    return std::array{number(value.at("value")), number(value.at("low")), number(value.at("high"))};
  };
  for (const json& point : trade.at("points")) {
    for (const char* runs : {"choice", "reported"}) {
      const json &setting = point.at("setting"), &result = point.at(runs);
      const auto word = [&](const char* key) { return setting.at(key).get<std::string>(); };
      const json& delay = result.at("delay_us");
      const json &us = result.at("us"), &front = point.at("front");
      table.add_row(point.at("id").get<std::string>(), point.at("design").get<std::string>(),
                    point.at("trainings").get<std::size_t>(), word("kind"), number(setting.at("th_ms")),
                    number(setting.at("tick_ms")), number(setting.at("factor")), word("resize"), word("denoise"),
                    number(setting.at("width")), number(setting.at("last_pool")), word("engine"), word("precision"), word("pass"),
                    word("confirm"), word("filter"), setting.at("gate").get<bool>() ? "on" : "off", runs,
                    figure(result.at("accuracy")), figure(delay.at("median")), number(delay.at("p90").at("value")),
                    number(delay.at("missed").at("value")), figure(result.at("episodes_per_min")), figure(us.at("p50")),
                    figure(us.at("p99")), number(us.at("p999").at("value")), front.at("accuracy").get<bool>() ? 1 : 0,
                    front.at("delay").get<bool>() ? 1 : 0, number(front.at("probability").at("accuracy")),
                    number(front.at("probability").at("delay")));
    }
  }
  return table.text();
}

}  // namespace tactile::trade
