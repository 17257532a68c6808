#include "tactile/labels/posterior/run_states.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "tactile/labels/posterior/run_model_numbers.hpp"

namespace tactile::labels {
namespace {

using H = Happening;

enum class Phase : std::uint8_t { rest, rising, following, moving, stuck, smooth, even };

struct State {
  H happening;
  Phase phase;
  std::size_t level;
};

bool has_motion(H happening) { return happening != H::untouched && happening != H::held && happening != H::carried; }

/// Press, slip and release may last long with few events.
bool may_be_even(H happening) { return happening == H::press || happening == H::slip || happening == H::release; }

bool is_shear(H happening) { return happening == H::slip || happening == H::firm_shear; }

/// Shear whose events follow the arm's speed.
bool follows_arm(const State& state) { return state.phase == Phase::following; }

/// Of a state whose `level` is a gain: the level at 25 mm/s.
std::size_t level_at(const State& state, std::size_t arm_condition) {
  constexpr std::size_t at_gain = 5;
  if (!follows_arm(state) || !arm_moves(arm_condition)) return state.level;
  const std::size_t raised = state.level + speed_of_arm(arm_condition);
  return raised < at_gain ? 0 : std::min(raised - at_gain, motion_levels.size() - 1);
}

std::vector<State> all_states() {
  std::vector<State> states;
  for (std::size_t i = 0; i < happenings; ++i) {
    const auto happening = static_cast<H>(i);
    if (happening == H::untouched) {
      states.push_back({happening, Phase::rest, 0});
    } else if (!has_motion(happening)) {
      for (std::size_t level = 0; level <= numbers::creep_levels; ++level) states.push_back({happening, Phase::rest, level});
    } else {
      for (const Phase phase : {Phase::rising, Phase::moving}) {
        for (std::size_t level = 0; level < motion_levels.size(); ++level) states.push_back({happening, phase, level});
      }
    }
    if (is_shear(happening)) {
      for (std::size_t gain = 0; gain < motion_levels.size(); ++gain) states.push_back({happening, Phase::following, gain});
    }
    if (happening == H::slip) states.push_back({happening, Phase::stuck, 0}), states.push_back({happening, Phase::smooth, 0});
    if (may_be_even(happening)) {
      for (std::size_t level = 1; level <= 3; ++level) states.push_back({happening, Phase::even, level});
    }
  }
  return states;
}

using Rates = std::map<H, double>;  ///< [1/s]

/// The rate [1/s] of what happens in a bin with a probability.
double of_bin(double probability, double bin_s) { return -std::log(1 - probability) / bin_s; }

/// How often per second the arm's motion begins to shear the skin.
double shear_rate(std::size_t arm, double bin_s) {
  if (!arm_moves(arm)) return 0;
  if (arm == arm_starts) return of_bin(numbers::without_slack, bin_s);
  return arm_speeds[arm - 1] / numbers::slack_mm;
}

/// How often per second one happening ends in another.
Rates rates_from(const State& from, std::size_t arm, double bin_s) {
  const bool calm = from.level <= 2, moves = arm_moves(arm), stopped = arm == arm_stopped, unknown = arm == arm_unknown;
  const double sheared = shear_rate(arm, bin_s);
  switch (from.happening) {
    case H::untouched:
      return {{H::press, moves ? 0.02 : 0.5}, {H::knock, moves || stopped ? 0.5 : 0.04}};
    case H::press: {
      const double ends = from.phase == Phase::even ? 2 : from.level == 0 ? 2 : calm ? 10 : from.level == 3 ? 3 : 0.3;
      return {{H::held, ends}, {H::release, 0.05}, {H::slip, 0.02 + 0.7 * sheared}};
    }
    case H::held:
      if (moves)
        return {{H::slip, numbers::slips * sheared},
                {H::firm_shear, (1 - numbers::slips) * sheared},
                {H::disturbance, arm == arm_starts ? of_bin(numbers::start_shakes, bin_s) : 0.03},
                {H::press, 0.01},
                {H::release, 0.02},
                {H::untouched, 0.02}};
      if (unknown)
        return {{H::slip, 0.4},   {H::firm_shear, 0.1}, {H::disturbance, 0.1},
                {H::press, 0.05}, {H::release, 0.25},   {H::untouched, 0.02}};
      return {{H::slip, 0.02}, {H::disturbance, stopped ? 1 : 0.15}, {H::press, 0.01}, {H::release, 0.25}, {H::untouched, 0.02}};
    case H::carried:
      if (moves) return {{H::slip, 0.05}, {H::disturbance, 0.2}, {H::press, 0.005}, {H::release, 0.02}, {H::untouched, 0.1}};
      if (unknown) return {{H::slip, 0.2}, {H::disturbance, 0.1}, {H::release, 0.2}, {H::untouched, 0.05}, {H::held, 1}};
      return {{H::slip, 0.02},
              {H::disturbance, stopped ? 1 : 0.15},
              {H::release, 0.1},
              {H::untouched, 0.02},
              {H::held, stopped ? 50 : 2}};
    case H::slip: {
      const double ends = moves ? 0.03 : stopped ? 400 : unknown ? 2 : 6;
      return {{H::carried, calm ? ends : 0.3 * ends}, {H::untouched, 0.1}, {H::release, moves ? 0.02 : 0.2}};
    }
    case H::release:
      return {{H::untouched, from.phase == Phase::even ? 2 : calm ? 6 : 0.3}, {H::held, calm ? 0.3 : 0.02}, {H::press, 0.02}};
    case H::firm_shear:
      return {{H::carried, calm ? 20 : 8}, {H::slip, 0.1}};
    case H::knock:
      return {{H::untouched, calm ? 15 : 8}, {H::press, 0.05}};
    case H::disturbance:
      return {{H::held, calm ? 15 : 8}, {H::slip, moves ? numbers::slips * sheared : 0.05}, {H::release, 0.05}};
  }
  return {};
}

class Builder {
 public:
  Builder(microseconds bin, std::vector<State> states)
      : bin_s_(1e-6 * static_cast<double>(bin.count())), states_(std::move(states)) {}

  StateTransitions transitions(std::size_t arm) const {
    const std::size_t count = states_.size();
    std::vector<double> all(count * count, 0.0);
    for (std::size_t from = 0; from < count; ++from) {
      double stays = 1;
      const auto go = [&](const State& to, double probability) {
        if (probability > 0) all[from * count + index_of(to)] += probability;
      };
      leave(states_[from], arm, stays, go);
      wander(states_[from], [&](const State& to, double probability) { go(to, stays * probability); });
    }
    return sparse(all, count);
  }

  std::size_t index_of(const State& state) const {
    for (std::size_t i = 0; i < states_.size(); ++i) {
      const State& other = states_[i];
      if (other.happening == state.happening && other.phase == state.phase && other.level == state.level) return i;
    }
    return 0;
  }

 private:
  double within_bin(double mean_s) const { return 1 - std::exp(-bin_s_ / mean_s); }

  /// To other happenings and phases. @param stays  what remains
  template <class Go>
  void leave(const State& from, std::size_t arm, double& stays, Go go) const {
    std::vector<std::pair<State, double>> rates;
    const auto add = [&](const State& to, double rate) { rates.emplace_back(to, rate); };
    const bool moves = arm_moves(arm);
    if (from.phase == Phase::rising || from.phase == Phase::following) {
      if (follows_arm(from))
        add({from.happening, Phase::moving, level_at(from, arm)}, 1 / numbers::follows_arm_s);
      else
        add({from.happening, Phase::moving, from.level}, from.level >= 3 ? 100 : 5);
      const bool touches = from.happening != H::press && from.happening != H::knock;
      enter(touches ? H::held : H::untouched, 0.5, moves, add);
    } else {
      for (const auto& [happening, rate] : rates_from(from, arm, bin_s_)) enter(happening, rate, moves, add);
      const bool calm = from.level <= 2;
      if (from.phase == Phase::moving && may_be_even(from.happening))
        even_out(from.happening, (from.happening == H::press ? 0.3 : 1) * (calm ? 4 : 0.3), add);
      if (from.phase == Phase::moving && from.happening == H::slip)
        add({H::slip, Phase::stuck, 0}, calm ? 12 : 0.5), add({H::slip, Phase::smooth, 0}, calm ? 8 : 0.3);
      if (from.phase == Phase::smooth) rise(H::slip, Phase::moving, 0.3, moves, add);
      if (from.phase == Phase::even) {
        rise(from.happening, Phase::moving, 2, moves, add);
        if (from.happening == H::slip) add({H::slip, Phase::stuck, 0}, 1);
      }
      if (from.phase == Phase::stuck) {
        rise(H::slip, Phase::moving, 8, moves, add);
        even_out(H::slip, 0.5, add);
      }
    }
    double sum = 0;
    for (const auto& one : rates) sum += one.second;
    stays = std::exp(-sum * bin_s_);
    for (const auto& [to, rate] : rates) go(to, (1 - stays) * rate / sum);
  }

  template <class Add>
  void even_out(H happening, double rate, Add add) const {
    for (std::size_t level = 1; level <= 3; ++level) add({happening, Phase::even, level}, rate / 3);
  }

  template <class Add>
  void rise(H happening, Phase phase, double rate, bool while_arm_moves, Add add) const {
    const bool may_follow = phase == Phase::rising && is_shear(happening) && while_arm_moves;
    const double follows = may_follow ? 0.5 : 0;
    for (std::size_t level = 0; level < motion_levels.size(); ++level) {
      const double sharp = level < 3 ? 0 : 1.0 / (motion_levels.size() - 3);
      add({happening, phase, level}, rate * (may_follow ? (1 - follows) * sharp : numbers::first_level[level]));
      if (may_follow) add({happening, Phase::following, level}, follows * rate / motion_levels.size());
    }
  }

  template <class Add>
  void enter(H happening, double rate, bool while_arm_moves, Add add) const {
    if (happening == H::untouched) return add({happening, Phase::rest, 0}, rate);
    if (has_motion(happening)) return rise(happening, Phase::rising, rate, while_arm_moves, add);
    for (std::size_t level = 0; level <= numbers::creep_levels; ++level)
      add({happening, Phase::rest, level}, rate * numbers::creep_after[level]);
  }

  /// From one level of motion to another. The probabilities sum to 1.
  template <class Go>
  void wander(const State& from, Go go) const {
    const auto at = [&](std::size_t level) { return State{from.happening, from.phase, level}; };
    if (from.phase == Phase::rest) {
      const double falls = from.level > 0 ? within_bin(numbers::creep_s) : 0;
      go(from, 1 - falls);
      if (falls > 0) go(at(from.level - 1), falls);
    } else if (from.phase == Phase::stuck || from.phase == Phase::smooth) {
      go(from, 1);
    } else if (from.phase == Phase::even) {
      const double changes = within_bin(numbers::slides_s);
      go(from, 1 - changes);
      if (from.level == 2)
        go(at(1), 0.5 * changes), go(at(3), 0.5 * changes);
      else
        go(at(2), changes);
    } else if (follows_arm(from)) {
      const double falls = from.level > 0 ? within_bin(numbers::follows_arm_s) : 0;
      const double rises = from.level + 1 < motion_levels.size() ? (1 - falls) * within_bin(numbers::gain_grows_s) : 0;
      go(from, 1 - falls - rises);
      if (falls > 0) go(at(from.level - 1), falls);
      if (rises > 0) go(at(from.level + 1), rises);
    } else if (from.phase == Phase::rising) {
      const double rises = from.level + 1 < motion_levels.size() ? within_bin(numbers::rise_s) : 0;
      go(from, 1 - rises);
      if (rises > 0)
        go(at(from.level + 1), 0.75 * rises), go(at(std::min(from.level + 2, motion_levels.size() - 1)), 0.25 * rises);
    } else {
      const double changes = within_bin(numbers::level_lasts_s[std::min<std::size_t>(from.level, 4)]);
      double sum = 0;
      const auto weight = [&](std::size_t level) { return level + 1 == from.level || level == from.level + 1 ? 1.0 : 0.1; };
      for (std::size_t level = 0; level < motion_levels.size(); ++level) sum += level == from.level ? 0 : weight(level);
      for (std::size_t level = 0; level < motion_levels.size(); ++level)
        go(at(level), level == from.level ? 1 - changes : changes * weight(level) / sum);
    }
  }

  static StateTransitions sparse(const std::vector<double>& all, std::size_t count) {
    StateTransitions made;
    for (std::size_t i = 0; i < count; ++i) {
      made.first_to.push_back(static_cast<std::uint32_t>(made.to.size()));
      made.first_from.push_back(static_cast<std::uint32_t>(made.from.size()));
      for (std::size_t k = 0; k < count; ++k) {
        if (const double p = all[i * count + k]; p > 0)
          made.to.push_back(static_cast<std::uint16_t>(k)), made.to_probability.push_back(p);
        if (const double p = all[k * count + i]; p > 0)
          made.from.push_back(static_cast<std::uint16_t>(k)), made.from_probability.push_back(p);
      }
    }
    made.first_to.push_back(static_cast<std::uint32_t>(made.to.size()));
    made.first_from.push_back(static_cast<std::uint32_t>(made.from.size()));
    return made;
  }

  double bin_s_;
  std::vector<State> states_;
};

}  // namespace

RunStates::RunStates(microseconds bin) {
  const std::vector<State> states = all_states();
  for (const State& state : states) {
    happening_of_.push_back(state.happening);
    for (std::size_t arm = 0; arm < arm_conditions; ++arm) level_of_.push_back(static_cast<std::uint8_t>(level_at(state, arm)));
  }
  const Builder builder(bin, states);
  for (std::size_t arm = 0; arm < arm_conditions; ++arm) transitions_[arm] = builder.transitions(arm);
  at_start_.assign(states.size(), 0.0);
  const auto begins = [&](H happening, Phase phase, std::size_t level, double probability) {
    at_start_[builder.index_of({happening, phase, level})] = probability;
  };
  begins(H::untouched, Phase::rest, 0, 0.93);
  begins(H::held, Phase::rest, 0, 0.04);
  begins(H::press, Phase::moving, 4, 0.01);
  begins(H::slip, Phase::moving, 3, 0.005);
  begins(H::release, Phase::moving, 3, 0.005);
  begins(H::knock, Phase::moving, 1, 0.01);
}

}  // namespace tactile::labels
