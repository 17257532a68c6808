#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "tactile/simulation/draw_disturbances.hpp"
#include "tactile/simulation/run_plan.hpp"

namespace tactile::simulation {
namespace {

/// @param use  draws for another use are independent
RepeatedRandom repeated(const RunPlanOptions& options, std::string_view use, Random& run) {
  return {seed_for(options.object_seed, {use}), options.variation.new_share, run};
}

std::array<MarkerContact, marker_count> draw_contacts(const ObjectModel& object, const RunVariation& variation, double depth_mm,
                                                      RepeatedRandom& random) {
  const double centre_x = cut_normal(variation.centre_mm, random), centre_y = cut_normal(variation.centre_mm, random);
  const double tilt_x = cut_normal(object.tilt, random), tilt_y = cut_normal(object.tilt, random);
  const double pull = drawn(variation.pull, random);
  const double skid_x = cut_normal(variation.skid, random), skid_y = cut_normal(variation.skid, random);
  std::array<MarkerContact, marker_count> markers;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < marker_count; ++i) {
    const double dx = marker_x_mm(i) - centre_x, dy = marker_y_mm(i) - centre_y;
    const double reach = std::max(std::hypot(dx, dy), 1e-9), full = std::min(1.0, reach / variation.pull_full_mm);
    MarkerContact& marker = markers[i];
    marker.gap_mm = tilt_x * dx + tilt_y * dy + cut_normal(object.irregularity_mm, random);
    if (object.radius_mm > 0) marker.gap_mm += dx * dx / (2.0 * object.radius_mm);
    const double beyond = std::max({0.0, std::abs(dx) - object.half_width_mm, std::abs(dy) - object.half_height_mm});
    marker.gap_mm += variation.edge_gradient * beyond;
    marker.pull_x = -pull * full * dx / reach + skid_x + cut_normal(variation.pull_scatter_x, random);
    marker.pull_y = -pull * full * dy / reach + skid_y + cut_normal(variation.pull_scatter_y, random);
    marker.lag_share = drawn(variation.lag_share, random);
    nearest = std::min(nearest, marker.gap_mm);
  }
  for (MarkerContact& marker : markers) {
    marker.gap_mm -= nearest;
    const double pressed = std::max(0.0, depth_mm - marker.gap_mm) / depth_mm;
    const double share = variation.light_share + (1.0 - variation.light_share) * pressed;
    marker.shear_share = pressed > 0 ? share * varied(1.0, variation.marker_shear_spread, random) : 0.0;
  }
  return markers;
}

/// A press with a stage command at `stage_start_s`.
PressPlan draw_press(const ObjectModel& object, const RunPlanOptions& options, double stage_start_s, Random& of_run) {
  const RunVariation& v = options.variation;
  RepeatedRandom random = repeated(options, "press", of_run);
  PressPlan press;
  press.depth_mm = std::clamp(varied(object.depth_mm, v.depth_spread, random), v.depth_mm.low, v.depth_mm.high);
  press.press_power = drawn(v.press_power, random);
  press.press_s = std::clamp(varied(1e-3 * object.press_ms, v.press_time_spread, random), v.press_s.low, v.press_s.high);
  const double travel_in_units = press.depth_mm * (press.press_power + 1.0);
  press.press_s =
      std::clamp(press.press_s, travel_in_units / v.closing_speed_mm_s.high, travel_in_units / v.closing_speed_mm_s.low);
  press.stage_share = 1.0 - object.compliance;
  press.stage_start_s = stage_start_s;
  press.contact_s = stage_start_s + drawn(options.timings.travel_s, of_run);
  press.relaxation_share = drawn(options.after.relaxation_share, random);
  press.relaxation_s = drawn(options.after.relaxation_s, random);
  press.markers = draw_contacts(object, v, press.depth_mm, random);
  return press;
}

LiftPlan draw_lift(const ObjectModel& object, const RunPlanOptions& options, double start_s, Random& of_run) {
  const RunVariation& v = options.variation;
  RepeatedRandom random = repeated(options, "lift", of_run);
  const auto cut = [&](double typical, double spread, const Range& range) {
    return std::clamp(varied(typical, spread, random), range.low, range.high);
  };
  LiftPlan lift;
  lift.start_s = start_s;
  lift.lift_s = drawn(options.timings.lift_s, of_run);
  lift.speed_mm_s = drawn(v.lift_speed_mm_s, random);
  lift.acceleration_mm_s2 = drawn(v.lift_acceleration_mm_s2, random);
  lift.angle_rad = cut_normal(v.lift_angle_rad, random);
  lift.slack_mm = cut(object.slack_mm, v.slack_spread, v.slack_mm);
  lift.shear_limit_mm = cut(object.shear_limit_mm, v.shear_limit_spread, v.shear_limit_mm);
  lift.stick_slip_hz = cut(object.stick_slip_hz, v.stick_slip_hz_spread, v.stick_slip_hz);
  // When the tips spring back they move a light object with them.
  const double stays = object.weight_g > 0 ? object.weight_g / (object.weight_g + v.light_object_g) : 1.0;
  lift.stick_slip_mm =
      std::min(stays * varied(object.stick_slip_mm, v.stick_slip_mm_spread, random), v.most_spring_back * lift.shear_limit_mm);
  lift.unison = drawn(v.unison, random);
  lift.stick_slip_jitter = v.stick_slip_jitter;
  lift.spring_back_jitter = v.spring_back_jitter;
  lift.limit_jitter = v.limit_jitter;
  lift.ring_hz = cut(object.ring_hz, v.ring_hz_spread, v.ring_hz);
  lift.ring_decay_s = 1e-3 * varied(object.ring_decay_ms, v.ring_decay_spread, random);
  lift.texture_mm = varied(object.texture_mm, v.texture_spread, random);
  lift.texture_memory_s = drawn(v.texture_memory_s, random);
  lift.sink = cut_normal(v.sink, random);
  return lift;
}

/// Draws consecutive taps from `t_s` on. @return  the end of the last pause
double draw_taps(RunPlan& plan, const SpecialRuns& special, double t_s, Random& random) {
  for (int i = 0; i < special.tap_count; ++i) {
    TapPlan tap;
    tap.start_s = t_s;
    tap.travel_mm = drawn(special.tap_travel_mm, random);
    tap.tap_s = drawn(special.tap_s, random);
    tap.depth_mm = std::min(drawn(special.tap_depth_mm, random), 0.5 * tap.travel_mm);
    plan.taps.push_back(tap);
    t_s = tap.end_s() + drawn(special.tap_pause_s, random);
  }
  return t_s;
}

/// The end of a press by the rule of labels, even if its tips still creep.
double press_over_s(const PressPlan& press) {
  double aside = 0;
  for (const MarkerContact& marker : press.markers) aside = std::max(aside, std::hypot(1.0, marker.pull_x, marker.pull_y));
  const double creeping_mm_s = aside * press.relaxation_share * press.depth_mm / press.relaxation_s;
  const double limit_mm_s = still_share * press.closing_speed_mm_s();
  return press.still_s() + press.relaxation_s * std::log(std::max(1.0, creeping_mm_s / limit_mm_s));
}

/// Draws micro-slips, and possibly a re-contact, between `from_s` and `to_s`, while there is only creeping.
void draw_after_effects(RunPlan& plan, const ObjectModel& object, const RunPlanOptions& options, const PressPlan& press,
                        double from_s, double to_s, bool after_lift, Random& random) {
  const AfterEffects& after = options.after;
  std::optional<RecontactPlan> recontact;
  if (after_lift && random.uniform() < after.recontact_chance) {
    RecontactPlan rocks{
        .start_s = 0, .recontact_s = drawn(after.recontact_s, random), .depth_mm = drawn(after.recontact_mm, random)};
    rocks.depth_mm = std::min(rocks.depth_mm, 0.5 * press.depth_mm);
    const double latest_s = to_s - after.settle_s - rocks.recontact_s;
    if (latest_s > from_s) {
      rocks.start_s = random.uniform(from_s, latest_s);
      recontact = rocks;
      plan.recontacts.push_back(rocks);
    }
  }
  if (!(after.micro_slips_per_s > 0)) return;
  double t_s = from_s;
  while (true) {
    t_s += random.exponential() / after.micro_slips_per_s;
    if (!(t_s < to_s - after.settle_s)) return;
    MicroSlipPlan slip{.at_s = t_s, .markers = 0, .slip_mm = drawn(after.micro_slip_mm, random)};
    slip.ring_hz = std::clamp(varied(object.ring_hz, options.variation.ring_hz_spread, random), options.variation.ring_hz.low,
                              options.variation.ring_hz.high);
    slip.ring_decay_s = 1e-3 * varied(object.ring_decay_ms, options.variation.ring_decay_spread, random);
    const unsigned touched = touched_markers(press);
    for (std::size_t m = 0; m < marker_count; ++m) {
      if ((touched >> m & 1U) != 0 && random.uniform() < after.micro_slip_share) slip.markers |= 1U << m;
    }
    if (slip.markers == 0) slip.markers = touched & (~touched + 1U);  // the first touched marker
    const bool beside_recontact =
        recontact && t_s > recontact->start_s - after.settle_s && t_s < recontact->end_s() + after.settle_s;
    if (!beside_recontact) plan.micro_slips.push_back(slip);
    t_s += after.settle_s;
  }
}

struct RunKind {
  bool two_presses = false, without_slip = false, without_press = false, firm_lift = false, taps = false;
};

RunKind draw_kind(const RunPlanOptions& options, Random& random) {
  const SpecialRuns& special = options.special;
  const double number = random.uniform(), tapped = random.uniform();
  if (!options.may_be_special || options.run_number < special.from_run) return {};
  RunKind kind;
  double from = 0;
  const auto is_next = [&](double share) {
    const bool is = from <= number && number < from + share;
    from += share;
    return is;
  };
  kind.two_presses = is_next(special.two_presses);
  kind.without_slip = is_next(special.without_slip);
  kind.without_press = is_next(special.without_press);
  kind.firm_lift = is_next(special.firm_lifts);
  kind.taps = !kind.without_press && tapped < special.taps;  // a tap needs free tips
  return kind;
}

/// Draws what does not depend on the motion: light, noise, devices and the arm's vibration.
void draw_surroundings(RunPlan& plan, const ObjectModel& object, const RunPlanOptions& options, Random& of_run) {
  const RunVariation& variation = options.variation;
  RepeatedRandom random = repeated(options, "surroundings", of_run);
  plan.skin_coupling = drawn(variation.skin_coupling, random);
  plan.veil = drawn(variation.veil, random) + object.reflectivity * drawn(variation.object_veil, random);
  plan.noise_factor = varied(1.0, variation.noise_spread, of_run);
  plan.stage_on_robot_output = of_run.uniform() < variation.stage_output_share;
  plan.has_imu = of_run.uniform() < options.imu_share;
  plan.vibration = {.hz = drawn(options.after.vibration_hz, random),
                    .tip_mm = drawn(options.after.vibration_mm, random),
                    .decay_s = drawn(options.after.vibration_decay_s, random),
                    .housing_share = drawn(options.after.vibration_housing, random)};
}

}  // namespace

double longest_run_s(const RunPlanOptions& options) {
  const RunTimings& t = options.timings;
  const RunVariation& v = options.variation;
  const SpecialRuns& special = options.special;
  const double press_s = std::max(v.press_s.high, v.depth_mm.high * (v.press_power.high + 1.0) / v.closing_speed_mm_s.high);
  const double press_and_hold_s = t.travel_s.high + press_s + t.hold_s.high;
  double longest_s = t.quiet_s.high + press_and_hold_s + t.lift_s.high + t.rest_s.high;
  if (options.may_be_special) {
    if (special.two_presses > 0) longest_s += v.release_s.high + t.between_s.high + press_and_hold_s;
    if (special.taps > 0) {
      longest_s += 2.0 * t.quiet_s.high + v.release_s.high + t.between_s.high +
                   2.0 * special.tap_count * (special.tap_s.high + special.tap_pause_s.high);
    }
  }
  return longest_s;
}

RunPlan draw_run_plan(const ObjectModel& object, const RunPlanOptions& options, Random& random) {
  const RunTimings& timings = options.timings;
  const RunVariation& variation = options.variation;
  const RunKind kind = draw_kind(options, random);

  RunPlan plan;
  draw_surroundings(plan, object, options, random);
  double t_s = drawn(timings.quiet_s, random);
  if (kind.taps) t_s = draw_taps(plan, options.special, t_s, random) + drawn(timings.quiet_s, random);
  plan.presses.push_back(draw_press(object, options, t_s, random));
  if (kind.without_press) {
    // Pressed long before: its creeping has ended when the recording begins.
    PressPlan& press = plan.presses.front();
    const double earlier_s = press.creeping_end_s() + 1.0;
    press.stage_start_s -= earlier_s;
    press.contact_s -= earlier_s;
  } else {
    t_s = plan.presses.back().still_s();
  }
  if (kind.two_presses) {
    PressPlan& first = plan.presses.back();
    first.release_start_s = t_s + drawn(timings.hold_s, random);
    first.release_s = drawn(variation.release_s, random);
    const double open_s = *first.release_start_s + first.release_s;
    plan.presses.push_back(draw_press(object, options, open_s + drawn(timings.between_s, random), random));
    t_s = plan.presses.back().still_s();
  }
  t_s += drawn(timings.hold_s, random);
  if (!kind.without_slip) {
    plan.lift = draw_lift(object, options, t_s, random);
    t_s = plan.lift->end_s();
  }
  t_s += drawn(timings.rest_s, random);
  if (kind.taps) {
    PressPlan& last = plan.presses.back();
    last.release_start_s = t_s;
    last.release_s = drawn(variation.release_s, random);
    const double open_s = t_s + last.release_s + drawn(timings.between_s, random);
    t_s = draw_taps(plan, options.special, open_s, random) + drawn(timings.quiet_s, random);
  }
  plan.end_s = t_s;

  for (const PressPlan& press : plan.presses) {
    const double from_s = std::max(0.0, press_over_s(press)) + options.after.settle_s;
    const double open_s = press.release_start_s.value_or(plan.end_s);
    const bool is_lifted = plan.lift && &press == &plan.presses.back();
    draw_after_effects(plan, object, options, press, from_s, is_lifted ? plan.lift->start_s : open_s, false, random);
    if (is_lifted)
      draw_after_effects(plan, object, options, press, plan.lift->end_s() + options.after.after_lift_s, open_s, true, random);
  }
  draw_disturbances(plan, object, options, random);
  if (kind.firm_lift) plan.lift->firm_mm = drawn(options.special.firm_shear, random) * plan.lift->shear_limit_mm;
  return plan;
}

}  // namespace tactile::simulation
