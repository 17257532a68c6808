#include "tactile/simulation/run_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace tactile {
namespace {

constexpr double stage_ramp_s = 0.020;
constexpr double reference_acceleration_mm_s2 = 1200.0;  // at which VibrationPlan::tip_mm is given
constexpr double still_share = 0.01;                     // of a press's peak speed: slower is still, by the rule of labels
constexpr double infinite = std::numeric_limits<double>::infinity();

/// A stage that opens: at speed after its ramp. @return share of the way at the share `x` of the time, and its derivative
struct Opened {
  double share = 0, rate = 0;
};
Opened opened(double x, double open_s) {
  const double ramp = std::min(1.0, stage_ramp_s / open_s), whole = 1.0 - 0.5 * ramp;
  if (x < ramp) return {0.5 * x * x / ramp / whole, x / ramp / whole};
  return {(x - 0.5 * ramp) / whole, 1.0 / whole};
}

double ramp_s(const LiftPlan& lift) { return std::min(lift.speed_mm_s / lift.acceleration_mm_s2, 0.5 * lift.lift_s); }

/// Calls `use(time, change)` for each change of the arm's acceleration.
template <class Use>
void for_each_change(const RunPlan& plan, const Use& use) {
  if (plan.lift) {
    const LiftPlan& lift = *plan.lift;
    const double a = lift.acceleration_mm_s2, ramp = ramp_s(lift);
    use(lift.start_s, a);
    use(lift.start_s + ramp, -a);
    use(lift.end_s() - ramp, -a);
    use(lift.end_s(), a);
  }
  for (const TapPlan& tap : plan.taps) {
    const double a = 16.0 * tap.travel_mm / (tap.tap_s * tap.tap_s);
    use(tap.start_s, -a);
    use(tap.start_s + 0.25 * tap.tap_s, 2.0 * a);
    use(tap.start_s + 0.75 * tap.tap_s, -2.0 * a);
    use(tap.end_s(), a);
  }
}

/// How far from the object the stage stands before this press: it is at speed after its ramp.
double gap_before(const PressPlan& press) {
  const double speed = press.closing_speed_mm_s() / press.stage_share, travel_s = press.contact_s - press.stage_start_s;
  return travel_s < stage_ramp_s ? 0.5 * speed * travel_s * travel_s / stage_ramp_s : speed * (travel_s - 0.5 * stage_ramp_s);
}

std::array<MarkerContact, marker_count> draw_contacts(const ObjectModel& object, const RunVariation& variation, double depth_mm,
                                                      Random& random) {
  const double centre_x = cut_normal(variation.centre_mm, random), centre_y = cut_normal(variation.centre_mm, random);
  const double tilt_x = cut_normal(object.tilt, random), tilt_y = cut_normal(object.tilt, random);
  const double pull = drawn(variation.pull, random);
  const double skid_x = cut_normal(variation.skid, random), skid_y = cut_normal(variation.skid, random);
  std::array<MarkerContact, marker_count> markers;
  double nearest = infinite;
  for (std::size_t i = 0; i < marker_count; ++i) {
    const double dx = marker_x_mm(i) - centre_x, dy = marker_y_mm(i) - centre_y;
    const double reach = std::max(std::hypot(dx, dy), 1e-9), full = std::min(1.0, reach / variation.pull_full_mm);
    MarkerContact& marker = markers[i];
    marker.gap_mm = tilt_x * dx + tilt_y * dy + cut_normal(object.irregularity_mm, random);
    if (object.radius_mm > 0) marker.gap_mm += dx * dx / (2.0 * object.radius_mm);
    const double beyond = std::max({0.0, std::abs(dx) - object.half_width_mm, std::abs(dy) - object.half_height_mm});
    marker.gap_mm += variation.edge_slope * beyond;
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

/// A press whose stage is commanded at `stage_start_s`.
PressPlan draw_press(const ObjectModel& object, const RunPlanOptions& options, double stage_start_s, Random& random) {
  const RunVariation& v = options.variation;
  PressPlan press;
  press.depth_mm = std::clamp(varied(object.depth_mm, v.depth_spread, random), v.depth_mm.low, v.depth_mm.high);
  press.press_power = drawn(v.press_power, random);
  press.press_s = std::clamp(varied(1e-3 * object.press_ms, v.press_time_spread, random), v.press_s.low, v.press_s.high);
  const double travel_in_units = press.depth_mm * (press.press_power + 1.0);
  press.press_s =
      std::clamp(press.press_s, travel_in_units / v.closing_speed_mm_s.high, travel_in_units / v.closing_speed_mm_s.low);
  press.stage_share = 1.0 - object.compliance;
  press.stage_start_s = stage_start_s;
  press.contact_s = stage_start_s + drawn(options.timings.travel_s, random);
  press.relaxation_share = drawn(options.after.relaxation_share, random);
  press.relaxation_s = drawn(options.after.relaxation_s, random);
  press.markers = draw_contacts(object, v, press.depth_mm, random);
  return press;
}

LiftPlan draw_lift(const ObjectModel& object, const RunPlanOptions& options, double start_s, Random& random) {
  const RunVariation& v = options.variation;
  const auto cut = [&](double typical, double spread, const Range& range) {
    return std::clamp(varied(typical, spread, random), range.low, range.high);
  };
  LiftPlan lift;
  lift.start_s = start_s;
  lift.lift_s = drawn(options.timings.lift_s, random);
  lift.speed_mm_s = drawn(v.lift_speed_mm_s, random);
  lift.acceleration_mm_s2 = drawn(v.lift_acceleration_mm_s2, random);
  lift.angle_rad = cut_normal(v.lift_angle_rad, random);
  lift.slack_mm = cut(object.slack_mm, v.slack_spread, v.slack_mm);
  lift.shear_limit_mm = cut(object.shear_limit_mm, v.shear_limit_spread, v.shear_limit_mm);
  lift.stick_slip_hz = cut(object.stick_slip_hz, v.stick_slip_hz_spread, v.stick_slip_hz);
  // As the tips spring back they take the object along a little: the less, the heavier it is.
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

/// Taps one after the other from `t_s` on. @return when the last pause has passed
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

/// From when on a press is over by the rule of labels, whatever its tips still creep.
double press_over_s(const PressPlan& press) {
  double aside = 0;
  for (const MarkerContact& marker : press.markers) aside = std::max(aside, std::hypot(1.0, marker.pull_x, marker.pull_y));
  const double creeping_mm_s = aside * press.relaxation_share * press.depth_mm / press.relaxation_s;
  const double limit_mm_s = still_share * press.closing_speed_mm_s();
  return press.still_s() + press.relaxation_s * std::log(std::max(1.0, creeping_mm_s / limit_mm_s));
}

/// Micro-slips, and a re-contact perhaps, between `from_s` and `to_s`, while nothing else but creeping moves.
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
    unsigned touched = 0;
    for (std::size_t m = 0; m < marker_count; ++m) {
      if (!(press.depth_mm - press.markers[m].gap_mm > least_pressed_mm)) continue;
      touched |= 1U << m;
      if (random.uniform() < after.micro_slip_share) slip.markers |= 1U << m;
    }
    if (slip.markers == 0) slip.markers = touched & (~touched + 1U);  // the first that is touched
    const bool beside_recontact =
        recontact && t_s > recontact->start_s - after.settle_s && t_s < recontact->end_s() + after.settle_s;
    if (!beside_recontact) plan.micro_slips.push_back(slip);
    t_s += after.settle_s;
  }
}

nlohmann::json json_of(const MarkerContact& m) {
  return {{"gap_mm", m.gap_mm},
          {"pull_x", m.pull_x},
          {"pull_y", m.pull_y},
          {"shear_share", m.shear_share},
          {"lag_share", m.lag_share}};
}

nlohmann::json json_of(const PressPlan& p) {
  nlohmann::json markers = nlohmann::json::array();
  for (const MarkerContact& marker : p.markers) markers.push_back(json_of(marker));
  nlohmann::json json = {{"stage_start_s", p.stage_start_s},
                         {"contact_s", p.contact_s},
                         {"press_s", p.press_s},
                         {"depth_mm", p.depth_mm},
                         {"press_power", p.press_power},
                         {"closing_speed_mm_s", p.closing_speed_mm_s()},
                         {"stage_share", p.stage_share},
                         {"relaxation_share", p.relaxation_share},
                         {"relaxation_s", p.relaxation_s},
                         {"release_start_s", nullptr},
                         {"markers", markers}};
  if (p.release_start_s) {
    json["release_start_s"] = *p.release_start_s;
    json["release_s"] = p.release_s;
  }
  return json;
}

nlohmann::json json_of(const LiftPlan& l) {
  return {{"start_s", l.start_s},
          {"lift_s", l.lift_s},
          {"speed_mm_s", l.speed_mm_s},
          {"acceleration_mm_s2", l.acceleration_mm_s2},
          {"angle_rad", l.angle_rad},
          {"slack_mm", l.slack_mm},
          {"shear_limit_mm", l.shear_limit_mm},
          {"stick_slip_hz", l.stick_slip_hz},
          {"stick_slip_mm", l.stick_slip_mm},
          {"unison", l.unison},
          {"stick_slip_jitter", l.stick_slip_jitter},
          {"spring_back_jitter", l.spring_back_jitter},
          {"limit_jitter", l.limit_jitter},
          {"ring_hz", l.ring_hz},
          {"ring_decay_s", l.ring_decay_s},
          {"texture_mm", l.texture_mm},
          {"texture_memory_s", l.texture_memory_s},
          {"sink", l.sink}};
}

}  // namespace

double PressPlan::creeping_end_s() const {
  return still_s() + relaxation_s * std::log(std::max(1.0, relaxation_share * depth_mm / least_motion_mm));
}

double PressPlan::depth_at(double t_s) const {
  if (t_s <= contact_s) return 0.0;
  const double shut_s = release_start_s ? std::min(t_s, *release_start_s) : t_s;
  const double part = press_s > 0 ? std::clamp((shut_s - contact_s) / press_s, 0.0, 1.0) : 1.0;
  const double creeping_s = std::clamp(shut_s, still_s(), creeping_end_s()) - still_s();
  const double depth = depth_mm * (1.0 - std::pow(1.0 - part, press_power + 1.0) +
                                   relaxation_share * (1.0 - std::exp(-creeping_s / relaxation_s)));
  if (t_s <= shut_s) return depth;
  const double open = (t_s - shut_s) / release_s;
  return open >= 1.0 ? 0.0 : depth * (1.0 - opened(open, release_s).share);
}

double PressPlan::speed_at(double t_s) const {
  if (t_s < contact_s) return 0.0;
  if (release_start_s && t_s >= *release_start_s) {
    const double open = (t_s - *release_start_s) / release_s;
    return open >= 1.0 ? 0.0 : -depth_at(*release_start_s) * opened(open, release_s).rate / release_s;
  }
  if (t_s < still_s()) return closing_speed_mm_s() * std::pow(1.0 - (t_s - contact_s) / press_s, press_power);
  if (t_s >= creeping_end_s()) return 0.0;
  return relaxation_share * depth_mm / relaxation_s * std::exp(-(t_s - still_s()) / relaxation_s);
}

double LiftPlan::speed_at(double t_s) const {
  const double since = t_s - start_s, left = lift_s - since;
  return std::clamp(acceleration_mm_s2 * std::min(since, left), 0.0, acceleration_mm_s2 * ramp_s(*this));
}

double LiftPlan::acceleration_at(double t_s) const {
  const double since = t_s - start_s, ramp = ramp_s(*this);
  if (since < 0 || since >= lift_s) return 0.0;
  if (since < ramp) return acceleration_mm_s2;
  return since >= lift_s - ramp ? -acceleration_mm_s2 : 0.0;
}

double LiftPlan::travel_at(double t_s) const {
  const double since = std::clamp(t_s - start_s, 0.0, lift_s), left = lift_s - since;
  const double a = acceleration_mm_s2, ramp = ramp_s(*this);
  if (since <= ramp) return 0.5 * a * since * since;
  if (left <= ramp) return a * ramp * (lift_s - ramp) - 0.5 * a * left * left;
  return a * ramp * (since - 0.5 * ramp);
}

double LiftPlan::time_of_travel(double mm) const {
  const double a = acceleration_mm_s2, ramp = ramp_s(*this), ramp_mm = 0.5 * a * ramp * ramp;
  const double whole_mm = a * ramp * (lift_s - ramp);
  if (mm > whole_mm) return infinite;
  if (mm <= ramp_mm) return start_s + std::sqrt(2.0 * std::max(0.0, mm) / a);
  if (mm >= whole_mm - ramp_mm) return end_s() - std::sqrt(2.0 * (whole_mm - mm) / a);
  return start_s + ramp + (mm - ramp_mm) / (a * ramp);
}

double TapPlan::fall_at(double t_s) const {
  const double since = std::clamp(t_s - start_s, 0.0, tap_s), to_low = std::abs(0.5 * tap_s - since), edge = 0.5 * tap_s - to_low;
  const double half_a = 8.0 * travel_mm / (tap_s * tap_s);
  return edge < to_low ? half_a * edge * edge : travel_mm - half_a * to_low * to_low;
}

double TapPlan::speed_at(double t_s) const {
  const double since = t_s - start_s;
  if (since <= 0 || since >= tap_s) return 0.0;
  const double a = 16.0 * travel_mm / (tap_s * tap_s);
  if (since < 0.25 * tap_s) return a * since;
  return since < 0.75 * tap_s ? a * (0.5 * tap_s - since) : a * (since - tap_s);
}

double TapPlan::acceleration_at(double t_s) const {
  const double since = t_s - start_s;
  if (since < 0 || since >= tap_s) return 0.0;
  const double a = 16.0 * travel_mm / (tap_s * tap_s);
  return since >= 0.25 * tap_s && since < 0.75 * tap_s ? -a : a;
}

double TapPlan::depth_at(double t_s) const { return std::max(0.0, fall_at(t_s) - (travel_mm - depth_mm)); }

double TapPlan::contact_s() const { return start_s + tap_s * (0.5 - std::sqrt(depth_mm / (8.0 * travel_mm))); }

double RecontactPlan::freed_at(double t_s) const {
  if (t_s <= start_s || t_s >= end_s()) return 0.0;
  const double swing = std::sin(std::numbers::pi * (t_s - start_s) / recontact_s);
  return depth_mm * swing * swing;
}

double VibrationPlan::lasts_s(double change_mm_s2) const {
  const double mm = tip_mm * std::abs(change_mm_s2) / reference_acceleration_mm_s2;
  return decay_s * std::log(std::max(1.0, mm / least_motion_mm));
}

const PressPlan* RunPlan::press_at(double t_s) const {
  const PressPlan* latest = nullptr;
  for (const PressPlan& press : presses) {
    const bool touches = press.contact_s <= t_s && !(press.release_start_s && t_s >= *press.release_start_s + press.release_s);
    if (touches) latest = &press;
  }
  return latest;
}

double RunPlan::arm_travel_at(double t_s) const {
  double travel = lift ? lift->travel_at(t_s) : 0.0;
  for (const TapPlan& tap : taps) travel -= tap.fall_at(t_s);
  return travel;
}

double RunPlan::arm_speed_at(double t_s) const {
  double speed = lift ? lift->speed_at(t_s) : 0.0;
  for (const TapPlan& tap : taps) speed -= tap.speed_at(t_s);
  return speed;
}

double RunPlan::arm_acceleration_at(double t_s) const {
  double acceleration = lift ? lift->acceleration_at(t_s) : 0.0;
  for (const TapPlan& tap : taps) acceleration -= tap.acceleration_at(t_s);
  return acceleration;
}

std::vector<std::pair<double, double>> RunPlan::arm_acceleration_changes() const {
  std::vector<std::pair<double, double>> changes;
  for_each_change(*this, [&](double at_s, double change) { changes.emplace_back(at_s, change); });
  std::sort(changes.begin(), changes.end());
  return changes;
}

double RunPlan::vibration_at(double t_s) const {
  const double omega = 2.0 * std::numbers::pi * vibration.hz, decay = 1.0 / vibration.decay_s;
  double tips_mm = 0;
  for_each_change(*this, [&](double at_s, double change) {
    const double since = t_s - at_s;
    if (since <= 0) return;
    double share = 1.0;
    if (since < vibration.lasts_s(change))
      share -= std::exp(-decay * since) * (std::cos(omega * since) + decay / omega * std::sin(omega * since));
    tips_mm += vibration.tip_mm * change / reference_acceleration_mm_s2 * share;
  });
  return tips_mm;
}

double RunPlan::vibration_acceleration_at(double t_s) const {
  const double omega = 2.0 * std::numbers::pi * vibration.hz, decay = 1.0 / vibration.decay_s;
  double housing = 0;
  for_each_change(*this, [&](double at_s, double change) {
    const double since = t_s - at_s;
    if (since < 0 || since > 12.0 * vibration.decay_s) return;
    housing -= vibration.housing_share * change * std::exp(-decay * since) *
               (std::cos(omega * since) - decay / omega * std::sin(omega * since));
  });
  return housing;
}

double RunPlan::stage_travel_at(double t_s) const {
  if (presses.empty()) return 0.0;
  const double touching_mm = presses.front().contact_s < 0 ? 0.0 : gap_before(presses.front());
  double travel = touching_mm - gap_before(presses.front());
  if (presses.front().contact_s < 0) travel = 0.0;
  for (std::size_t i = 0; i < presses.size(); ++i) {
    const PressPlan& press = presses[i];
    if (t_s < press.stage_start_s) break;
    const double pushed_mm = press.depth_at(std::min(t_s, press.still_s())) / press.stage_share;  // creeping is not the stage's
    if (t_s < press.contact_s) {
      const double speed = press.closing_speed_mm_s() / press.stage_share, since = t_s - press.stage_start_s;
      const double gone =
          since < stage_ramp_s ? 0.5 * speed * since * since / stage_ramp_s : speed * (since - 0.5 * stage_ramp_s);
      travel = touching_mm - gap_before(press) + gone;
    } else if (!press.release_start_s || t_s < *press.release_start_s) {
      travel = touching_mm + pushed_mm;
    } else {
      // Open: off the tips at the speed of the release, then on to where the next press begins.
      const double freed_s = *press.release_start_s + press.release_s;
      const double open = std::min(1.0, (t_s - *press.release_start_s) / press.release_s);
      const double whole_mm = press.depth_at(std::min(press.still_s(), *press.release_start_s)) / press.stage_share;
      travel = touching_mm + whole_mm * (1.0 - opened(open, press.release_s).share);
      if (t_s > freed_s) {
        const bool last = i + 1 == presses.size();
        const double gap_mm = gap_before(last ? presses.front() : presses[i + 1]);
        double back_s = gap_mm * press.release_s / whole_mm;
        if (!last) back_s = std::min(back_s, presses[i + 1].stage_start_s - freed_s);
        travel = touching_mm - gap_mm * (back_s > 0 ? std::min(1.0, (t_s - freed_s) / back_s) : 1.0);
      }
    }
  }
  return travel;
}

bool RunPlan::stage_commanded_at(double t_s) const {
  return std::any_of(presses.begin(), presses.end(), [&](const PressPlan& press) {
    return t_s >= press.stage_start_s && !(press.release_start_s && t_s >= *press.release_start_s);
  });
}

void to_json(nlohmann::json& json, const RunPlan& p) {
  nlohmann::json presses = nlohmann::json::array(), taps = presses, micro_slips = presses, recontacts = presses;
  for (const PressPlan& press : p.presses) presses.push_back(json_of(press));
  for (const TapPlan& tap : p.taps) {
    taps.push_back({{"start_s", tap.start_s}, {"travel_mm", tap.travel_mm}, {"tap_s", tap.tap_s}, {"depth_mm", tap.depth_mm}});
  }
  for (const MicroSlipPlan& slip : p.micro_slips) {
    nlohmann::json markers = nlohmann::json::array();
    for (std::size_t m = 0; m < marker_count; ++m) {
      if ((slip.markers >> m & 1U) != 0) markers.push_back(m);
    }
    micro_slips.push_back({{"at_s", slip.at_s},
                           {"markers", markers},
                           {"slip_mm", slip.slip_mm},
                           {"ring_hz", slip.ring_hz},
                           {"ring_decay_s", slip.ring_decay_s}});
  }
  for (const RecontactPlan& rocks : p.recontacts) {
    recontacts.push_back({{"start_s", rocks.start_s}, {"recontact_s", rocks.recontact_s}, {"depth_mm", rocks.depth_mm}});
  }
  json = {{"presses", presses},
          {"lift", p.lift ? json_of(*p.lift) : nlohmann::json()},
          {"taps", taps},
          {"micro_slips", micro_slips},
          {"recontacts", recontacts},
          {"vibration",
           {{"hz", p.vibration.hz},
            {"tip_mm", p.vibration.tip_mm},
            {"decay_s", p.vibration.decay_s},
            {"housing_share", p.vibration.housing_share}}},
          {"end_s", p.end_s},
          {"skin_coupling", p.skin_coupling},
          {"veil", p.veil},
          {"noise_factor", p.noise_factor},
          {"stage_on_robot_output", p.stage_on_robot_output},
          {"has_imu", p.has_imu}};
}

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
  const SpecialRuns& special = options.special;
  const double kind = random.uniform(), tapped = random.uniform();
  const bool may_differ = options.may_be_special && options.run_number >= special.from_run;
  const bool two_presses = may_differ && kind < special.two_presses;
  const bool without_slip = may_differ && !two_presses && kind < special.two_presses + special.without_slip;
  const bool without_press =
      may_differ && !two_presses && !without_slip && kind < special.two_presses + special.without_slip + special.without_press;
  const bool taps = may_differ && !without_press && tapped < special.taps;  // an object that is held would be in the way

  RunPlan plan;
  plan.skin_coupling = drawn(variation.skin_coupling, random);
  plan.veil = drawn(variation.veil, random) + object.reflectivity * drawn(variation.object_veil, random);
  plan.noise_factor = varied(1.0, variation.noise_spread, random);
  plan.stage_on_robot_output = random.uniform() < variation.stage_output_share;
  plan.has_imu = random.uniform() < options.imu_share;
  plan.vibration = {.hz = drawn(options.after.vibration_hz, random),
                    .tip_mm = drawn(options.after.vibration_mm, random),
                    .decay_s = drawn(options.after.vibration_decay_s, random),
                    .housing_share = drawn(options.after.vibration_housing, random)};

  double t_s = drawn(timings.quiet_s, random);
  if (taps) t_s = draw_taps(plan, special, t_s, random) + drawn(timings.quiet_s, random);
  plan.presses.push_back(draw_press(object, options, t_s, random));
  if (without_press) {
    // Pressed long before: its creeping has ended when the recording begins.
    PressPlan& press = plan.presses.front();
    const double earlier_s = press.creeping_end_s() + 1.0;
    press.stage_start_s -= earlier_s;
    press.contact_s -= earlier_s;
  } else {
    t_s = plan.presses.back().still_s();
  }
  if (two_presses) {
    PressPlan& first = plan.presses.back();
    first.release_start_s = t_s + drawn(timings.hold_s, random);
    first.release_s = drawn(variation.release_s, random);
    const double open_s = *first.release_start_s + first.release_s;
    plan.presses.push_back(draw_press(object, options, open_s + drawn(timings.between_s, random), random));
    t_s = plan.presses.back().still_s();
  }
  t_s += drawn(timings.hold_s, random);
  if (!without_slip) {
    plan.lift = draw_lift(object, options, t_s, random);
    t_s = plan.lift->end_s();
  }
  t_s += drawn(timings.rest_s, random);
  if (taps) {
    PressPlan& last = plan.presses.back();
    last.release_start_s = t_s;
    last.release_s = drawn(variation.release_s, random);
    const double open_s = t_s + last.release_s + drawn(timings.between_s, random);
    t_s = draw_taps(plan, special, open_s, random) + drawn(timings.quiet_s, random);
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
  return plan;
}

}  // namespace tactile
