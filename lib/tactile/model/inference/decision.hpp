#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tactile/core/confirmation.hpp"
#include "tactile/core/time.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/model/inference/logits.hpp"
#include "tactile/model/inference/two_thresholds.hpp"

namespace tactile::model {

/// Settings of a decision filter.
struct FilterSettings {
  Transitions transitions{};
  microseconds history{40'000};  ///< t_h of the heatmaps, > 0
  double alarm_cost = 0.01;      ///< of a tick of alarm without a touch, relative to a missed tick of a touch; > 0
};

inline constexpr double default_alarm_cost = FilterSettings{}.alarm_cost;

/// A causal forward filter of a hidden Markov model whose states are none, press and slip. At each tick
///
///   predicted_j = sum_i state_i exp(Q tick)_ij,   state_j ∝ predicted_j max(p_j, 1e-4)^w
///
/// Q holds the rates of `Transitions`. p are the network's probabilities. Heatmaps of successive ticks share most of their
/// events. Therefore a tick counts as w = min(1, 4 tick / t_h) of an observation. A class is reported if its state is above
/// `alarm_cost` times that of none. The reported class changes to the other one only if that is ten times as probable. The 4, the
/// 10 and the default cost are ours: chosen on simulated runs that no figure is reported of.
///
/// A state is never below the smallest rate times the tick, so no product of probabilities vanishes. Allocates no memory.
/// Source: Rabiner, A tutorial on hidden Markov models, Proc. IEEE 77, 1989, equations 18 to 20.
class DecisionFilter {
 public:
  /// @throws Error  if the tick or a setting is out of its range
  DecisionFilter(const FilterSettings& settings, microseconds tick);

  Touch next(const Probabilities& probabilities);  ///< the verdict at the next tick
  void skip(std::uint64_t ticks);                  ///< this many ticks have no observation
  void restart();                                  ///< the next tick begins in none

  const std::array<double, touch_count>& state() const { return state_; }  ///< of none, press, slip; the sum is 1

 private:
  using Matrix = std::array<std::array<double, touch_count>, touch_count>;

  Matrix step_{};  ///< exp(Q tick)
  double weight_ = 1, alarm_cost_ = 1;
  std::array<double, touch_count> state_{1, 0, 0};
  Touch reported_ = Touch::none;
};

/// How predictions become verdicts: confirmed, or filtered, or by two thresholds.
struct Decision {
  Confirmation confirmation{};
  std::optional<FilterSettings> filter{};     ///< instead of the confirmation
  std::optional<TwoThresholds> thresholds{};  ///< instead of both
};

/// The settings of a model's filter. @throws Error  if the bundle has no transitions
FilterSettings filter_of(const ModelBundle& bundle, const ModelDescription& description, double alarm_cost);

/// The verdicts of successive ticks.
/// @param predicted      the likeliest class of each tick
/// @param probabilities  of each tick; needed only with a filter or thresholds
std::vector<Touch> decided(const Decision& decision, microseconds tick, std::span<const Touch> predicted,
                           std::span<const Probabilities> probabilities);

/// The same, tick by tick. Allocates memory only in its constructor.
class RunningDecision {
 public:
  RunningDecision(const Decision& decision, microseconds tick);

  Touch next(Touch predicted, const Probabilities& probabilities);  ///< the verdict at the next tick
  void skip(std::uint64_t ticks);                                   ///< this many ticks have no prediction
  void restart();

 private:
  unsigned longest_;  ///< ticks that a confirmation depends on
  RunningConfirmation confirmation_;
  std::optional<DecisionFilter> filter_;
  std::optional<ThresholdDecision> thresholds_;
};

}  // namespace tactile::model
