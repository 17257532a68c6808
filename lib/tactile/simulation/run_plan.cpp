#include "tactile/simulation/run_plan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tactile/core/infinite.hpp"

namespace tactile::simulation {
namespace {

constexpr double stage_ramp_s = 0.020;
constexpr double reference_acceleration_mm_s2 = 1200.0;  // at which VibrationPlan::tip_mm is given

/// An opening stage: it reaches its speed after its ramp. @return  share of the travel at the share `x` of the time, and its
/// derivative
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

/// The distance of the stage from the object before this press: it reaches its speed after its ramp.
double gap_before(const PressPlan& press) {
  const double speed = press.closing_speed_mm_s() / press.stage_share, travel_s = press.contact_s - press.stage_start_s;
  return travel_s < stage_ramp_s ? 0.5 * speed * travel_s * travel_s / stage_ramp_s : speed * (travel_s - 0.5 * stage_ramp_s);
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

double TurnPlan::angle_at(double t_s) const {
  const double s = std::clamp((t_s - start_s) / turn_s, 0.0, 1.0);
  return angle_rad * s * s * (3.0 - 2.0 * s);
}

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
    const double pushed_mm = press.depth_at(std::min(t_s, press.still_s())) / press.stage_share;  // the stage does not creep
    if (t_s < press.contact_s) {
      const double speed = press.closing_speed_mm_s() / press.stage_share, since = t_s - press.stage_start_s;
      const double gone =
          since < stage_ramp_s ? 0.5 * speed * since * since / stage_ramp_s : speed * (since - 0.5 * stage_ramp_s);
      travel = touching_mm - gap_before(press) + gone;
    } else if (!press.release_start_s || t_s < *press.release_start_s) {
      travel = touching_mm + pushed_mm;
    } else {
      // Opening: away from the tips with the speed of the release, then to the start of the next press.
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

double RunPlan::kept_share_at(const PressPlan& press, double t_s) const {
  if (!press.release_start_s || t_s <= *press.release_start_s || !(hysteresis_share > 0)) return 0.0;
  const double since = t_s - *press.release_start_s - press.release_s;
  if (since > 0) return hysteresis_share * std::exp(-since / hysteresis_s);
  return hysteresis_share * opened((t_s - *press.release_start_s) / press.release_s, press.release_s).share;
}

bool RunPlan::stage_commanded_at(double t_s) const {
  return std::any_of(presses.begin(), presses.end(), [&](const PressPlan& press) {
    return t_s >= press.stage_start_s && !(press.release_start_s && t_s >= *press.release_start_s);
  });
}

}  // namespace tactile::simulation
