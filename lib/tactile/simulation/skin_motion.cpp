#include "tactile/simulation/skin_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace tactile {
namespace {

constexpr double skin_coupling = 0.06;
constexpr double period_jitter = 0.15;
constexpr double amplitude_jitter = 0.25;
constexpr double texture_memory_s = 0.003;
constexpr double still_share = 0.01;       // of the peak speed: slower is still
constexpr double least_pressed_mm = 0.02;  // a marker less pressed than this is not dragged along

/// The tip of one marker while the arm moves.
class ShearedTip {
 public:
  ShearedTip(const RunPlan& plan, const MarkerContact& marker)
      : plan_(plan), limit_mm_(plan.shear_limit_mm * marker.shear_share), lag_s_(marker.lag_s) {
    amplitude_mm_ = plan.stick_slip_mm * marker.shear_share;
    set_peak(limit_mm_);
  }

  /// Moves on by dt; `jerk` is the time of the run's next jerk. Returns whether the object slides past the tip.
  bool move_on(double t_s, double dt_s, double dragged_mm, double jerk_s, Random& random) {
    const double speed = plan_.lift_speed_at(t_s);
    if (sticks_) {
      shear_mm_ += dragged_mm;
      if (shear_mm_ >= peak_mm_) {
        sticks_ = false;
        slipped_ = true;
        released_s_ = t_s;
        from_mm_ = shear_mm_;
        const double amplitude = amplitude_mm_ * std::exp(amplitude_jitter * std::clamp(random.normal(), -2.0, 2.0));
        to_mm_ = std::max(0.0, from_mm_ - amplitude);
      }
    } else {
      const double since = t_s - released_s_;
      const double fading = std::exp(-since / plan_.ring_decay_s);
      shear_mm_ = to_mm_ +
                  (fading < 1e-4 ? 0.0 : (from_mm_ - to_mm_) * fading * std::cos(2.0 * std::numbers::pi * plan_.ring_hz * since));
      if (speed > 0 && t_s >= jerk_s + lag_s_ && released_s_ < jerk_s) {
        sticks_ = true;
        set_peak(limit_mm_ * (1.0 + 0.05 * std::clamp(random.normal(), -2.0, 2.0)));
      }
    }
    const double keep = std::exp(-dt_s / texture_memory_s);
    tremble_ = keep * tremble_ + std::sqrt(1.0 - keep * keep) * random.normal();
    return !sticks_;
  }

  /// Tremble and sliding both need the arm to move.
  double shear_mm(double speed_share) const { return shear_mm_ + (slipped_ ? plan_.texture_mm * tremble_ * speed_share : 0.0); }

 private:
  void set_peak(double peak_mm) { peak_mm_ = std::max(peak_mm, shear_mm_ + 0.02 * limit_mm_); }

  const RunPlan& plan_;
  double limit_mm_, lag_s_;
  double amplitude_mm_ = 0, peak_mm_ = 0, shear_mm_ = 0;
  bool sticks_ = true, slipped_ = false;
  double released_s_ = 0, from_mm_ = 0, to_mm_ = 0;
  double tremble_ = 0;
};

/// The first of the first `steps` in a row from `from` on whose speeds are below 1 % of the peak.
std::size_t still_from(const std::vector<double>& speeds, std::size_t from, std::size_t steps) {
  const double limit = still_share * *std::max_element(speeds.begin(), speeds.end());
  std::size_t begin = from;
  for (std::size_t i = from; i < speeds.size() && i < begin + steps; ++i) {
    if (!(speeds[i] < limit)) begin = i + 1;
  }
  return std::min(begin, speeds.size());
}

/// When the arm has travelled `mm`: it accelerates evenly, then keeps its speed.
double time_of_travel(const RunPlan& plan, double mm) {
  const double a = plan.lift_acceleration_mm_s2, v = plan.lift_speed_mm_s;
  const double ramp_mm = 0.5 * v * v / a;
  return plan.lift_start_s + (mm <= ramp_mm ? std::sqrt(2.0 * mm / a) : v / a + (mm - ramp_mm) / v);
}

microseconds whole_us(double seconds) { return microseconds{std::llround(1e6 * seconds)}; }

}  // namespace

SkinMotion move_skin(const RunPlan& plan, microseconds readout, Random& random) {
  const double dt_s = 1e-6 * static_cast<double>(readout.count());
  const auto steps = static_cast<std::size_t>(std::floor(plan.end_s / dt_s)) + 1;
  const double slip_start_s = time_of_travel(plan, plan.slack_mm);
  const double lift_end_s = plan.lift_start_s + plan.lift_s;
  const double whole_travel_mm = plan.lift_travel_at(lift_end_s);
  const double along_x = std::sin(plan.lift_angle_rad), along_y = std::cos(plan.lift_angle_rad);

  SkinMotion motion;
  motion.poses.reserve(steps);
  std::vector<ShearedTip> tips;
  std::array<bool, marker_count> touched{};
  for (std::size_t m = 0; m < marker_count; ++m) {
    tips.emplace_back(plan, plan.markers[m]);
    touched[m] = plan.depth_mm - plan.markers[m].gap_mm > least_pressed_mm;
  }
  const auto draw_period_s = [&] { return (1.0 + period_jitter * std::clamp(random.normal(), -2.0, 2.0)) / plan.stick_slip_hz; };
  double jerk_s = slip_start_s + draw_period_s();

  std::vector<double> press_speeds, slip_speeds;
  std::array<double, marker_count> pushed_before{}, shear_before{};
  double gross_s = std::numeric_limits<double>::infinity();
  double dragged_before_mm = 0;
  for (std::size_t k = 0; k < steps; ++k) {
    const double t_s = static_cast<double>(k) * dt_s;
    // Press.
    std::array<double, marker_count> pushed{}, shear{};
    double mean_pushed = 0, mean_shear = 0, press_speed = 0;
    const double depth_mm = plan.depth_at(t_s) * (1.0 + plan.sink * plan.lift_travel_at(t_s) / whole_travel_mm);
    for (std::size_t m = 0; m < marker_count; ++m) {
      pushed[m] = std::max(0.0, depth_mm - plan.markers[m].gap_mm);
      mean_pushed += pushed[m] / marker_count;
      const double aside = std::hypot(plan.markers[m].pull_x, plan.markers[m].pull_y);
      press_speed = std::max(press_speed, std::abs(pushed[m] - pushed_before[m]) * std::hypot(1.0, aside) / dt_s);
    }
    pushed_before = pushed;
    if (t_s < plan.lift_start_s && k > 0) press_speeds.push_back(press_speed);  // from read-out k - 1 to k

    // Lift.
    double slip_speed = 0;
    if (t_s >= slip_start_s) {
      const double arm_speed = plan.lift_speed_at(t_s), share = arm_speed / plan.lift_speed_mm_s;
      const double all_dragged_mm = std::max(0.0, plan.lift_travel_at(t_s) - plan.slack_mm);
      const double dragged_mm = all_dragged_mm - dragged_before_mm;
      dragged_before_mm = all_dragged_mm;
      while (t_s > jerk_s + 0.006) jerk_s += draw_period_s();  // once even the most lagging marker has felt it
      for (std::size_t m = 0; m < marker_count; ++m) {
        if (!touched[m]) continue;
        const bool slides = tips[m].move_on(t_s, dt_s, dragged_mm, jerk_s, random);
        if (slides) gross_s = std::min(gross_s, t_s);
        shear[m] = tips[m].shear_mm(share);
        const double tip_speed = (shear[m] - shear_before[m]) / dt_s;
        if (slides) slip_speed = std::max(slip_speed, std::abs(dragged_mm / dt_s - tip_speed));
        mean_shear += shear[m] / marker_count;
      }
      shear_before = shear;
    }
    if (k > 0) slip_speeds.push_back(slip_speed);

    SkinPose pose;
    for (std::size_t m = 0; m < marker_count; ++m) {
      const double q = pushed[m] + skin_coupling * std::max(0.0, mean_pushed - pushed[m]);
      const double u = touched[m] ? shear[m] : skin_coupling * mean_shear;
      pose[m] = marker_pose(m, q, q * plan.markers[m].pull_x + u * along_x, q * plan.markers[m].pull_y + u * along_y);
    }
    motion.poses.push_back(pose);
  }

  const auto step_at = [&](double t_s) { return static_cast<std::size_t>(std::max(0.0, std::ceil(t_s / dt_s))); };
  motion.press_start = whole_us(plan.contact_s);
  motion.press_end = readout * static_cast<std::int64_t>(still_from(press_speeds, step_at(plan.contact_s), step_at(0.020)));
  motion.lift_start = whole_us(plan.lift_start_s);
  motion.slip_start = whole_us(slip_start_s);
  motion.gross = whole_us(gross_s);
  motion.slip_end = readout * static_cast<std::int64_t>(still_from(slip_speeds, step_at(gross_s), step_at(0.150)));
  return motion;
}

}  // namespace tactile
