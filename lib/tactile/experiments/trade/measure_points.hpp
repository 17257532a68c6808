#pragma once

#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "tactile/experiments/step_runner.hpp"
#include "tactile/experiments/trade/plan_trade.hpp"
#include "tactile/results/full_run.hpp"

namespace tactile::trade {

/// Trains networks, and knows which are trained. Starts no training that would exceed the budget, by the longest one so far.
class NetworkTrainer {
 public:
  /// The time of the budget starts. @param runner  must outlive this, as `plan`
  NetworkTrainer(const TradePlan& plan, experiments::StepRunner& runner) : plan_(plan), runner_(runner) {}

  /// In their order, each once.
  void train(const std::vector<TradeNetwork>& networks);

  std::size_t trained() const { return trained_.size(); }

  /// The networks of a setting that are trained, one for each seed, up to the first that is not.
  std::vector<TradeNetwork> trained_for(const TradeSetting& setting) const;

  /// If the budget ended the work: a sentence on what to do; else empty.
  std::string unfinished() const;

 private:
  experiments::Step step_for(const TradeNetwork& network) const;
  double longest_training_s() const;
  bool budget_allows_training() const;

  const TradePlan& plan_;
  experiments::StepRunner& runner_;
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  std::set<std::string> trained_;  ///< names
  std::size_t begun_trainings_ = 0;
  bool budget_ended_ = false;
};

/// The time that ticks of the tested runs take. Points that cost the same share one `TimedSetting`.
struct PointTimes {
  std::vector<TimedSetting> settings;
  std::vector<TimesOfRuns> times;  ///< of each of `settings`

  const TimesOfRuns& of(const TradePoint& point) const;  ///< one of the points that were timed
};

/// Points with all that is measured of them.
struct MeasuredPoints {
  std::vector<TradePoint> points;  ///< the usual setting first
  std::vector<NotMeasured> not_measured = {};
  std::map<std::string, std::vector<results::FullRun>> predictions =
      {};  ///< at every tick of the tested runs, by `prediction_name`
  PointTimes times = {};
};

/// Identifies a network's predictions for a setting: its tick, engine and precision count.
std::string prediction_name(const TradeNetwork& network, const TradeSetting& setting);

/// Second stage: trains one network for each point, predicts all tested runs, times ticks, and judges. Points that cannot be
/// measured are moved to `not_measured`.
/// @param step_of_times  name of the step that times all points
/// @throws Error  if the usual setting cannot be measured, or a step fails
void measure(const TradePlan& plan, const std::string& step_of_times, NetworkTrainer& trainer, experiments::StepRunner& runner,
             MeasuredPoints& measured);

/// Third stage: does the same with all seeds for the points on a front and the usual setting. Judges again, which may change the
/// fronts, and repeats until no network is left to train. Times stay.
void measure_all_seeds(const TradePlan& plan, NetworkTrainer& trainer, experiments::StepRunner& runner, MeasuredPoints& measured);

/// Times ticks over event rates, histories and resolutions in one step.
/// @return  `CostGrowth` as JSON. @throws Error  if the step fails
nlohmann::json time_cost_growth(const TradePlan& plan, experiments::StepRunner& runner);

}  // namespace tactile::trade
