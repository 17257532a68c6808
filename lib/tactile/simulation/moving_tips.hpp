#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/simulation/dragged_tips.hpp"
#include "tactile/simulation/run_plan.hpp"
#include "tactile/simulation/skin.hpp"

namespace tactile::simulation {

/// A micro-slip, and the direction in which it moves each tip.
struct MicroSlip {
  const MicroSlipPlan* plan = nullptr;
  bool begun = false;
  std::array<double, marker_count> toward_x{}, toward_y{};  ///< unit vectors; set when it begins

  std::array<double, marker_count> most_mm{};  ///< by which a tip can slide back; set when it begins

  bool is_partial() const { return plan->slip_s > 0; }
  double end_s() const { return plan->at_s + (is_partial() ? plan->slip_s : ringing_s(plan->slip_mm, plan->ring_decay_s)); }
  bool moves(std::size_t m) const { return (plan->markers >> m & 1U) != 0; }
  double gone_mm(std::size_t m, double t_s) const {
    const double since = t_s - plan->at_s;
    if (is_partial()) {
      const double s = std::min(1.0, since / plan->slip_s);
      return std::min(plan->slip_mm, most_mm[m]) * s * s * (3.0 - 2.0 * s);
    }
    if (t_s >= end_s()) return plan->slip_mm;
    return plan->slip_mm *
           (1.0 - std::exp(-since / plan->ring_decay_s) * std::cos(2.0 * std::numbers::pi * plan->ring_hz * since));
  }
};

/// The tips in a run, as `move_skin` describes their motion.
class MovingTips {
 public:
  /// @param plan  must outlive the tips
  MovingTips(const RunPlan& plan, const SkinView& view, double dt_s, Random& random);

  /// Advances to the next read-out, at `t_s`. Must be called for every read-out in order.
  SkinPose advance_to(double t_s, Random& random);

  const DraggedTips& dragged() const { return dragged_; }
  std::span<const MicroSlip> micro_slips() const { return micro_slips_; }

 private:
  /// The tips under a press.
  struct Pressed {
    std::array<double, marker_count> inward_mm{};
    std::array<double, marker_count> upright_share{};  ///< of its bending, that a tip has lost since the stage opened
    double mean_inward_mm = 0, mean_shear_mm = 0;
  };
  struct Sideways {
    double x_mm = 0, y_mm = 0;
  };

  double sink_factor(const PressPlan& press, double t_s) const;
  Pressed pressed_at(const PressPlan& press, double t_s) const;
  void add_kept(std::size_t m, double& inward_mm, Sideways& sideways, double t_s) const;
  Sideways sideways_at(const PressPlan& press, const Pressed& pressed, std::size_t m, double inward_mm, double t_s);

  const RunPlan& plan_;
  SkinView view_;
  DraggedTips dragged_;
  double along_x_ = 0, along_y_ = 1;  ///< the direction of the shear
  double whole_travel_mm_ = 0;        ///< of the arm
  std::vector<MicroSlip> micro_slips_;
};

}  // namespace tactile::simulation
