#include "tactile/model/inference/decision.hpp"

#include <algorithm>

namespace tactile::model {

std::optional<TwoThresholds> usual_thresholds(ModelKind kind) {
  return kind == ModelKind::stream ? std::optional(TwoThresholds{}) : std::nullopt;
}

Decision usual_decision(ModelKind kind, const Confirmation& confirmation) {
  return {.confirmation = confirmation, .thresholds = confirmation == Confirmation{} ? usual_thresholds(kind) : std::nullopt};
}

std::vector<Touch> decided(const Decision& decision, microseconds tick, std::span<const Touch> predicted,
                           std::span<const Probabilities> probabilities) {
  RunningDecision running(decision, tick);
  std::vector<Touch> verdicts;
  verdicts.reserve(predicted.size());
  for (std::size_t k = 0; k < predicted.size(); ++k)
    verdicts.push_back(running.next(predicted[k], probabilities.empty() ? Probabilities{} : probabilities[k]));
  return verdicts;
}

RunningDecision::RunningDecision(const Decision& decision, microseconds tick)
    : longest_(decision.confirmation.of), confirmation_(decision.confirmation) {
  if (decision.thresholds) thresholds_.emplace(*decision.thresholds, tick);
}

Touch RunningDecision::next(Touch predicted, const Probabilities& probabilities) {
  verdict_ = thresholds_ ? thresholds_->next(probabilities) : confirmation_.next(predicted);
  return verdict_;
}

bool RunningDecision::confirms_slip() const { return thresholds_ ? thresholds_->confirms_slip() : verdict_ == Touch::slip; }

void RunningDecision::skip(std::uint64_t ticks) {
  if (thresholds_) return thresholds_->skip(ticks);
  for (std::uint64_t i = std::min<std::uint64_t>(ticks, longest_); i > 0; --i) confirmation_.next(Touch::none);
}

void RunningDecision::restart() {
  if (thresholds_) thresholds_->restart();
  confirmation_.restart();
}

}  // namespace tactile::model
