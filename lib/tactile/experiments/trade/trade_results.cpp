#include "tactile/experiments/trade/trade_results.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tactile/core/csv_table.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/evaluation/run_figures.hpp"
#include "tactile/experiments/experiment_json.hpp"
#include "tactile/experiments/milliseconds.hpp"
#include "tactile/experiments/run_division.hpp"
#include "tactile/results/figure_cells.hpp"
#include "tactile/results/whole_runs_tables.hpp"
#include "tactile/windows/dataset_settings.hpp"

namespace tactile::trade {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Which trainings judge which runs, in words.
std::string judged_by(const TradePlan& plan) {
  const std::size_t trainings = plan.trainings.size();
  std::string of_runs = " False alarms, delays and misses are of every run of these objects, accuracy is of those with samples.";
  of_runs += results::left_out_in_words(plan.left_out);
  if (plan.objects() < evaluation::fewest_objects)
    of_runs += " Intervals, where there are any, are over trainings and runs, and hold for these objects only.";
  if (trainings == 1) {
    const experiments::RunDivision& runs = plan.trainings.front().runs;
    return fmt::format("One training learns from {} runs. Settings are chosen on {} others and reported on {} others.{}",
                       runs.train.size(), runs.choice.size(), runs.reported.size(), of_runs);
  }
  return fmt::format(
      "Up to {} trainings of each setting, each with another seed and other runs to learn from, to choose on and to report on. "
      "No network is judged on a run that it learned from or was chosen on; another network may have been.{}",
      trainings, of_runs);
}

results::TradedSetting traded(const TradePoint& point, const TradeSetting& usual) {
  results::TradedSetting traded{.id = id_of(point.setting),
                                .text = text_of(point.setting, usual),
                                .design = point.design,
                                .values = values_of(point.setting),
                                .trainings = point.networks.size(),
                                .choice = point.choice,
                                .reported = point.reported,
                                .on_accuracy_front = point.on_accuracy_front,
                                .on_delay_front = point.on_delay_front,
                                .front_probability = point.front_probability};
  for (const TradeNetwork& network : point.networks) traded.models.push_back(network.name());
  return traded;
}

std::uint64_t on_a_busy_machine(std::span<const TradePoint> points) {
  return static_cast<std::uint64_t>(
      std::count_if(points.begin(), points.end(), [](const TradePoint& point) { return point.reported.is_disturbed(); }));
}

/// The share of all timed ticks in which another program had the processor.
double interrupted_share(std::span<const TradePoint> points) {
  double interrupted = 0, ticks = 0;
  for (const TradePoint& point : points) {
    ticks += static_cast<double>(point.reported.ticks);
    interrupted += static_cast<double>(point.reported.ticks) * point.reported.interrupted;
  }
  return ticks > 0 ? interrupted / ticks : 0;
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
          {"steps", options.steps},
          {"trainings", options.trainings},
          {"seed", options.seed},
          {"full", options.full},
          {"budget_minutes", options.budget_minutes ? json(*options.budget_minutes) : json()},
          {"levels", json_of(options.levels)}};
}

std::vector<results::NotMeasured> not_measured_in(const TradeOptions& options, const TradeFindings& findings) {
  std::vector<results::NotMeasured> not_measured;
  for (const TradePoint& point : findings.points) {
    if ((point.on_accuracy_front || point.on_delay_front) && point.networks.size() < options.trainings)
      not_measured.push_back(
          {text_of(point.setting, options.usual),
           fmt::format("with {} of {} trainings: the budget was used up", point.networks.size(), options.trainings)});
  }
  not_measured.insert(not_measured.end(), findings.not_measured.begin(), findings.not_measured.end());
  return not_measured;
}

}  // namespace

results::Trade results_of(const TradePlan& plan, TradeFindings findings) {
  const TradeOptions& options = plan.options;
  const windows::Dataset& dataset = plan.dataset;
  results::Trade trade{
      .title = fmt::format("Speed against accuracy on {} runs", dataset.simulated() ? "simulated" : "real"),
      .simulated = dataset.simulated(),
      .times_are =
          fmt::format("Time per tick is the computing time of counting events, rendering and network, on one thread of one "
                      "process. All of at least {} ticks of each setting count, over all tested runs. The settings take turns, "
                      "so that other load on the machine affects all of them equally. Other programs interrupted {:.2g} % of "
                      "these ticks. 'tactile detect' reports its own waiting "
                      "times.",
                      options.timing.ticks, 100 * interrupted_share(findings.points)),
      .judged_by = judged_by(plan),
      .settings = settings_json(options),
      .software = experiments::software_json(),
      .machine = experiments::machine_json(options.threads),
      .dataset = {.file = experiments::from_folder(dataset.file(), options.out),
                  .manifest_hash = dataset.manifest_hash(),
                  .settings = windows::dataset_settings_in(dataset.settings()),
                  .samples = dataset.samples().size()},
      .usual = id_of(options.usual),
      .interrupted = interrupted_share(findings.points),
      .busy = on_a_busy_machine(findings.points),
      .not_measured = not_measured_in(options, findings),
      .unfinished = std::move(findings.unfinished),
      .recommendation = std::move(findings.recommendation),
      .steps = std::move(findings.steps)};
  for (const TradeTraining& training : plan.trainings) {
    trade.runs.push_back({.train = names_of(dataset, training.runs.train),
                          .choice = plan.names(training.runs.choice),
                          .reported = plan.names(training.runs.reported)});
  }
  for (const TradePoint& point : findings.points) trade.points.push_back(traded(point, options.usual));
  for (const LeftOutPair& pair : left_out_pairs(options.levels))
    trade.left_out.push_back({pair.history, pair.tick, "the history is not a whole number of ticks"});
  return trade;
}

void write_trade(const results::Trade& trade, const fs::path& folder) {
  write_whole(folder / "trade.csv", trade_csv(trade));
  write_json(folder / "trade.json", trade);
}

std::string trade_csv(const results::Trade& trade) {
  CsvTable table(
      "id,design,trainings,kind,th_ms,tick_ms,factor,resize,denoise,engine,precision,augment,runs,"
      "accuracy,accuracy_low,accuracy_high,delay_ms,delay_ms_low,delay_ms_high,delay_p90_ms,missed,"
      "alarms_per_min,alarms_per_min_low,alarms_per_min_high,us_p50,us_p50_low,us_p50_high,"
      "us_p99,us_p99_low,us_p99_high,us_p999,front_accuracy,front_delay,probability_accuracy,probability_delay,"
      "delay_is_lower_bound,delay_p90_is_lower_bound");
  for (const results::TradedSetting& point : trade.points) {
    for (const auto& [runs, result] : {std::pair("choice", &point.choice), std::pair("reported", &point.reported)}) {
      const results::SettingValues& values = point.values;
      const results::OperatingPoint& whole = result->whole_runs;
      table.add_row(
          point.id, point.design, point.trainings, values.kind, csv_number(values.th_ms), csv_number(values.tick_ms),
          csv_number(values.factor), values.resize, values.denoise, values.engine, values.precision, values.augment, runs,
          results::figure_cells(result->accuracy), results::figure_cells(whole.median_ms.ms), csv_number(whole.p90_ms.ms.value),
          csv_number(whole.missed.value), results::figure_cells(whole.alarms_per_min), results::figure_cells(result->us_p50),
          results::figure_cells(result->us_p99), csv_number(result->us_p999.value), point.on_accuracy_front ? 1 : 0,
          point.on_delay_front ? 1 : 0, csv_number(point.front_probability.accuracy), csv_number(point.front_probability.delay),
          whole.median_ms.is_lower_bound ? 1 : 0, whole.p90_ms.is_lower_bound ? 1 : 0);
    }
  }
  return table.text();
}

}  // namespace tactile::trade
