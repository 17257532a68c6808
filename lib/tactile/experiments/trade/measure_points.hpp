#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "tactile/experiments/step_runner.hpp"
#include "tactile/experiments/trade/budget.hpp"
#include "tactile/experiments/trade/network_trainer.hpp"
#include "tactile/experiments/trade/plan_trade.hpp"
#include "tactile/results/full_run.hpp"
#include "tactile/results/trade.hpp"

namespace tactile::trade {

/// The time that ticks of the tested runs take. Points that cost the same share one `TimedSetting`.
struct PointTimes {
  std::vector<TimedSetting> settings;
  std::vector<TimesOfRuns> times;  ///< of each of `settings`

  const TimesOfRuns& of(const TradePoint& point) const;  ///< one of the points that were timed
};

/// Points with all that is measured of them.
struct MeasuredPoints {
  std::vector<TradePoint> points;  ///< the usual setting first
  std::vector<results::NotMeasured> not_measured = {};
  std::map<std::string, std::vector<results::FullRun>> predictions =
      {};  ///< at every tick of the runs that a network is tested on, by `prediction_name`
  PointTimes times = {};
};

/// Identifies a network's predictions for a setting: its tick, engine and precision count.
std::string prediction_name(const TradeNetwork& network, const TradeSetting& setting);
std::filesystem::path prediction_file(const TradePlan& plan, const std::string& name);  ///< @param name  as `prediction_name`

/// What the stages work with. All of it must outlive them.
struct Stage {
  const TradePlan& plan;
  NetworkTrainer& trainer;
  experiments::StepRunner& runner;
  Budget& budget;
};

/// Moves points that the dataset cannot render, or not at a common tick, to `not_measured`.
/// @throws Error  if the usual setting is one of them
void remove_what_cannot_be_rendered(const TradePlan& plan, MeasuredPoints& measured);

/// Second stage: trains one network for each point, predicts the runs that it is tested on, times ticks, and judges. Points that
/// cannot be measured, or not within the budget, are moved to `not_measured`.
/// @param step_of_times  name of the step that times all points   @param ticks  of each point that are timed
/// @throws Error  if the usual setting cannot be measured, or a step fails
void measure(const Stage& stage, const std::string& step_of_times, std::uint64_t ticks, MeasuredPoints& measured);

/// Third stage: trains the usual setting and those that may be on a front a second time, and judges again. The number of
/// trainings of those that still may is doubled again, up to the requested number. A setting may be on a front if it is in 2.5
/// % of the draws or more: its interval then reaches the front. With too few objects to draw from, those on a front are
/// trained. Times are not measured again.
void measure_all_trainings(const Stage& stage, MeasuredPoints& measured);

/// "the budget of 2 minutes was used up before its network was trained"
std::string budget_words(const TradePlan& plan, const std::string& before);

/// @throws Error  that begins with `problem`, if the usual setting is not among the points: all others are compared with it
void expect_usual(const Stage& stage, const MeasuredPoints& measured, const std::string& problem);

/// Moves all other points to `not_measured`.
void remove_unless(MeasuredPoints& measured, const TradeSetting& usual, const std::function<bool(const TradePoint&)>& stays,
                   const std::string& why);

}  // namespace tactile::trade
