#include "tactile/labels/posterior/state_paths.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

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

/// Steps of the forward and the backward pass, from bin to bin.
class Passes {
 public:
  Passes(const RunStates& states, const BinLikelihoods& likelihoods)
      : states_(states), likelihoods_(likelihoods), classes_(arm_conditions * states.count()), other_(states.count()) {
    for (std::size_t i = 0; i < classes_.size(); ++i) {
      const std::size_t state = i % states.count();
      classes_[i] = BinLikelihoods::class_of(states.happening_of(state),
                                             states.level_of(state, static_cast<std::uint8_t>(i / states.count())));
    }
  }

  /// @param now  the probabilities in the bin before, normalised, those at the start before bin 0; then in `bin`
  /// @return     ln p(events of the bin | those before)
  double forward(std::vector<double>& now, std::size_t bin, std::span<const std::uint8_t> conditions) {
    if (bin > 0) {
      go_on(states_.transitions(conditions[bin]), now);
      now.swap(other_);
    }
    double sum = 0;
    see(now, bin, conditions);
    for (const double p : now) sum += p;
    for (double& p : now) p /= sum;
    return std::log(sum) + likelihoods_.log_largest(bin);
  }

  /// @param later  p(events after the bin | state in `bin`) but for a factor; then of the bin before, which must exist
  /// @return       the logarithm of the factor by which it was divided
  double backward(std::vector<double>& later, std::size_t bin, std::span<const std::uint8_t> conditions) {
    see(later, bin, conditions);
    const StateTransitions& moves = states_.transitions(conditions[bin]);
    std::array<double, StateTransitions::most_entries> entered{};
    for (std::size_t entry = 0; entry < moves.entering.rows(); ++entry) {
      for (const StateTransitions::Step& step : moves.entering.of(entry)) entered[entry] += later[step.to] * step.probability;
    }
    double largest = 0;
    for (std::size_t from = 0; from < later.size(); ++from) {
      double sum = 0;
      for (const StateTransitions::Step& step : moves.within.of(from)) sum += later[step.to] * step.probability;
      for (const StateTransitions::Step& step : moves.leaving.of(from)) sum += entered[step.to] * step.probability;
      other_[from] = sum;
      largest = std::max(largest, sum);
    }
    for (double& p : other_) p /= largest;
    later.swap(other_);
    return std::log(largest) + likelihoods_.log_largest(bin);
  }

 private:
  /// The probabilities of the next bin, before its events are looked at. States below 1e-11 are left out.
  void go_on(const StateTransitions& moves, const std::vector<double>& now) {
    constexpr double negligible = 1e-11;
    std::array<double, StateTransitions::most_entries> entered{};
    std::fill(other_.begin(), other_.end(), 0.0);
    for (std::size_t from = 0; from < now.size(); ++from) {
      const double p = now[from];
      if (p < negligible) continue;
      for (const StateTransitions::Step& step : moves.within.of(from)) other_[step.to] += p * step.probability;
      for (const StateTransitions::Step& step : moves.leaving.of(from)) entered[step.to] += p * step.probability;
    }
    for (std::size_t entry = 0; entry < moves.entering.rows(); ++entry) {
      if (entered[entry] == 0) continue;
      for (const StateTransitions::Step& step : moves.entering.of(entry)) other_[step.to] += entered[entry] * step.probability;
    }
  }

  /// Multiplies by what the bin's events say, and by how likely the arm begins to move in it.
  void see(std::vector<double>& states, std::size_t bin, std::span<const std::uint8_t> conditions) const {
    const double* relative = likelihoods_.at(bin);
    const std::size_t* class_of = &classes_[conditions[bin] * states.size()];
    if (bin > 0 && arm_moves(conditions[bin]) && !arm_moves(conditions[bin - 1])) {
      for (std::size_t s = 0; s < states.size(); ++s) states[s] *= arm_begins(states_.happening_of(s));
    }
    for (std::size_t s = 0; s < states.size(); ++s) states[s] *= relative[class_of[s]];
  }

  const RunStates& states_;
  const BinLikelihoods& likelihoods_;
  std::vector<std::size_t> classes_;  ///< of the likelihoods, [condition, state]
  std::vector<double> other_;
};

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
  Passes passes(states, likelihoods);
  std::vector<double> now = states.at_start();
  for (std::size_t bin = 0; bin < bins; ++bin) {
    result.log_evidence += passes.forward(now, bin, arm_conditions_of);
    if (keep) std::transform(now.begin(), now.end(), &result.states[bin * count], [](double p) { return static_cast<float>(p); });
  }
  return result;
}

std::vector<double> log_evidences(const RunStates& states, const BinLikelihoods& likelihoods,
                                  const std::vector<std::vector<std::uint8_t>>& conditions_of) {
  if (conditions_of.empty()) return {};
  const std::size_t bins = likelihoods.bins();
  const std::vector<std::uint8_t>& first = conditions_of.front();
  const auto is_common = [&](std::size_t bin) {
    return std::all_of(conditions_of.begin(), conditions_of.end(), [&](const auto& other) { return other[bin] == first[bin]; });
  };
  std::size_t begin = 0, end = bins;  // in [begin, end) they may differ
  while (begin < bins && is_common(begin)) ++begin;
  while (end > begin && is_common(end - 1)) --end;

  Passes passes(states, likelihoods);
  std::vector<double> before = states.at_start(), after(states.count(), 1.0);
  double common = 0;
  for (std::size_t bin = 0; bin < begin; ++bin) common += passes.forward(before, bin, first);
  for (std::size_t bin = bins - 1; bin > end && bin < bins; --bin) common += passes.backward(after, bin, first);
  std::map<std::vector<std::uint8_t>, double> known;  // a log that rests during the recording says the same for many offsets
  std::vector<double> evidences;
  evidences.reserve(conditions_of.size());
  for (const std::vector<std::uint8_t>& conditions : conditions_of) {
    const auto [found, is_new] = known.try_emplace(conditions, common);
    if (is_new) {
      std::vector<double> now = before;
      for (std::size_t bin = begin; bin < std::min(bins, end + 1); ++bin) found->second += passes.forward(now, bin, conditions);
      found->second += std::log(std::inner_product(now.begin(), now.end(), after.begin(), 0.0));
    }
    evidences.push_back(found->second);
  }
  return evidences;
}

std::vector<Path> drawn_paths(const RunStates& states, const Filtered& filtered, std::span<const std::uint8_t> arm_conditions_of,
                              std::size_t paths, Random& random) {
  const std::size_t count = states.count(), bins = filtered.states.size() / count;
  std::vector<Path> drawn(paths, Path(bins));
  // Where each state may come from, and the sum of the probabilities up to there. All paths that meet in it need the same.
  struct Origin {
    std::uint16_t from;
    double until;
  };
  std::vector<std::vector<Origin>> origins(count);
  const auto draw_from = [&](const std::vector<Origin>& all) {
    const double left = random.uniform() * all.back().until;
    const auto found = std::upper_bound(all.begin(), all.end(), left, [](double p, const Origin& one) { return p < one.until; });
    return (found == all.end() ? all.back() : *found).from;
  };
  std::vector<Origin> at_end;
  const float* last = &filtered.states[(bins - 1) * count];
  for (std::size_t s = 0; s < count; ++s)
    at_end.push_back({static_cast<std::uint16_t>(s), last[s] + (at_end.empty() ? 0 : at_end.back().until)});
  for (Path& path : drawn) path.back() = draw_from(at_end);
  for (std::size_t bin = bins - 1; bin > 0; --bin) {
    const StateTransitions& moves = states.transitions(arm_conditions_of[bin]);
    const float* before = &filtered.states[(bin - 1) * count];
    for (std::vector<Origin>& one : origins) one.clear();
    for (Path& path : drawn) {
      std::vector<Origin>& from = origins[path[bin]];
      if (from.empty()) {
        double sum = 0;
        for (const StateTransitions::Step& step : moves.backwards.of(path[bin])) {
          const double p = before[step.to] * step.probability;
          if (p > 0) from.push_back({step.to, sum += p});
        }
        if (from.empty()) from.push_back({path[bin], 1.0});
      }
      path[bin - 1] = draw_from(from);
    }
  }
  return drawn;
}

}  // namespace tactile::labels
