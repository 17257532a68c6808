#include "tactile/model/inference/decision.hpp"

#include <fmt/core.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

#include "tactile/core/error.hpp"

namespace tactile::model {
namespace {

constexpr double observations_in_history = 4, least_probability = 1e-4, margin_to_change = 10;

using State = std::array<double, touch_count>;

template <class Matrix>
State moved(const State& state, const Matrix& step) {
  State next{};
  for (std::size_t i = 0; i < touch_count; ++i) {
    for (std::size_t j = 0; j < touch_count; ++j) next[j] += state[i] * step[i][j];
  }
  return next;
}

void normalise(State& state) {
  const double sum = state[0] + state[1] + state[2];
  for (double& value : state) value /= sum;
}

/// Makes each row sum to 1 again, so that rounding does not grow with powers.
template <class Matrix>
void normalise_rows(Matrix& step) {
  for (State& row : step) normalise(row);
}

}  // namespace

DecisionFilter::DecisionFilter(const FilterSettings& settings, microseconds tick) : alarm_cost_(settings.alarm_cost) {
  if (tick <= microseconds{0} || settings.history <= microseconds{0})
    throw Error(fmt::format("decision filter: tick of {} us, history of {} us; expected more than 0", tick.count(),
                            settings.history.count()));
  if (!(std::isfinite(settings.alarm_cost) && settings.alarm_cost > 0))
    throw Error(fmt::format("decision filter: alarm cost of {}; expected a number above 0", settings.alarm_cost));
  weight_ =
      std::min(1.0, observations_in_history * static_cast<double>(tick.count()) / static_cast<double>(settings.history.count()));
  Eigen::Matrix3d rates = Eigen::Matrix3d::Zero();
  for (const Touch from : all_touches) {
    for (const Touch to : all_touches) {
      if (from != to) rates(static_cast<int>(from), static_cast<int>(to)) = settings.transitions.rate(from, to);
    }
    rates(static_cast<int>(from), static_cast<int>(from)) = -rates.row(static_cast<int>(from)).sum();
  }
  const Eigen::Matrix3d step = (rates * (static_cast<double>(tick.count()) / 1e6)).exp();
  for (std::size_t i = 0; i < touch_count; ++i) {
    for (std::size_t j = 0; j < touch_count; ++j) step_[i][j] = std::max(step(static_cast<int>(i), static_cast<int>(j)), 0.0);
  }
  normalise_rows(step_);
}

Touch DecisionFilter::next(const Probabilities& probabilities) {
  state_ = moved(state_, step_);
  State evidence{};
  for (std::size_t i = 0; i < touch_count; ++i)
    evidence[i] = weight_ * std::log(std::max(static_cast<double>(probabilities[i]), least_probability));
  const double largest = *std::max_element(evidence.begin(), evidence.end());
  for (std::size_t i = 0; i < touch_count; ++i) state_[i] *= std::exp(evidence[i] - largest);
  normalise(state_);

  const auto of = [this](Touch touch) { return state_[static_cast<std::size_t>(touch)]; };
  const auto exceeds_none = [&](Touch touch) { return of(touch) > alarm_cost_ * of(Touch::none); };
  const Touch likelier = of(Touch::slip) > of(Touch::press) ? Touch::slip : Touch::press;
  const bool stays = reported_ != Touch::none && exceeds_none(reported_) && of(likelier) <= margin_to_change * of(reported_);
  if (!stays) reported_ = exceeds_none(likelier) ? likelier : Touch::none;
  return reported_;
}

void DecisionFilter::skip(std::uint64_t ticks) {
  if (ticks == 0) return;  // as at almost every tick of a live stream
  Matrix power = step_;
  for (; ticks > 0; ticks /= 2) {
    if (ticks % 2 == 1) state_ = moved(state_, power);
    Matrix square{};
    for (std::size_t i = 0; i < touch_count; ++i) square[i] = moved(power[i], power);
    normalise_rows(square);
    power = square;
  }
  normalise(state_);
}

void DecisionFilter::restart() {
  state_ = {1, 0, 0};
  reported_ = Touch::none;
}

FilterSettings filter_of(const ModelBundle& bundle, const ModelDescription& description, double alarm_cost) {
  if (!description.transitions) {
    throw Error(
        fmt::format("{}: has no rates of transitions for --filter; expected a model of this version of 'tactile train', "
                    "train it again with --force",
                    bundle.folder.string()));
  }
  return {.transitions = *description.transitions, .history = description.settings.rendering.history, .alarm_cost = alarm_cost};
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
  if (decision.thresholds) {
    thresholds_.emplace(*decision.thresholds, tick);
  } else if (decision.filter) {
    filter_.emplace(*decision.filter, tick);
  }
}

Touch RunningDecision::next(Touch predicted, const Probabilities& probabilities) {
  if (thresholds_) return thresholds_->next(probabilities);
  return filter_ ? filter_->next(probabilities) : confirmation_.next(predicted);
}

void RunningDecision::skip(std::uint64_t ticks) {
  if (thresholds_) return thresholds_->skip(ticks);
  if (filter_) return filter_->skip(ticks);
  for (std::uint64_t i = std::min<std::uint64_t>(ticks, longest_); i > 0; --i) confirmation_.next(Touch::none);
}

void RunningDecision::restart() {
  if (thresholds_) thresholds_->restart();
  if (filter_) filter_->restart();
  confirmation_.restart();
}

}  // namespace tactile::model
