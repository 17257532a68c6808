#include "tactile/simulation/skin_motion.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

namespace tactile {
namespace {

constexpr double still_share = 0.01;  // of the peak speed: slower is still
constexpr double press_still_s = 0.020;
constexpr double slip_still_s = 0.150;
constexpr double infinite = std::numeric_limits<double>::infinity();

double bell(Random& random) { return std::clamp(random.normal(), -2.0, 2.0); }

microseconds whole_us(double seconds) { return microseconds{std::llround(1e6 * seconds)}; }

/// How long a ringing of this size goes on until nobody sees it.
double ringing_s(double mm, double decay_s) { return decay_s * std::log(std::max(1.0, std::abs(mm) / least_motion_mm)); }

/// The tip of one marker while the arm moves.
class ShearedTip {
 public:
  /// @param jerks  when the object jerks, in seconds, ascending; must outlive the tip
  ShearedTip(const LiftPlan& lift, const MarkerContact& marker, const std::vector<double>& jerks)
      : lift_(lift),
        jerks_(jerks),
        limit_mm_(lift.shear_limit_mm * marker.shear_share),
        spring_back_mm_(lift.stick_slip_mm * marker.shear_share),
        lag_s_(marker.lag_share / lift.stick_slip_hz),
        peak_mm_(limit_mm_) {}

  /// Moves on by `dt_s` to `t_s`, in which the arm moves by `dragged_mm`.
  void move_on(double t_s, double dt_s, double dragged_mm, Random& random) {
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

  bool slides() const { return slides_; }  ///< the object moves past the tip

  /// The tip moves until then, once the arm stands still.
  double ringing_end_s() const { return slides_ ? released_s_ + ringing_s(from_mm_ - to_mm_, lift_.ring_decay_s) : -infinite; }

  /// A surface that has run past makes a tip tremble, as long as the arm moves: its sticking in between lasts milliseconds.
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

/// All tips while the arm moves, and what the rules of labels ask about them.
class Lift {
 public:
  Lift(const RunPlan& plan, double dt_s, Random& random) : dt_s_(dt_s) {
    if (!plan.lift) return;
    const PressPlan* press = plan.press_at(plan.lift->start_s);
    if (press == nullptr) return;
    const double start_s = plan.lift->time_of_travel(plan.lift->slack_mm);
    for (std::size_t m = 0; m < marker_count; ++m) {
      const MarkerContact& marker = press->markers[m];
      if (!(press->depth_mm - marker.gap_mm > least_pressed_mm)) continue;
      touched_[m] = true;
      const double limit_mm = plan.lift->shear_limit_mm * marker.shear_share;
      gross_s_ = std::min(gross_s_, plan.lift->time_of_travel(plan.lift->slack_mm + limit_mm));
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
  Lift(const Lift&) = delete;
  Lift& operator=(const Lift&) = delete;

  bool drags() const { return plan_ != nullptr; }
  bool drags(const PressPlan* press) const { return plan_ != nullptr && press == press_; }
  double start_s() const { return start_s_; }  ///< a tip first moves
  double gross_s() const { return gross_s_; }  ///< infinite if none ever slides
  double arm_end_s() const { return plan_->end_s(); }

  /// To the next read-out, at `t_s`; each once, in order.
  void move_on(double t_s, Random& random) {
    double against_mm_s = 0;
    if (plan_ != nullptr && t_s >= start_s_ && (t_s < plan_->end_s() + dt_s_ || t_s < ringing_end_s_ + dt_s_)) {
      const double speed_share = plan_->speed_at(t_s) / plan_->speed_mm_s;
      const double all_dragged_mm = std::max(0.0, plan_->travel_at(t_s) - plan_->slack_mm);
      const double dragged_mm = all_dragged_mm - dragged_mm_;
      dragged_mm_ = all_dragged_mm;
      for (std::size_t m = 0; m < marker_count; ++m) {
        if (!touched_[m]) continue;
        tips_[m].move_on(t_s, dt_s_, dragged_mm, random);
        ringing_end_s_ = std::max(ringing_end_s_, tips_[m].ringing_end_s());
        const double moved_mm = tips_[m].shear_mm(speed_share) - shear_mm_[m];
        shear_mm_[m] += moved_mm;
        if (tips_[m].slides()) against_mm_s = std::max(against_mm_s, std::abs(dragged_mm - moved_mm) / dt_s_);
      }
    }
    speeds_mm_s_.push_back(against_mm_s);
  }

  bool touches(std::size_t m) const { return touched_[m]; }
  double shear_mm(std::size_t m) const { return shear_mm_[m]; }
  double ringing_end_s() const { return ringing_end_s_; }

  /// By the rule of labels, once all read-outs have passed.
  double end_s() const {
    if (!(gross_s_ < infinite)) return arm_end_s();
    const double limit = still_share * *std::max_element(speeds_mm_s_.begin(), speeds_mm_s_.end());
    const auto quiet = static_cast<std::size_t>(std::ceil(slip_still_s / dt_s_));
    // speeds_mm_s_[k] is the mean from read-out k - 1 to k, and so that of the instant between them.
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

 private:
  double dt_s_;
  const LiftPlan* plan_ = nullptr;
  const PressPlan* press_ = nullptr;
  std::array<bool, marker_count> touched_{};
  double start_s_ = infinite, gross_s_ = infinite, ringing_end_s_ = -infinite;
  std::vector<double> jerks_;
  std::vector<ShearedTip> tips_;
  std::array<double, marker_count> shear_mm_{};
  double dragged_mm_ = 0;
  std::vector<double> speeds_mm_s_;  ///< of the object against the tips that it moves past, the fastest
};

/// Where a micro-slip has taken its tips.
struct MicroSlip {
  const MicroSlipPlan* plan = nullptr;
  bool begun = false;
  std::array<double, marker_count> toward_x{}, toward_y{};  ///< unit vectors

  double end_s() const { return plan->at_s + ringing_s(plan->slip_mm, plan->ring_decay_s); }
  bool moves(std::size_t m) const { return (plan->markers >> m & 1U) != 0; }
  double gone_mm(double t_s) const {
    const double since = t_s - plan->at_s;
    if (t_s >= end_s()) return plan->slip_mm;
    return plan->slip_mm *
           (1.0 - std::exp(-since / plan->ring_decay_s) * std::cos(2.0 * std::numbers::pi * plan->ring_hz * since));
  }
};

/// When the tip speed of a press is below 1 % of its peak for the first 20 ms. Worked out, not sampled, but for the search.
double press_end_s(const PressPlan& press, double until_s) {
  std::array<double, marker_count> path_share{};  // of the object's way, that a tip goes inward and aside
  double peak = 0;
  for (std::size_t m = 0; m < marker_count; ++m) {
    const MarkerContact& marker = press.markers[m];
    if (marker.gap_mm >= press.depth_mm) continue;
    path_share[m] = std::hypot(1.0, marker.pull_x, marker.pull_y);
    const double part = 1.0 - std::pow(1.0 - marker.gap_mm / press.depth_mm, 1.0 / (press.press_power + 1.0));
    peak = std::max(peak, path_share[m] * press.speed_at(press.contact_s + part * press.press_s));
  }
  const auto moves = [&](double t_s) {
    const double depth_mm = press.depth_at(t_s);
    double share = 0;
    for (std::size_t m = 0; m < marker_count; ++m) {
      if (depth_mm >= press.markers[m].gap_mm) share = std::max(share, path_share[m]);
    }
    return share * press.speed_at(t_s) >= still_share * peak;
  };
  constexpr double step_s = 1e-4;
  double moved_s = press.contact_s;
  for (double t_s = press.contact_s; t_s < moved_s + press_still_s && t_s < until_s; t_s += step_s) {
    if (moves(t_s)) moved_s = t_s;
  }
  double still_s = moved_s + step_s;
  while (still_s - moved_s > 1e-8) {
    const double middle_s = 0.5 * (moved_s + still_s);
    (moves(middle_s) ? moved_s : still_s) = middle_s;
  }
  return std::min(still_s, until_s);
}

/// Collects motions, then takes the labelled ones' time away from the others.
class MotionList {
 public:
  explicit MotionList(double until_s) : until_s_(until_s) {}

  void add(Touch touch, const char* what, bool labelled, double start_s, double end_s, unsigned markers = all_markers) {
    start_s = std::max(start_s, 0.0);
    end_s = std::min(end_s, until_s_);
    if (whole_us(end_s) > whole_us(start_s)) {
      motions_.push_back({.touch = touch,
                          .what = what,
                          .labelled = labelled,
                          .start = whole_us(start_s),
                          .end = whole_us(end_s),
                          .gross = {},
                          .markers = markers});
    }
  }

  /// @param moves  whether anything is to be seen between two times
  template <class Moves>
  std::vector<MarkerMotion> finished(const Moves& moves) {
    std::stable_sort(motions_.begin(), motions_.end(), starts_before);
    std::vector<MarkerMotion> all, others;
    for (const MarkerMotion& motion : motions_) {
      if (motion.labelled) {
        if (!all.empty()) all.back().end = std::min(all.back().end, motion.start);
        all.push_back(motion);
      } else {
        others.push_back(motion);
      }
    }
    std::erase_if(all, [](const MarkerMotion& motion) { return motion.end <= motion.start; });
    const std::vector<MarkerMotion> labelled = all;
    const auto keep = [&](MarkerMotion piece, microseconds end) {
      piece.end = end;
      if (end > piece.start && moves(piece.start, end)) all.push_back(piece);
    };
    for (MarkerMotion motion : others) {
      for (const MarkerMotion& label : labelled) {
        if (label.start >= motion.end || label.end <= motion.start) continue;
        if (label.start > motion.start) keep(motion, label.start);
        motion.start = label.end;
      }
      keep(motion, motion.end);
    }
    std::stable_sort(all.begin(), all.end(), starts_before);
    return all;
  }

 private:
  static bool starts_before(const MarkerMotion& a, const MarkerMotion& b) { return a.start < b.start; }

  double until_s_;
  std::vector<MarkerMotion> motions_;
};

void add_presses(MotionList& list, const RunPlan& plan) {
  for (const PressPlan& press : plan.presses) {
    const double shut_s = press.release_start_s.value_or(infinite);
    const double end_s = press_end_s(press, std::min(shut_s, plan.end_s));
    list.add(Touch::press, "press", press.contact_s >= 0, press.contact_s, end_s);
    list.add(Touch::press, "relaxation", false, end_s, std::min(press.creeping_end_s(), shut_s));
    if (press.release_start_s) list.add(Touch::press, "release", false, shut_s, shut_s + press.release_s);
  }
}

void add_after_effects(MotionList& list, const RunPlan& plan, const std::vector<MicroSlip>& slips) {
  for (const MicroSlip& slip : slips)
    list.add(Touch::slip, "micro-slip", false, slip.plan->at_s, slip.end_s(), slip.plan->markers);
  for (const RecontactPlan& rocks : plan.recontacts) list.add(Touch::press, "re-contact", false, rocks.start_s, rocks.end_s());
  for (const TapPlan& tap : plan.taps) list.add(Touch::press, "tap", false, tap.contact_s(), tap.free_s());
}

/// The arm's ringing, and that of the tips after a slip is over: one motion where they overlap.
void add_vibrations(MotionList& list, const RunPlan& plan, double tail_start_s, double tail_end_s) {
  std::vector<std::pair<double, double>> rings;
  for (const auto& [at_s, change] : plan.arm_acceleration_changes())
    rings.emplace_back(at_s, at_s + plan.vibration.lasts_s(change));
  if (tail_end_s > tail_start_s) rings.emplace_back(tail_start_s, tail_end_s);
  std::sort(rings.begin(), rings.end());
  for (std::size_t i = 0; i < rings.size();) {
    const double start_s = rings[i].first;
    double end_s = rings[i].second;
    for (++i; i < rings.size() && rings[i].first <= end_s; ++i) end_s = std::max(end_s, rings[i].second);
    list.add(Touch::slip, "vibration", false, start_s, end_s);
  }
}

}  // namespace

SkinMotion move_skin(const RunPlan& plan, const SkinView& view, microseconds readout, Random& random) {
  assert(readout > 0us && "read-outs follow each other in time");
  const double dt_s = 1e-6 * static_cast<double>(readout.count());
  const auto steps = static_cast<std::size_t>(std::floor(plan.end_s / dt_s + 1e-6)) + 1;
  const double angle_rad = plan.lift ? plan.lift->angle_rad : 0.0;
  const double along_x = std::sin(angle_rad), along_y = std::cos(angle_rad);

  Lift lift(plan, dt_s, random);
  const double whole_travel_mm = plan.lift ? plan.lift->travel_at(plan.lift->end_s()) : 0.0;
  const auto sunk = [&](const PressPlan* press, double t_s) {  // a factor on the depth
    return lift.drags(press) && whole_travel_mm > 0 ? 1.0 + plan.lift->sink * plan.lift->travel_at(t_s) / whole_travel_mm : 1.0;
  };
  std::vector<MicroSlip> micro_slips;
  for (const MicroSlipPlan& slip : plan.micro_slips) micro_slips.push_back({.plan = &slip});

  SkinMotion motion;
  motion.poses.reserve(steps);
  for (std::size_t k = 0; k < steps; ++k) {
    const double t_s = static_cast<double>(k) * dt_s;
    lift.move_on(t_s, random);
    const PressPlan* press = plan.press_at(t_s);

    // Inward.
    std::array<double, marker_count> pushed{}, upright_share{};
    double mean_pushed = 0, mean_shear = 0;
    if (press != nullptr) {
      double depth_mm = press->depth_at(t_s) * sunk(press, t_s), held_mm = depth_mm;
      if (press->release_start_s && t_s > *press->release_start_s)
        held_mm = press->depth_at(*press->release_start_s) * sunk(press, *press->release_start_s);
      for (const RecontactPlan& rocks : plan.recontacts) depth_mm -= rocks.freed_at(t_s);
      for (std::size_t m = 0; m < marker_count; ++m) {
        const double gap_mm = press->markers[m].gap_mm;
        pushed[m] = std::max(0.0, depth_mm - gap_mm);
        mean_pushed += pushed[m] / marker_count;
        const bool opens = press->release_start_s && t_s > *press->release_start_s;
        upright_share[m] = !opens ? 0.0 : 1.0 - (held_mm > gap_mm ? pushed[m] / (held_mm - gap_mm) : 0.0);
        if (lift.drags(press) && lift.touches(m)) mean_shear += lift.shear_mm(m) * (1.0 - upright_share[m]) / marker_count;
      }
    }
    double tapped_mm = 0;
    for (const TapPlan& tap : plan.taps) tapped_mm += tap.depth_at(t_s);

    // Aside.
    const double ringing_mm = plan.vibration_at(t_s);
    SkinPose pose;
    for (std::size_t m = 0; m < marker_count; ++m) {
      const double q = pushed[m] + plan.skin_coupling * std::max(0.0, mean_pushed - pushed[m]);
      double aside_x = 0, aside_y = 0;
      if (press != nullptr) {
        const MarkerContact& marker = press->markers[m];
        const bool dragged = lift.drags(press) && lift.touches(m);
        const double shear = dragged ? lift.shear_mm(m) * (1.0 - upright_share[m]) : plan.skin_coupling * mean_shear;
        aside_x = q * marker.pull_x + shear * along_x;
        aside_y = q * marker.pull_y + shear * along_y;
        for (MicroSlip& slip : micro_slips) {
          if (!slip.moves(m) || t_s < slip.plan->at_s || slip.plan->at_s < press->contact_s) continue;
          if (!slip.begun) {
            const double bent = std::hypot(aside_x, aside_y);
            slip.toward_x[m] = bent > 0 ? -aside_x / bent : -along_x;
            slip.toward_y[m] = bent > 0 ? -aside_y / bent : -along_y;
          }
          const double gone_mm = slip.gone_mm(t_s) * (1.0 - upright_share[m]);
          aside_x += gone_mm * slip.toward_x[m];
          aside_y += gone_mm * slip.toward_y[m];
        }
      }
      pose[m] = marker_pose(view, m, q + tapped_mm, aside_x + ringing_mm * along_x, aside_y + ringing_mm * along_y);
    }
    for (MicroSlip& slip : micro_slips) slip.begun = slip.begun || t_s >= slip.plan->at_s;
    motion.poses.push_back(pose);
  }

  MotionList list(static_cast<double>(steps - 1) * dt_s);
  add_presses(list, plan);
  add_after_effects(list, plan, micro_slips);
  double tail_start_s = infinite;
  if (lift.drags()) {
    tail_start_s = lift.end_s();
    list.add(Touch::slip, "slip", true, lift.start_s(), tail_start_s);
  }
  add_vibrations(list, plan, tail_start_s, lift.ringing_end_s());
  const double least_px = view.px_per_mm * least_motion_mm;
  motion.motions = list.finished([&](microseconds start, microseconds end) {
    const auto first = static_cast<std::size_t>(start / readout);
    const auto last = std::min(static_cast<std::size_t>((end + readout - 1us) / readout), steps - 1);
    for (std::size_t k = first + 1; k <= last; ++k) {
      for (std::size_t m = 0; m < marker_count; ++m) {
        const MarkerPose &a = motion.poses[first][m], &b = motion.poses[k][m];
        const double size_px = std::abs(b.scale - a.scale) * marker_width_mm * view.px_per_mm;
        if (std::max(std::hypot(b.x - a.x, b.y - a.y), size_px) > least_px) return true;
      }
    }
    return false;
  });
  for (MarkerMotion& moved : motion.motions) {
    if (moved.what == "slip" && lift.gross_s() < infinite) moved.gross = whole_us(lift.gross_s());
  }
  if (plan.lift) motion.lift_start = whole_us(plan.lift->start_s);
  return motion;
}

}  // namespace tactile
