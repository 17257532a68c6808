#include "tactile/simulation/dragged_tips.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tactile/core/infinite.hpp"

namespace tactile::simulation {
namespace {

constexpr double slip_still_s = 0.150;

double bell(Random& random) { return std::clamp(random.normal(), -2.0, 2.0); }

}  // namespace

/// The tip of one marker while the arm moves.
class ShearedTip {
 public:
  /// @param jerks  the times at which the object jerks [s], ascending; must outlive the tip
  ShearedTip(const LiftPlan& lift, const MarkerContact& marker, const std::vector<double>& jerks)
      : lift_(lift),
        jerks_(jerks),
        limit_mm_(lift.shear_limit_mm * marker.shear_share),
        spring_back_mm_(lift.stick_slip_mm * marker.shear_share),
        lag_s_(marker.lag_share / lift.stick_slip_hz),
        peak_mm_(limit_mm_) {}

  /// Advances by `dt_s` to `t_s`. The arm moves by `dragged_mm` in this time.
  void advance(double t_s, double dt_s, double dragged_mm, Random& random) {
    if (!slides_) {
      const double missing_mm = peak_mm_ - shear_mm_;
      if (dragged_mm >= missing_mm) {
        slides_ = slid_ = true;
        released_s_ = dragged_mm > 0 ? t_s - dt_s * (1.0 - missing_mm / dragged_mm) : t_s;
        from_mm_ = peak_mm_;
        to_mm_ = std::max(0.0, from_mm_ - spring_back_mm_ * std::exp(lift_.spring_back_jitter * bell(random)));
        while (jerk_index_ < jerks_.size() && jerks_[jerk_index_] + lag_s_ <= t_s) ++jerk_index_;
      } else {
        shear_mm_ += dragged_mm;
      }
    }
    if (slides_) {
      const double since = t_s - released_s_, ringing_mm = from_mm_ - to_mm_;
      shear_mm_ = to_mm_;
      if (t_s < ringing_end_s()) {
        shear_mm_ +=
            ringing_mm * std::exp(-since / lift_.ring_decay_s) * std::cos(2.0 * std::numbers::pi * lift_.ring_hz * since);
      }
      if (jerk_index_ < jerks_.size() && t_s >= jerks_[jerk_index_] + lag_s_) {
        ++jerk_index_;
        if (random.uniform() < lift_.unison) {
          slides_ = false;
          peak_mm_ = std::max(limit_mm_ * (1.0 + lift_.limit_jitter * bell(random)), shear_mm_ + 0.02 * limit_mm_);
        }
      }
    }
    const double keep = std::exp(-dt_s / lift_.texture_memory_s);
    tremble_ = keep * tremble_ + std::sqrt(1.0 - keep * keep) * random.normal();
  }

  bool slides() const { return slides_; }  ///< the object slides over the tip

  /// The tip rings until then, even if the arm has stopped.
  double ringing_end_s() const { return slides_ ? released_s_ + ringing_s(from_mm_ - to_mm_, lift_.ring_decay_s) : -infinite; }

  /// Once the surface has slid, its texture makes the tip tremble while the arm moves: sticking in between lasts milliseconds.
  double shear_mm(double speed_share) const { return shear_mm_ + (slid_ ? lift_.texture_mm * tremble_ * speed_share : 0.0); }

 private:
  const LiftPlan& lift_;
  const std::vector<double>& jerks_;
  double limit_mm_, spring_back_mm_, lag_s_, peak_mm_;
  double shear_mm_ = 0;
  bool slides_ = false, slid_ = false;
  std::size_t jerk_index_ = 0;
  double released_s_ = 0, from_mm_ = 0, to_mm_ = 0;
  double tremble_ = 0;
};

DraggedTips::DraggedTips(const RunPlan& plan, double dt_s, Random& random) : dt_s_(dt_s) {
  if (!plan.lift) return;
  const PressPlan* press = plan.press_at(plan.lift->start_s);
  if (press == nullptr) return;
  const double start_s = plan.lift->time_of_travel(plan.lift->slack_mm);
  for (std::size_t m = 0; m < marker_count; ++m) {
    const MarkerContact& marker = press->markers[m];
    if (!(press->depth_mm - marker.gap_mm > least_pressed_mm)) continue;
    touched_[m] = true;
    const double limit_mm = plan.lift->shear_limit_mm * marker.shear_share;
    if (!(plan.lift->firm_mm > 0)) gross_s_ = std::min(gross_s_, plan.lift->time_of_travel(plan.lift->slack_mm + limit_mm));
    start_s_ = start_s;
  }
  if (!(start_s_ < infinite)) return;
  plan_ = &*plan.lift;
  press_ = press;
  for (double t_s = start_s_; t_s < plan_->end_s();) {
    t_s += (1.0 + plan_->stick_slip_jitter * bell(random)) / plan_->stick_slip_hz;
    jerks_.push_back(t_s);
  }
  tips_.reserve(marker_count);
  for (const MarkerContact& marker : press->markers) tips_.emplace_back(*plan_, marker, jerks_);
}

DraggedTips::~DraggedTips() = default;

void DraggedTips::advance(double t_s, Random& random) {
  double against_mm_s = 0;
  if (plan_ != nullptr && t_s >= start_s_ && (t_s < plan_->end_s() + dt_s_ || t_s < ringing_end_s_ + dt_s_)) {
    const double speed_share = plan_->speed_at(t_s) / plan_->speed_mm_s;
    const double all_dragged_mm = std::max(0.0, plan_->travel_at(t_s) - plan_->slack_mm);
    const double dragged_mm = all_dragged_mm - dragged_mm_;
    dragged_mm_ = all_dragged_mm;
    for (std::size_t m = 0; m < marker_count; ++m) {
      if (!touched_[m]) continue;
      if (is_firm()) {  // the grip gives way ever less
        shear_mm_[m] = press_->markers[m].shear_share * plan_->firm_mm * (1.0 - std::exp(-all_dragged_mm / plan_->firm_mm));
        continue;
      }
      tips_[m].advance(t_s, dt_s_, dragged_mm, random);
      ringing_end_s_ = std::max(ringing_end_s_, tips_[m].ringing_end_s());
      const double moved_mm = tips_[m].shear_mm(speed_share) - shear_mm_[m];
      shear_mm_[m] += moved_mm;
      if (tips_[m].slides()) against_mm_s = std::max(against_mm_s, std::abs(dragged_mm - moved_mm) / dt_s_);
    }
  }
  speeds_mm_s_.push_back(against_mm_s);
}

double DraggedTips::end_s() const {
  if (is_firm()) {
    const double shear_mm = plan_->firm_mm * std::log(std::max(1.0, plan_->firm_mm / least_motion_mm));
    return std::min(plan_->end_s(), plan_->time_of_travel(plan_->slack_mm + shear_mm));
  }
  if (!(gross_s_ < infinite)) return plan_->end_s();
  const double limit = still_share * *std::max_element(speeds_mm_s_.begin(), speeds_mm_s_.end());
  const auto quiet = static_cast<std::size_t>(std::ceil(slip_still_s / dt_s_));
  // speeds_mm_s_[k] is the mean speed between the read-outs k - 1 and k, so it belongs to the middle between them.
  std::size_t still = static_cast<std::size_t>(std::ceil(gross_s_ / dt_s_));
  for (std::size_t k = still; k < speeds_mm_s_.size() && k < still + quiet; ++k) {
    if (speeds_mm_s_[k] >= limit) still = k + 1;
  }
  const auto middle_s = [&](std::size_t k) { return (static_cast<double>(k) - 0.5) * dt_s_; };
  if (still >= speeds_mm_s_.size()) return infinite;
  const double before = speeds_mm_s_[still - 1], after = speeds_mm_s_[still];
  const double share = before > limit ? (before - limit) / (before - after) : 0.0;
  return std::max(gross_s_, middle_s(still - 1) + dt_s_ * share);
}

}  // namespace tactile::simulation
