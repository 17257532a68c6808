#include "tactile/experiments/trade/judge_points.hpp"

#include <algorithm>
#include <cmath>

#include "tactile/core/parallel.hpp"
#include "tactile/experiments/trade/full_runs.hpp"
#include "tactile/experiments/trade/pareto_front.hpp"

namespace tactile::trade {
namespace {

/// Of every tested run, the first `seeds` networks together.
std::vector<TradedRun> outcomes_of(const TradePlan& plan, const MeasuredPoints& measured, const TradePoint& point,
                                   std::size_t seeds) {
  const TradeSetting& setting = point.setting;
  std::vector<TradedRun> outcomes(plan.tested.indexes.size());
  for (std::size_t seed = 0; seed < seeds; ++seed) {
    const TradeNetwork& network = point.networks[seed];
    const auto gate = gate_of(setting, network);
    const std::vector<results::FullRun>& predicted = measured.predictions.at(prediction_name(network, setting));
    for (std::size_t run = 0; run < outcomes.size(); ++run) {
      const results::FullRun at_its_tick = at_tick(predicted[run], setting.rendering.tick);
      const TradedRun outcome =
          outcome_of(plan.tested.judged[run], at_its_tick, verdicts_of(at_its_tick, gate, setting.confirmation));
      if (seed == 0) {
        outcomes[run] = outcome;
      } else {
        outcomes[run] += outcome;
      }
    }
  }
  const auto gate = gate_of(setting, point.networks.front());
  for (std::size_t run = 0; run < outcomes.size(); ++run) add_times(outcomes[run], measured.times.of(point).at(run), gate);
  return outcomes;
}

void find_fronts(std::span<TradePoint> points) {
  std::vector<TradePlace> by_accuracy, by_delay;
  for (TradePoint& point : points) {
    point.on_accuracy_front = point.on_delay_front = false;
    const TradeFigures& figures = point.choice.figures;
    by_accuracy.push_back({figures.us_p99.value, -figures.accuracy.value, 0});
    by_delay.push_back({figures.false_alarms_per_min.value, figures.delay_us.value, point.choice.missed.value});
  }
  for (const std::size_t i : pareto_front(by_accuracy)) points[i].on_accuracy_front = true;
  for (const std::size_t i : pareto_front(by_delay)) points[i].on_delay_front = true;
}

}  // namespace

void judge(const TradePlan& plan, MeasuredPoints& measured) {
  const std::span<TradePoint> points(measured.points);
  const auto outcomes = [&](const TradePoint& point, std::size_t seeds) { return outcomes_of(plan, measured, point, seeds); };
  const TradePoint& usual = points.front();
  std::vector<std::vector<TradedRun>> usual_by_seeds{{}};
  for (std::size_t seeds = 1; seeds <= usual.networks.size(); ++seeds) usual_by_seeds.push_back(outcomes(usual, seeds));
  parallel_for(points.size(), plan.options.threads, [&](std::size_t i) {
    TradePoint& point = points[i];
    const std::vector<TradedRun> runs = outcomes(point, point.networks.size());
    point.choice = result_of(std::span(runs).first(plan.choice_count));
    point.reported = result_of(std::span(runs).subspan(plan.choice_count));
    point.choice.figures.tick_us = point.reported.figures.tick_us = static_cast<double>(point.setting.rendering.tick.count());
    point.difference.reset();
    if (i == 0) return;
    // With as many seeds of each, so that the runs are paired.
    const std::size_t seeds = std::min(point.networks.size(), usual.networks.size());
    const std::vector<TradedRun> paired = seeds < point.networks.size() ? outcomes(point, seeds) : runs;
    point.difference =
        difference_of(std::span(usual_by_seeds[seeds]).subspan(plan.choice_count), std::span(paired).subspan(plan.choice_count));
  });
  find_fronts(points);
}

std::map<std::string, TradeOutcome> known_outcomes(std::span<const TradePoint> points) {
  std::map<std::string, TradeOutcome> known;
  for (const TradePoint& point : points) {
    const TradeFigures& figures = point.choice.figures;
    const TradeOutcome outcome{figures.accuracy.value, figures.us_p99.value, figures.delay_us.value,
                               figures.false_alarms_per_min.value, point.choice.missed.value};
    const bool is_known = std::isfinite(outcome.accuracy) && std::isfinite(outcome.us) && std::isfinite(outcome.delay_us) &&
                          std::isfinite(outcome.false_alarms_per_min);
    if (is_known) known[id_of(point.setting)] = outcome;
  }
  return known;
}

}  // namespace tactile::trade
