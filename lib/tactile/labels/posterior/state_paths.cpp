#include "tactile/labels/posterior/state_paths.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tactile::labels {
namespace {

/// How likely an arm begins to move, relative to an object that is held.
double arm_begins(Happening happening) {
  switch (happening) {
    case Happening::held:
    case Happening::carried:
      return 1;
    case Happening::untouched:
      return 0.05;
    default:
      return 0.2;
  }
}

/// The probabilities of the next bin, before its events are looked at. States below 1e-11 are left out.
void go_on(const StateTransitions& moves, const std::vector<double>& now, std::vector<double>& next) {
  constexpr double negligible = 1e-11;
  std::array<double, StateTransitions::most_entries> entered{};
  std::fill(next.begin(), next.end(), 0.0);
  for (std::size_t from = 0; from < now.size(); ++from) {
    const double p = now[from];
    if (p < negligible) continue;
    for (const StateTransitions::Step& step : moves.within.of(from)) next[step.to] += p * step.probability;
    for (const StateTransitions::Step& step : moves.leaving.of(from)) entered[step.to] += p * step.probability;
  }
  for (std::size_t entry = 0; entry < moves.entering.rows(); ++entry) {
    if (entered[entry] == 0) continue;
    for (const StateTransitions::Step& step : moves.entering.of(entry)) next[step.to] += entered[entry] * step.probability;
  }
}

}  // namespace

BinLikelihoods::BinLikelihoods(std::span<const double> of_level, std::span<const double> of_pattern) {
  const std::size_t bins = of_level.size() / motion_levels.size();
  relative_.resize(bins * classes);
  log_largest_.resize(bins);
  for (std::size_t bin = 0; bin < bins; ++bin) {
    double* of = &relative_[bin * classes];
    double largest = -1e300;
    for (const Happening happening : {Happening::press, Happening::release, Happening::slip}) {
      for (std::size_t level = 0; level < motion_levels.size(); ++level) {
        double& one = of[class_of(happening, level)];
        one = of_level[bin * motion_levels.size() + level];
        if (level > 0 && !of_pattern.empty()) one += of_pattern[bin * happenings + static_cast<std::size_t>(happening)];
        largest = std::max(largest, one);
      }
    }
    for (std::size_t i = 0; i < classes; ++i) of[i] = std::exp(of[i] - largest);
    log_largest_[bin] = largest;
  }
}

std::size_t BinLikelihoods::class_of(Happening happening, std::size_t level) {
  if (level == 0) return 0;
  const std::size_t pattern = happening == Happening::press ? 0 : happening == Happening::release ? 1 : 2;
  return pattern * motion_levels.size() + level;
}

Filtered filtered(const RunStates& states, const BinLikelihoods& likelihoods, std::span<const std::uint8_t> arm_conditions_of,
                  bool keep) {
  const std::size_t count = states.count(), bins = likelihoods.bins();
  Filtered result;
  if (keep) result.states.resize(bins * count);
  std::vector<double> now = states.at_start(), next(count);
  std::vector<std::size_t> classes(arm_conditions * count);
  for (std::size_t i = 0; i < classes.size(); ++i) {
    const std::size_t state = i % count;
    classes[i] =
        BinLikelihoods::class_of(states.happening_of(state), states.level_of(state, static_cast<std::uint8_t>(i / count)));
  }
  for (std::size_t bin = 0; bin < bins; ++bin) {
    if (bin > 0) {
      go_on(states.transitions(arm_conditions_of[bin]), now, next);
      now.swap(next);
    }
    const double* relative = likelihoods.at(bin);
    double sum = 0;
    const std::size_t* class_of = &classes[arm_conditions_of[bin] * count];
    const bool begins = bin > 0 && arm_moves(arm_conditions_of[bin]) && !arm_moves(arm_conditions_of[bin - 1]);
    if (begins) {
      for (std::size_t s = 0; s < count; ++s) now[s] *= arm_begins(states.happening_of(s));
    }
    for (std::size_t s = 0; s < count; ++s) sum += now[s] *= relative[class_of[s]];
    for (double& one : now) one /= sum;
    result.log_evidence += std::log(sum) + likelihoods.log_largest(bin);
    if (keep) std::transform(now.begin(), now.end(), &result.states[bin * count], [](double p) { return static_cast<float>(p); });
  }
  return result;
}

std::vector<std::uint16_t> drawn_path(const RunStates& states, const Filtered& filtered,
                                      std::span<const std::uint8_t> arm_conditions_of, Random& random) {
  const std::size_t count = states.count(), bins = filtered.states.size() / count;
  std::vector<std::uint16_t> path(bins);
  double left = random.uniform();
  const float* last = &filtered.states[(bins - 1) * count];
  for (std::size_t s = 0; s < count; ++s) {
    path.back() = static_cast<std::uint16_t>(s);
    if ((left -= last[s]) < 0) break;
  }
  for (std::size_t bin = bins - 1; bin > 0; --bin) {
    const StateTransitions& moves = states.transitions(arm_conditions_of[bin]);
    const float* before = &filtered.states[(bin - 1) * count];
    const std::uint16_t to = path[bin];
    double sum = 0;
    for (const StateTransitions::Step& step : moves.backwards.of(to)) sum += before[step.to] * step.probability;
    double rest = random.uniform() * sum;
    std::uint16_t from = to;
    for (const StateTransitions::Step& step : moves.backwards.of(to)) {
      const double p = before[step.to] * step.probability;
      if (p > 0) from = step.to;
      if ((rest -= p) < 0) break;
    }
    path[bin - 1] = from;
  }
  return path;
}

}  // namespace tactile::labels
