#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/simulation/run_plan.hpp"
#include "tactile/simulation/skin.hpp"

namespace tactile::simulation {

/// The time until a ringing of this amplitude is below `least_motion_mm` [s].
inline double ringing_s(double mm, double decay_s) { return decay_s * std::log(std::max(1.0, std::abs(mm) / least_motion_mm)); }

class ShearedTip;

/// All tips while the arm moves, and what the rules of labels need of them.
class DraggedTips {
 public:
  DraggedTips(const RunPlan& plan, double dt_s, Random& random);
  ~DraggedTips();
  DraggedTips(const DraggedTips&) = delete;
  DraggedTips& operator=(const DraggedTips&) = delete;

  bool drags() const { return plan_ != nullptr; }
  bool is_firm() const { return plan_ != nullptr && plan_->firm_mm > 0; }  ///< the object comes along, and nothing slips
  bool drags(const PressPlan* press) const { return plan_ != nullptr && press == press_; }
  double start_s() const { return start_s_; }  ///< a tip first moves
  double gross_s() const { return gross_s_; }  ///< infinite if no tip ever slides

  /// Advances to the next read-out, at `t_s`. Must be called for every read-out in order.
  void advance(double t_s, Random& random);

  bool touches(std::size_t m) const { return touched_[m]; }
  double shear_mm(std::size_t m) const { return shear_mm_[m]; }
  double ringing_end_s() const { return ringing_end_s_; }

  /// The end of the slip by the rule of labels, after the last read-out. Infinite if it does not end.
  double end_s() const;

 private:
  double dt_s_;
  const LiftPlan* plan_ = nullptr;
  const PressPlan* press_ = nullptr;
  std::array<bool, marker_count> touched_{};
  double start_s_ = std::numeric_limits<double>::infinity(), gross_s_ = start_s_, ringing_end_s_ = -start_s_;
  std::vector<double> jerks_;
  std::vector<ShearedTip> tips_;
  std::array<double, marker_count> shear_mm_{};
  double dragged_mm_ = 0;
  std::vector<double> speeds_mm_s_;  ///< of the object against the sliding tips, the fastest of each read-out
};

}  // namespace tactile::simulation
