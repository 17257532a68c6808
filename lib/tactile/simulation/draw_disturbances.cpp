#include "tactile/simulation/draw_disturbances.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace tactile::simulation {
namespace {

constexpr double after_lift_s = 0.02;

/// The times in which a press holds the object and nothing is to be labelled.
std::vector<std::pair<double, double>> held_times(const RunPlan& plan, const PressPlan& press) {
  const double from_s = std::max(0.0, press.still_s()), to_s = press.release_start_s.value_or(plan.end_s);
  if (!plan.lift || plan.press_at(plan.lift->start_s) != &press) return {{from_s, to_s}};
  return {{from_s, plan.lift->start_s}, {plan.lift->end_s() + after_lift_s, to_s}};
}

/// Each of `touched` with the chance `share`; at least one, and not all if there are several and `not_all`.
unsigned draw_some(unsigned touched, double share, bool not_all, Random& random) {
  unsigned some = 0;
  for (std::size_t m = 0; m < marker_count; ++m) {
    if ((touched >> m & 1U) != 0 && random.uniform() < share) some |= 1U << m;
  }
  const unsigned first = touched & (~touched + 1U);
  if (some == 0) return first;
  return not_all && some == touched && std::popcount(touched) > 1 ? some & ~first : some;
}

void draw_slips(RunPlan& plan, const ObjectModel& object, const RunPlanOptions& options, const PressPlan& press, double from_s,
                double to_s, Random& random) {
  const AfterEffects& after = options.after;
  const RunVariation& variation = options.variation;
  const unsigned touched = touched_markers(press);
  if (touched == 0) return;
  const auto draw_times = [&](double per_s, const auto& draw) {
    for (double t_s = from_s; per_s > 0;) {
      t_s += random.exponential() / per_s;
      if (!(t_s < to_s)) return;
      draw(t_s);
    }
  };
  draw_times(after.free_micro_slips_per_s, [&](double t_s) {
    const double ring_hz =
        std::clamp(varied(object.ring_hz, variation.ring_hz_spread, random), variation.ring_hz.low, variation.ring_hz.high);
    plan.micro_slips.push_back({.at_s = t_s,
                                .markers = draw_some(touched, after.micro_slip_share, false, random),
                                .slip_mm = drawn(after.micro_slip_mm, random),
                                .ring_hz = ring_hz,
                                .ring_decay_s = 1e-3 * varied(object.ring_decay_ms, variation.ring_decay_spread, random)});
  });
  draw_times(after.partial_slips_per_s, [&](double t_s) {
    plan.micro_slips.push_back({.at_s = t_s,
                                .slip_s = drawn(after.partial_slip_s, random),
                                .markers = draw_some(touched, after.micro_slip_share, true, random),
                                .slip_mm = drawn(after.partial_slip_mm, random)});
  });
}

void draw_turn(RunPlan& plan, const AfterEffects& after, Random& random) {
  const bool turns = random.uniform() < after.turn_chance;
  TurnPlan turn{.start_s = 0, .turn_s = drawn(after.turn_s, random), .angle_rad = drawn(after.turn_rad, random)};
  if (random.uniform() < 0.5) turn.angle_rad = -turn.angle_rad;
  const PressPlan& press = plan.presses.back();
  const double from_s = std::max(0.0, press.still_s()), to_s = press.release_start_s.value_or(plan.end_s) - turn.turn_s;
  turn.start_s = random.uniform(from_s, std::max(from_s, to_s));
  if (turns && to_s > from_s) plan.turns.push_back(turn);
}

}  // namespace

unsigned touched_markers(const PressPlan& press) {
  unsigned touched = 0;
  for (std::size_t m = 0; m < marker_count; ++m) {
    if (press.depth_mm - press.markers[m].gap_mm > least_pressed_mm) touched |= 1U << m;
  }
  return touched;
}

void draw_disturbances(RunPlan& plan, const ObjectModel& object, const RunPlanOptions& options, Random& random) {
  plan.hysteresis_share = drawn(options.after.hysteresis_share, random);
  plan.hysteresis_s = drawn(options.after.hysteresis_s, random);
  plan.light_drift = {.amplitude = drawn(options.variation.light_drift, random),
                      .period_s = drawn(options.variation.light_drift_s, random),
                      .phase_rad = random.uniform(0, 2.0 * std::numbers::pi)};
  draw_turn(plan, options.after, random);
  for (const PressPlan& press : plan.presses) {
    for (const auto& [from_s, to_s] : held_times(plan, press)) draw_slips(plan, object, options, press, from_s, to_s, random);
  }
}

}  // namespace tactile::simulation
