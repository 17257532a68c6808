#pragma once

#include <set>
#include <string>
#include <vector>

#include "tactile/experiments/step_runner.hpp"
#include "tactile/experiments/trade/budget.hpp"
#include "tactile/experiments/trade/plan_trade.hpp"

namespace tactile::trade {

/// The duration of the longest step so far whose name begins so; 0 if there is none.
double longest_s(const experiments::StepRunner& runner, const std::string& begin);

/// Trains networks, and knows which are trained. Starts no training that would exceed the budget, by the longest one so far.
class NetworkTrainer {
 public:
  /// @param runner, budget  must outlive this, as `plan`
  NetworkTrainer(const TradePlan& plan, experiments::StepRunner& runner, Budget& budget)
      : plan_(plan), runner_(runner), budget_(budget) {}

  /// In their order, each once.
  /// @param reserve_s  time that what comes after needs
  /// @param each_s     time that it needs besides for each network that this call trains
  void train(const std::vector<TradeNetwork>& networks, double reserve_s, double each_s);

  std::size_t trained() const { return trained_.size(); }

  /// The networks of a setting that are trained, one for each training, up to the first that is not.
  std::vector<TradeNetwork> trained_for(const TradeSetting& setting) const;

  /// If the budget ended the work: a sentence on what to do; else empty.
  std::string unfinished() const;

 private:
  experiments::Step step_for(const TradeNetwork& network) const;
  bool is_trained(const TradeNetwork& network) const;

  const TradePlan& plan_;
  experiments::StepRunner& runner_;
  Budget& budget_;
  std::set<std::string> trained_;  ///< names
};

}  // namespace tactile::trade
