#include "tactile/simulation/moving_tips.hpp"

#include <algorithm>

namespace tactile::simulation {
namespace {

constexpr double most_slid_share = 0.8;  // of a tip's displacement, in a partial slip

}  // namespace

MovingTips::MovingTips(const RunPlan& plan, const SkinView& view, double dt_s, Random& random)
    : plan_(plan), view_(view), dragged_(plan, dt_s, random) {
  const double angle_rad = plan.lift ? plan.lift->angle_rad : 0.0;
  along_x_ = std::sin(angle_rad);
  along_y_ = std::cos(angle_rad);
  if (plan.lift) whole_travel_mm_ = plan.lift->travel_at(plan.lift->end_s());
  for (const MicroSlipPlan& slip : plan.micro_slips) micro_slips_.push_back({.plan = &slip});
}

SkinPose MovingTips::advance_to(double t_s, Random& random) {
  dragged_.advance(t_s, random);
  const PressPlan* press = plan_.press_at(t_s);
  const Pressed pressed = press != nullptr ? pressed_at(*press, t_s) : Pressed{};
  double tapped_mm = 0;
  for (const TapPlan& tap : plan_.taps) tapped_mm += tap.depth_at(t_s);
  const double ringing_mm = plan_.vibration_at(t_s);
  SkinPose pose;
  for (std::size_t m = 0; m < marker_count; ++m) {
    double inward_mm = pressed.inward_mm[m] + plan_.skin_coupling * std::max(0.0, pressed.mean_inward_mm - pressed.inward_mm[m]);
    Sideways sideways = press != nullptr ? sideways_at(*press, pressed, m, inward_mm, t_s) : Sideways{};
    add_kept(m, inward_mm, sideways, t_s);
    pose[m] = marker_pose(view_, m, inward_mm + tapped_mm, sideways.x_mm + ringing_mm * along_x_,
                          sideways.y_mm + ringing_mm * along_y_);
  }
  for (MicroSlip& slip : micro_slips_) slip.begun = slip.begun || t_s >= slip.plan->at_s;
  return pose;
}

/// Adds what released tips still keep of their displacement.
void MovingTips::add_kept(std::size_t m, double& inward_mm, Sideways& sideways, double t_s) const {
  for (const PressPlan& press : plan_.presses) {
    const double share = plan_.kept_share_at(press, t_s);
    if (!(share > 0)) continue;
    const MarkerContact& marker = press.markers[m];
    const double kept_mm = share * std::max(0.0, press.depth_at(*press.release_start_s) - marker.gap_mm);
    inward_mm += kept_mm;
    sideways.x_mm += kept_mm * marker.pull_x;
    sideways.y_mm += kept_mm * marker.pull_y;
  }
}

/// The factor by which the lift changes the depth.
double MovingTips::sink_factor(const PressPlan& press, double t_s) const {
  if (!dragged_.drags(&press) || !(whole_travel_mm_ > 0)) return 1.0;
  return 1.0 + plan_.lift->sink * plan_.lift->travel_at(t_s) / whole_travel_mm_;
}

MovingTips::Pressed MovingTips::pressed_at(const PressPlan& press, double t_s) const {
  Pressed pressed;
  const bool opens = press.release_start_s && t_s > *press.release_start_s;
  double depth_mm = press.depth_at(t_s) * sink_factor(press, t_s);
  const double held_mm = opens ? press.depth_at(*press.release_start_s) * sink_factor(press, *press.release_start_s) : depth_mm;
  for (const RecontactPlan& recontact : plan_.recontacts) depth_mm -= recontact.freed_at(t_s);
  for (std::size_t m = 0; m < marker_count; ++m) {
    const double gap_mm = press.markers[m].gap_mm;
    pressed.inward_mm[m] = std::max(0.0, depth_mm - gap_mm);
    pressed.mean_inward_mm += pressed.inward_mm[m] / marker_count;
    if (opens) pressed.upright_share[m] = 1.0 - (held_mm > gap_mm ? pressed.inward_mm[m] / (held_mm - gap_mm) : 0.0);
    if (dragged_.drags(&press) && dragged_.touches(m))
      pressed.mean_shear_mm += dragged_.shear_mm(m) * (1.0 - pressed.upright_share[m]) / marker_count;
  }
  return pressed;
}

MovingTips::Sideways MovingTips::sideways_at(const PressPlan& press, const Pressed& pressed, std::size_t m, double inward_mm,
                                             double t_s) {
  const MarkerContact& marker = press.markers[m];
  const bool is_dragged = dragged_.drags(&press) && dragged_.touches(m);
  const double shear_mm =
      is_dragged ? dragged_.shear_mm(m) * (1.0 - pressed.upright_share[m]) : plan_.skin_coupling * pressed.mean_shear_mm;
  Sideways sideways{inward_mm * marker.pull_x + shear_mm * along_x_, inward_mm * marker.pull_y + shear_mm * along_y_};
  if (press.depth_mm - marker.gap_mm > least_pressed_mm) {
    for (const TurnPlan& turn : plan_.turns) {
      if (t_s <= turn.start_s || turn.start_s < press.contact_s) continue;
      const double angle_rad = turn.angle_at(t_s) * (1.0 - pressed.upright_share[m]);
      sideways.x_mm -= angle_rad * marker_y_mm(m);
      sideways.y_mm += angle_rad * marker_x_mm(m);
    }
  }
  for (MicroSlip& slip : micro_slips_) {
    if (!slip.moves(m) || t_s < slip.plan->at_s || slip.plan->at_s < press.contact_s) continue;
    if (!slip.begun) {
      const double bent = std::hypot(sideways.x_mm, sideways.y_mm);
      slip.toward_x[m] = bent > 0 ? -sideways.x_mm / bent : -along_x_;
      slip.toward_y[m] = bent > 0 ? -sideways.y_mm / bent : -along_y_;
      slip.most_mm[m] = most_slid_share * bent;
    }
    const double gone_mm = slip.gone_mm(m, t_s) * (1.0 - pressed.upright_share[m]);
    sideways.x_mm += gone_mm * slip.toward_x[m];
    sideways.y_mm += gone_mm * slip.toward_y[m];
  }
  return sideways;
}

}  // namespace tactile::simulation
