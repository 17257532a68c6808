#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tactile/core/confirmation.hpp"
#include "tactile/core/time.hpp"
#include "tactile/model/definition/model_kind.hpp"
#include "tactile/model/inference/logits.hpp"
#include "tactile/model/inference/two_thresholds.hpp"

namespace tactile::model {

/// The thresholds that a model decides by where no others are given: those of a stream; nothing for other kinds, which the paper
/// judges at each tick by itself.
std::optional<TwoThresholds> usual_thresholds(ModelKind kind);

/// How predictions become verdicts: confirmed, or by two thresholds.
struct Decision {
  Confirmation confirmation{};
  std::optional<TwoThresholds> thresholds{};  ///< instead of the confirmation
};

/// By the usual thresholds of a kind where nothing is confirmed; else by the confirmation.
Decision usual_decision(ModelKind kind, const Confirmation& confirmation);

/// The verdicts of successive ticks.
/// @param predicted      the likeliest class of each tick
/// @param probabilities  of each tick; needed only with thresholds
std::vector<Touch> decided(const Decision& decision, microseconds tick, std::span<const Touch> predicted,
                           std::span<const Probabilities> probabilities);

/// The same, tick by tick. Allocates memory only in its constructor.
class RunningDecision {
 public:
  RunningDecision(const Decision& decision, microseconds tick);

  Touch next(Touch predicted, const Probabilities& probabilities);  ///< the verdict at the next tick
  /// Whether the verdict is a slip that is confirmed by `TwoThresholds::confirmed`; without thresholds every slip is.
  bool confirms_slip() const;
  void skip(std::uint64_t ticks);  ///< this many ticks have no prediction
  void restart();

 private:
  unsigned longest_;  ///< ticks that a confirmation depends on
  RunningConfirmation confirmation_;
  std::optional<ThresholdDecision> thresholds_;
  Touch verdict_ = Touch::none;  ///< the last one
};

}  // namespace tactile::model
