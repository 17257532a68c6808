#include "tactile/experiments/trade/judge_points.hpp"

#include <algorithm>
#include <cmath>

#include "tactile/core/parallel.hpp"
#include "tactile/experiments/trade/full_runs.hpp"

namespace tactile::trade {
namespace {

/// The outcomes of a point, apart on the runs to choose on and those to report on.
struct PointOutcomes {
  std::vector<results::Cell> choice, reported;
};

PointOutcomes outcomes_of(const TradePlan& plan, const MeasuredPoints& measured, const TradePoint& point) {
  const TradeSetting& setting = point.setting;
  PointOutcomes outcomes;
  for (std::size_t training = 0; training < point.networks.size(); ++training) {
    const TradeNetwork& network = point.networks[training];
    const std::vector<results::FullRun>& predicted = measured.predictions.at(prediction_name(network, setting));
    const TradeTraining& of_training = plan.trainings[training];
    const std::vector<std::uint32_t> tested = of_training.tested();
    for (std::size_t i = 0; i < tested.size(); ++i) {
      const results::FullRun full = at_tick(predicted[i], setting.rendering.tick);
      results::Cell outcome =
          cell_of(plan.judged.at(tested[i]), full, evaluation::decided(model::usual_decision(setting.kind, {}), full));
      outcome.training = training;
      (i < of_training.runs.choice.size() ? outcomes.choice : outcomes.reported).push_back(std::move(outcome));
    }
  }
  return outcomes;
}

/// The ticks of all tested runs, with the network of the first training.
std::vector<TimedRun> timed_runs_of(const TradePlan& plan, const MeasuredPoints& measured, const TradePoint& point) {
  const TimesOfRuns& times = measured.times.of(point);
  std::vector<TimedRun> timed;
  for (const auto& [index, run] : plan.judged) timed.push_back(timed_run(run, times.at(timed.size())));
  return timed;
}

void find_fronts(std::span<TradePoint> points, std::span<const FrontCandidate> candidates, unsigned threads) {
  std::vector<results::TradeResult> figures;
  for (const TradePoint& point : points) figures.push_back(point.choice);
  const OnFronts on = fronts_of(figures);
  const std::vector<results::FrontProbability> probabilities = front_probabilities(candidates, threads);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].on_accuracy_front = on.accuracy[i];
    points[i].on_delay_front = on.delay[i];
    points[i].front_probability = probabilities[i];
  }
}

}  // namespace

void judge(const TradePlan& plan, MeasuredPoints& measured) {
  const std::span<TradePoint> points(measured.points);
  std::vector<FrontCandidate> candidates(points.size());
  parallel_for(points.size(), plan.options.threads, [&](std::size_t i) {
    TradePoint& point = points[i];
    PointOutcomes runs = outcomes_of(plan, measured, point);
    const std::vector<TimedRun> timed = timed_runs_of(plan, measured, point);
    point.choice = result_of(runs.choice, timed);
    point.reported = result_of(runs.reported, timed);
    point.choice.tick_us = point.reported.tick_us = static_cast<double>(point.setting.rendering.tick.count());
    candidates[i] = {std::move(runs.choice), timed};
  });
  find_fronts(points, candidates, plan.options.threads);
}

std::map<std::string, TradeOutcome> known_outcomes(std::span<const TradePoint> points) {
  std::map<std::string, TradeOutcome> known;
  for (const TradePoint& point : points) {
    const results::TradeResult& figures = point.choice;
    const TradeOutcome outcome{figures.accuracy.value, figures.us_p99.value, figures.whole_runs.median_ms.ms.value,
                               figures.whole_runs.alarms_per_min.value, figures.whole_runs.missed.value};
    const bool is_known = std::isfinite(outcome.accuracy) && std::isfinite(outcome.us) && std::isfinite(outcome.delay_ms) &&
                          std::isfinite(outcome.alarms_per_min);
    if (is_known) known[id_of(point.setting)] = outcome;
  }
  return known;
}

}  // namespace tactile::trade
