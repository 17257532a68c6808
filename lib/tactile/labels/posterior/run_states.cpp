#include "tactile/labels/posterior/run_states.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>

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

/// How often per second one happening ends in another, if a film shows whether anything moves.
Rates rates_in_film(const State& from, bool moves) {
  const bool calm = from.level <= 2;
  switch (from.happening) {
    case H::untouched:
      return {{H::press, moves ? 2 : 0.05}, {H::knock, moves ? 0.2 : 0.04}};
    case H::held:
      if (moves)
        return {{H::slip, 3 * numbers::slips},
                {H::firm_shear, 3 * (1 - numbers::slips)},
                {H::disturbance, 0.1},
                {H::press, 0.05},
                {H::release, 1},
                {H::untouched, 0.02}};
      return {{H::slip, 0.005}, {H::disturbance, 0.15}, {H::press, 0.01}, {H::release, 0.05}, {H::untouched, 0.02}};
    case H::carried:
      if (moves) return {{H::slip, 0.2}, {H::disturbance, 0.2}, {H::release, 0.5}, {H::untouched, 0.1}, {H::held, 0.1}};
      return {{H::slip, 0.005}, {H::disturbance, 0.3}, {H::release, 0.05}, {H::untouched, 0.02}, {H::held, 2}};
    case H::slip:
      return {{H::carried, (calm ? 1 : 0.3) * (moves ? 0.5 : 20)}, {H::untouched, 0.1}, {H::release, 0.2}};
    default:
      return {};
  }
}

/// How often per second one happening ends in another, if the IMU shows whether the camera moves. It does not feel a slow lift.
Rates rates_felt(const State& from, bool moves) {
  const bool calm = from.level <= 2;
  switch (from.happening) {
    case H::untouched:
      return {{H::press, moves ? 0.3 : 0.5}, {H::knock, moves ? 0.3 : 0.04}};
    case H::held:
      if (moves)
        return {{H::slip, 3 * numbers::slips},
                {H::firm_shear, 3 * (1 - numbers::slips)},
                {H::disturbance, 0.1},
                {H::press, 0.05},
                {H::release, 0.1},
                {H::untouched, 0.02}};
      return {{H::slip, 0.05}, {H::disturbance, 0.1}, {H::press, 0.02}, {H::release, 0.25}, {H::untouched, 0.02}};
    case H::carried:
      if (moves) return {{H::slip, 0.2}, {H::disturbance, 0.2}, {H::release, 0.1}, {H::untouched, 0.1}, {H::held, 0.1}};
      return {{H::slip, 0.02}, {H::disturbance, 0.15}, {H::release, 0.1}, {H::untouched, 0.02}, {H::held, 2}};
    case H::slip:
      return {{H::carried, (calm ? 1 : 0.3) * (moves ? 0.5 : 6)}, {H::untouched, 0.1}, {H::release, 0.2}};
    default:
      return {};
  }
}

/// How often per second one happening ends in another.
Rates rates_from(const State& from, std::size_t arm, double bin_s) {
  const bool calm = from.level <= 2, moves = arm_moves(arm), stopped = arm == arm_stopped, unknown = arm == arm_unknown;
  const double sheared = shear_rate(arm, bin_s);
  if (arm == arm_taps && from.happening == H::untouched) return {{H::knock, 10}, {H::press, 0.05}};
  if (arm == arm_taps && from.happening == H::held)
    return {{H::disturbance, 5}, {H::slip, 0.1}, {H::release, 0.25}, {H::untouched, 0.02}};
  if (arm == film_still || arm == film_moves) {
    if (Rates rates = rates_in_film(from, arm == film_moves); !rates.empty()) return rates;
  }
  if (arm == camera_still || arm == camera_moves) {
    if (Rates rates = rates_felt(from, arm == camera_moves); !rates.empty()) return rates;
  }
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
      return {{H::slip, 0.005}, {H::disturbance, stopped ? 1 : 0.15}, {H::press, 0.01}, {H::release, 0.25}, {H::untouched, 0.02}};
    case H::carried:
      if (moves) return {{H::slip, 0.05}, {H::disturbance, 0.2}, {H::press, 0.005}, {H::release, 0.02}, {H::untouched, 0.1}};
      if (unknown) return {{H::slip, 0.2}, {H::disturbance, 0.1}, {H::release, 0.2}, {H::untouched, 0.05}, {H::held, 1}};
      return {{H::slip, 0.005},
              {H::disturbance, stopped ? 1 : 0.15},
              {H::release, 0.1},
              {H::untouched, 0.02},
              {H::held, stopped ? 50 : 2}};
    case H::slip: {
      const double ends = moves ? 0.03 : stopped ? 400 : unknown ? 2 : 6;
      return {{H::carried, calm ? ends : 0.3 * ends}, {H::untouched, 0.1}, {H::release, moves ? 0.02 : 0.2}};
    }
    case H::release:
      return {{H::untouched, from.phase == Phase::even ? 0.7 : calm ? 4 : 0.3}, {H::held, calm ? 0.3 : 0.02}, {H::press, 0.02}};
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
  Builder(microseconds bin, bool several_runs, std::vector<State> states)
      : bin_s_(1e-6 * static_cast<double>(bin.count())), several_runs_(several_runs), states_(std::move(states)) {}

  StateTransitions transitions(std::size_t arm) {
    const std::size_t count = states_.size();
    entries_.clear();
    constexpr std::size_t most_entries = StateTransitions::most_entries;
    std::vector<double> all(count * count, 0.0), left(count * most_entries, 0.0);
    StateTransitions made;
    for (std::size_t from = 0; from < count; ++from) {
      const auto row = std::span(all).subspan(from * count, count),
                 entries = std::span(left).subspan(from * most_entries, most_entries);
      const double stays = leave(states_[from], arm, row, entries);
      wander(states_[from], [&](const State& to, double probability) { row[index_of(to)] += stays * probability; });
      made.within.add_row(row);
      made.leaving.add_row(entries);
    }
    for (const Entry& entry : entries_) made.entering.add_row(entry.to);
    for (std::size_t from = 0; from < count; ++from) {
      for (std::size_t e = 0; e < entries_.size(); ++e) {
        const double share = left[from * most_entries + e];
        for (std::size_t to = 0; share > 0 && to < count; ++to) all[from * count + to] += share * entries_[e].to[to];
      }
    }
    std::vector<double> column(count);
    for (std::size_t to = 0; to < count; ++to) {
      for (std::size_t from = 0; from < count; ++from) column[from] = all[from * count + to];
      made.backwards.add_row(column);
    }
    return made;
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

  /// Where a happening or a phase of it begins: a distribution of states.
  struct Entry {
    H happening;
    Phase phase;
    std::vector<double> to;
  };

  /// The entry with this happening and phase; a new one if there is none yet. @param fill  sets the probability of each state
  template <class Fill>
  std::size_t entry_of(H happening, Phase phase, Fill fill) {
    for (std::size_t e = 0; e < entries_.size(); ++e) {
      if (entries_[e].happening == happening && entries_[e].phase == phase) return e;
    }
    Entry& entry = entries_.emplace_back(Entry{happening, phase, std::vector<double>(states_.size(), 0.0)});
    fill([&](const State& state, double probability) { entry.to[index_of(state)] += probability; });
    return entries_.size() - 1;
  }

  /// To other happenings and phases. @param row  by state  @param entries  by entry. @return  the probability to stay
  double leave(const State& from, std::size_t arm, std::span<double> row, std::span<double> entries) {
    std::vector<std::pair<double*, double>> rates;
    const auto add = [&](std::size_t entry, double rate) { rates.emplace_back(&entries[entry], rate); };
    const auto add_state = [&](const State& to, double rate) { rates.emplace_back(&row[index_of(to)], rate); };
    const bool moves = arm_moves(arm), calm = from.level <= 2, is_known = arm == arm_still || arm == arm_stopped;
    if (from.phase == Phase::rising || from.phase == Phase::following) {
      if (follows_arm(from))
        add_state({from.happening, Phase::moving, level_at(from, arm)}, 1 / numbers::follows_arm_s);
      else
        add_state({from.happening, Phase::moving, from.level}, from.level >= 3 ? 100 : 5);
      const bool touches = from.happening != H::press && from.happening != H::knock;
      add(enter(touches ? H::held : H::untouched, moves), 0.5);
    } else {
      Rates others = rates_from(from, arm, bin_s_);
      if (several_runs_ && is_known && from.happening == H::held) others[H::untouched] = numbers::held_object_leaves;
      if (several_runs_ && !moves && from.happening == H::carried) {
        others[H::untouched] = numbers::carried_object_leaves;
        if (!is_known) others.erase(H::held);  // another lift would not be known
      }
      for (const auto& [happening, rate] : others) add(enter(happening, moves), rate);
      if (from.phase == Phase::moving && may_be_even(from.happening))
        add(even(from.happening), (from.happening == H::press ? 0.3 : 1) * (calm ? 4 : 0.3));
      if (from.phase == Phase::moving && from.happening == H::slip)
        add_state({H::slip, Phase::stuck, 0}, calm ? 12 : 0.5), add_state({H::slip, Phase::smooth, 0}, calm ? 2 : 0.1);
      if (from.phase == Phase::smooth) add(rise(H::slip, Phase::moving, moves), 0.3);
      if (from.phase == Phase::even) add(rise(from.happening, Phase::moving, moves), 2);
      if (from.phase == Phase::even && from.happening == H::slip) add_state({H::slip, Phase::stuck, 0}, 1);
      if (from.phase == Phase::stuck) add(rise(H::slip, Phase::moving, moves), 8), add(even(H::slip), 0.5);
    }
    double sum = 0;
    for (const auto& one : rates) sum += one.second;
    const double stays = std::exp(-sum * bin_s_);
    for (const auto& [probability, rate] : rates) *probability += (1 - stays) * rate / sum;
    return stays;
  }

  std::size_t even(H happening) {
    return entry_of(happening, Phase::even, [&](auto put) {
      for (std::size_t level = 1; level <= 3; ++level) put({happening, Phase::even, level}, 1.0 / 3);
    });
  }

  std::size_t rise(H happening, Phase phase, bool while_arm_moves) {
    return entry_of(happening, phase, [&](auto put) {
      const bool may_follow = phase == Phase::rising && is_shear(happening) && while_arm_moves;
      const double follows = may_follow ? 0.5 : 0;
      for (std::size_t level = 0; level < motion_levels.size(); ++level) {
        const double sharp = level < 3 ? 0 : 1.0 / (motion_levels.size() - 3);
        put({happening, phase, level}, may_follow ? (1 - follows) * sharp : numbers::first_level[level]);
        if (may_follow) put({happening, Phase::following, level}, follows / motion_levels.size());
      }
    });
  }

  std::size_t enter(H happening, bool while_arm_moves) {
    if (happening == H::untouched)
      return entry_of(happening, Phase::rest, [&](auto put) { put({happening, Phase::rest, 0}, 1); });
    if (has_motion(happening)) return rise(happening, Phase::rising, while_arm_moves);
    return entry_of(happening, Phase::rest, [&](auto put) {
      for (std::size_t level = 0; level <= numbers::creep_levels; ++level)
        put({happening, Phase::rest, level}, numbers::creep_after[level]);
    });
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

  double bin_s_;
  bool several_runs_;
  std::vector<State> states_;
  std::vector<Entry> entries_;  ///< for one condition of the arm
};

}  // namespace

void StateTransitions::Steps::add_row(std::span<const double> row) {
  for (std::size_t to = 0; to < row.size(); ++to) {
    if (row[to] > 0) steps_.push_back({static_cast<std::uint16_t>(to), row[to]});
  }
  first_.push_back(static_cast<std::uint32_t>(steps_.size()));
}

RunStates::RunStates(microseconds bin, bool several_runs) {
  const std::vector<State> states = all_states();
  for (const State& state : states) {
    happening_of_.push_back(state.happening);
    for (std::size_t arm = 0; arm < arm_conditions; ++arm) level_of_.push_back(static_cast<std::uint8_t>(level_at(state, arm)));
  }
  Builder builder(bin, several_runs, states);
  for (std::size_t arm = 0; arm < arm_conditions; ++arm) transitions_[arm] = builder.transitions(arm);
  at_start_.assign(states.size(), 0.0);
  const auto begins = [&](H happening, Phase phase, std::size_t level, double probability) {
    at_start_[builder.index_of({happening, phase, level})] = probability;
  };
  begins(H::untouched, Phase::rest, 0, 0.93);
  begins(H::held, Phase::rest, 0, 0.04);
  for (std::size_t level = 1; level < motion_levels.size(); ++level) {
    for (const auto& [happening, probability] :
         {std::pair{H::press, 0.01}, {H::slip, 0.005}, {H::release, 0.005}, {H::knock, 0.01}})
      begins(happening, Phase::moving, level, probability / (motion_levels.size() - 1));
  }
}

}  // namespace tactile::labels
