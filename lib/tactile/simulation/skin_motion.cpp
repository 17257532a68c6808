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
  /// @param jerks  when the object jerks, in seconds, ascending; must outlive the tip
  ShearedTip(const RunPlan& plan, const MarkerContact& marker, const std::vector<double>& jerks)
      : plan_(plan),
        jerks_(jerks),
        limit_mm_(plan.shear_limit_mm * marker.shear_share),
        amplitude_mm_(plan.stick_slip_mm * marker.shear_share),
        lag_s_(marker.lag_share / plan.stick_slip_hz),
        peak_mm_(limit_mm_) {}

  /// Moves on by `dt_s` to `t_s`, in which the arm moves by `dragged_mm`.
  void move_on(double t_s, double dt_s, double dragged_mm, Random& random) {
    const auto bell = [&] { return std::clamp(random.normal(), -2.0, 2.0); };
    if (slides_) {
      const double since = t_s - released_s_, fading = std::exp(-since / plan_.ring_decay_s);
      shear_mm_ = to_mm_ +
                  (fading < 1e-4 ? 0.0 : (from_mm_ - to_mm_) * fading * std::cos(2.0 * std::numbers::pi * plan_.ring_hz * since));
      if (jerk_index_ < jerks_.size() && t_s >= jerks_[jerk_index_] + lag_s_) {
        ++jerk_index_;
        if (random.uniform() < plan_.unison) {
          slides_ = false;
          peak_mm_ = std::max(limit_mm_ * (1.0 + 0.05 * bell()), shear_mm_ + 0.02 * limit_mm_);
        }
      }
    } else {
      shear_mm_ += dragged_mm;
      if (shear_mm_ >= peak_mm_) {
        slides_ = true;
        slid_ = true;
        released_s_ = t_s;
        from_mm_ = shear_mm_;
        to_mm_ = std::max(0.0, from_mm_ - amplitude_mm_ * std::exp(amplitude_jitter * bell()));
        while (jerk_index_ < jerks_.size() && jerks_[jerk_index_] + lag_s_ <= t_s) ++jerk_index_;
      }
    }
    const double keep = std::exp(-dt_s / texture_memory_s);
    tremble_ = keep * tremble_ + std::sqrt(1.0 - keep * keep) * random.normal();
  }

  bool slides() const { return slides_; }  ///< the object moves past the tip

  /// Only a surface that runs past makes a tip tremble.
  double shear_mm(double speed_share) const { return shear_mm_ + (slid_ ? plan_.texture_mm * tremble_ * speed_share : 0.0); }

 private:
  const RunPlan& plan_;
  const std::vector<double>& jerks_;
  double limit_mm_, amplitude_mm_, lag_s_, peak_mm_;
  double shear_mm_ = 0;
  bool slides_ = false, slid_ = false;
  std::size_t jerk_index_ = 0;
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
  std::vector<double> jerks;
  for (double t_s = slip_start_s; t_s < lift_end_s;) {
    t_s += (1.0 + period_jitter * std::clamp(random.normal(), -2.0, 2.0)) / plan.stick_slip_hz;
    jerks.push_back(t_s);
  }
  std::vector<ShearedTip> tips;
  std::array<bool, marker_count> touched{};
  for (std::size_t m = 0; m < marker_count; ++m) {
    tips.emplace_back(plan, plan.markers[m], jerks);
    touched[m] = plan.depth_mm - plan.markers[m].gap_mm > least_pressed_mm;
  }
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
      for (std::size_t m = 0; m < marker_count; ++m) {
        if (!touched[m]) continue;
        tips[m].move_on(t_s, dt_s, dragged_mm, random);
        const bool slides = tips[m].slides();
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
