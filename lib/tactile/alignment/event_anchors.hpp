#pragma once

#include <optional>
#include <vector>

#include "tactile/alignment/anchor_search.hpp"
#include "tactile/alignment/placed_motion.hpp"
#include "tactile/alignment/stage_anchors.hpp"

namespace tactile::alignment {

/// The events as a witness: the activity of the skin against the motions of the arm and the commands to the stage.
class EventAnchors {
 public:
  explicit EventAnchors(AnchorSearch& search);

  /// Motions that the skin can show: whole ones with a profile; of those that do not return only lifts, where there are any.
  bool has_motion() const { return !motions_.empty(); }
  bool has_commands() const { return !commands_.empty(); }

  /// Correlates motion and activity at every lag. A first shear at a lift's start, a skin that rests after the last motion, and
  /// activity after each command to the stage speak for a lag. @return the shift [s]; nothing, and why in `doubts`, if there is
  /// none or it is ambiguous
  std::optional<double> match();
  /// Adds first shears, ring-downs and taps, each to the millisecond, and the stage's commands.
  void add_anchors(double shift_s);
  /// Adds the stage's commands where no motion places them.
  void add_stage_anchors_alone() { match_stage(search_, commands_, starts_, possible_s_); }

 private:
  struct Candidate;

  std::vector<Candidate> candidates() const;
  void judge(Candidate& candidate) const;
  bool is_left_by_imu(double shift_s) const;
  double active_share(double from_s, double to_s) const;
  double worth_without_press(double first_start_s, double first_end_s, double last_end_s) const;
  double start_of(const MotionPhase& motion) const { return search_.origins.seconds_of(motion.start); }
  double end_of(const MotionPhase& motion) const { return search_.origins.seconds_of(motion.end); }
  std::vector<double> expected_activity() const;
  void add_lift(const MotionPhase& lift, const PlacedMotion& placed);
  void add_tap(const MotionPhase& tap, const PlacedMotion& placed);

  AnchorSearch& search_;
  std::vector<MotionPhase> motions_;
  Milliseconds ms_;
  std::vector<double> activity_;  ///< on the grid
  std::vector<StageCommand> commands_;
  std::vector<ActivityStart> starts_;
  double length_s_ = 0;
  std::vector<double> possible_s_;  ///< shifts of an ambiguous match
};

}  // namespace tactile::alignment
