#include "tactile/alignment/event_anchors.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "tactile/alignment/correlation.hpp"
#include "tactile/alignment/lag_search.hpp"
#include "tactile/alignment/moving_mean.hpp"
#include "tactile/core/infinite.hpp"

namespace tactile::alignment {
namespace {

constexpr double rests_after_s = 0.3;  // the skin rests so soon after the arm's last motion
constexpr double pressed_later = 0.6;  // the worth of a lift without a press before it, if the skin moves later

/// The activity of the skin on a grid of whole milliseconds: the root of the events above the quiet rate, 0 where they could be
/// noise. The root limits the first shear and tips that spring back, which are far above the rest.
std::vector<double> activity_on_grid(const Milliseconds& ms, microseconds grid) {
  constexpr std::size_t smoothed = 5;  // points: a faint slip does not stand out of the noise of a single one
  const auto width = static_cast<std::size_t>(std::max<std::int64_t>(1, grid / 1ms));
  std::vector<double> counts(ms.counts.size() / width);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    for (std::size_t j = 0; j < width; ++j) counts[i] += ms.counts[i * width + j];
  }
  const std::vector<double> means = moving_mean(counts, smoothed);
  const double quiet = ms.quiet * static_cast<double>(width);
  const double limit = 3.0 * std::sqrt(ms.dispersion * std::max(quiet, 1.0) / static_cast<double>(smoothed));
  std::vector<double> activity(counts.size());
  for (std::size_t i = 0; i < counts.size(); ++i)
    activity[i] = means[i] - quiet > limit ? std::sqrt(std::max(0.0, counts[i] - quiet)) : 0.0;
  return activity;
}

bool is_tap(const MotionPhase& motion) { return motion.kind == MotionKind::tap; }
bool rises(const MotionPhase& motion) { return !is_tap(motion) && motion.height_change > 0.3 * length_of(motion.displacement); }

/// Whether the motion lies whole in the log, and its profile explains the rows.
bool is_fitted(const MotionPhase& motion) {
  constexpr double most_misfit = 0.1;  // of the peak speed
  return motion.profile && motion.is_whole() && motion.profile->speed_sigma < most_misfit * motion.peak_speed;
}

/// A start is seen between rows, even where the fit leaves it open.
double start_sigma_s(const MotionPhase& motion) { return std::min(1e-6 * motion.start_sigma_us, 0.01); }

/// The log knows the start to a standard deviation only, so that the expected first ramp is longer, about the same middle. A ramp
/// of length L has the variance L^2 / 12.
void expect_longer_ramp(MotionPhase& motion) {
  std::vector<double>& knots_s = motion.profile->knots_s;
  const double length_s = knots_s[1] - knots_s[0], sigma_s = start_sigma_s(motion);
  const double longer_s = 0.5 * (std::sqrt(length_s * length_s + 12.0 * sigma_s * sigma_s) - length_s);
  knots_s[0] -= longer_s;
  knots_s[1] = std::min(knots_s[1] + longer_s, 0.5 * (knots_s[1] + knots_s[2]));
}

std::vector<MotionPhase> motions_in_skin(std::span<const MotionPhase> all) {
  std::vector<MotionPhase> motions;
  std::copy_if(all.begin(), all.end(), std::back_inserter(motions), is_fitted);
  for (MotionPhase& motion : motions) {
    if (!is_tap(motion)) expect_longer_ramp(motion);
  }
  // Where nothing rises the base's z axis points elsewhere, and any direction may be the lift's.
  if (std::any_of(motions.begin(), motions.end(), rises))
    std::erase_if(motions, [](const MotionPhase& motion) { return !is_tap(motion) && !rises(motion); });
  return motions;
}

}  // namespace

/// A shift at which the log may lie on the events.
struct EventAnchors::Candidate {
  double shift_s = 0;
  double score = 0;           ///< of the correlation
  double worth = 0;           ///< with all that speaks for and against it
  bool may_be_press = false;  ///< nothing moves before its lift, and more moves when the arm rests again
};

EventAnchors::EventAnchors(AnchorSearch& search)
    : search_(search),
      motions_(motions_in_skin(search.inputs.motions)),
      ms_(milliseconds_of(search.inputs.rate, search.inputs.quiet)),
      activity_(activity_on_grid(ms_, search.options.grid)),
      commands_(stage_commands(search)),
      starts_(activity_starts(search.inputs)),
      length_s_(1e-3 * static_cast<double>(ms_.counts.size())) {}

/// Where the skin should show the arm's motion if it touches something: 1 during a motion (of a tap only around its lowest
/// point), minus the mean over that and `flank_s` on either side, so that activity beyond a motion's ends counts against it.
std::vector<double> EventAnchors::expected_activity() const {
  constexpr double flank_s = 0.15, contact_share = 0.15;
  const double grid_s = search_.grid_s(), log_s = search_.origins.seconds_of(search_.inputs.robot.states.back().t);
  const auto points = static_cast<std::size_t>(log_s / grid_s) + 1;
  std::vector<double> expected(points);
  std::vector<bool> near(points);
  const auto mark = [&](double from_s, double to_s, auto&& at) {
    const double first = std::max(0.0, std::ceil(from_s / grid_s));
    for (auto i = static_cast<std::size_t>(first); i < points && grid_s * static_cast<double>(i) <= to_s; ++i) at(i);
  };
  for (const MotionPhase& motion : motions_) {
    double from_s = start_of(motion), to_s = end_of(motion);
    if (is_tap(motion)) {
      const double turn_s = search_.origins.seconds_of(*motion.turn), half_s = contact_share * (to_s - from_s);
      from_s = turn_s - half_s;
      to_s = turn_s + half_s;
    }
    mark(from_s, to_s, [&](std::size_t i) { expected[i] = 1.0; });
    mark(from_s - flank_s, to_s + flank_s, [&](std::size_t i) { near[i] = true; });
  }
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < points; ++i) {
    sum += expected[i];
    count += near[i] ? 1.0 : 0.0;
  }
  for (std::size_t i = 0; i < points; ++i) expected[i] -= near[i] ? sum / count : 0.0;
  return expected;
}

/// The highest points of the correlation of motion and activity.
std::vector<EventAnchors::Candidate> EventAnchors::candidates() const {
  constexpr double least_share = 0.5;
  constexpr std::size_t most = 12;
  const double grid_s = search_.grid_s();
  const std::vector<double> expected = expected_activity();
  std::vector<double> seen = activity_;
  keep_strongest(std::array{&seen}, static_cast<std::size_t>(searched_s / grid_s));
  const double energy = energy_of(seen) * energy_of(expected);
  if (!(energy > 0)) return {};
  std::vector<double> scores = correlations(expected, seen);
  for (double& score : scores) score /= std::sqrt(energy);
  const Lags lags{.grid_s = grid_s, .zero = expected.size() - 1};
  keep_within(scores, lags, search_);
  std::vector<Candidate> found;
  for (const std::size_t index : peaks_near_best(scores, least_share, static_cast<std::size_t>(same_shift_s / grid_s))) {
    if (found.size() == most) break;
    const double shift_s = lags.shift_of(static_cast<double>(index)), score = scores[index];
    if (is_left_by_imu(shift_s)) found.push_back({.shift_s = shift_s, .score = score, .worth = score});
  }
  return found;
}

/// Whether an ambiguous match of the IMU has this shift among those that it leaves.
bool EventAnchors::is_left_by_imu(double shift_s) const {
  constexpr double near_s = 0.25;
  const std::vector<double>& left_s = search_.left_by_imu_s;
  return left_s.empty() ||
         std::any_of(left_s.begin(), left_s.end(), [&](double by_imu_s) { return std::abs(by_imu_s - shift_s) < near_s; });
}

/// The share of a lift in which the skin moves.
double EventAnchors::active_share(double from_s, double to_s) const {
  double points = 0, active = 0;
  for (std::size_t i = 0; i < activity_.size(); ++i) {
    const double at_s = search_.grid_s() * static_cast<double>(i);
    if (at_s < from_s || at_s > to_s) continue;
    points += 1;
    active += activity_[i] > 0 ? 1 : 0;
  }
  return points > 0 ? active / points : 0.0;
}

/// Evidence against a lift without a press before it: the skin did not move before. The object may be held when the recording
/// begins, but not if the skin moves later, when the arm rests again, or begins to move a second time in a lift that it shows
/// hardly anything of.
double EventAnchors::worth_without_press(double first_start_s, double first_end_s, double last_end_s) const {
  constexpr double slack_s = 0.1, held_before = 0.75, hardly = 0.3;
  const auto starts = [&](auto&& when) {
    return std::any_of(starts_.begin(), starts_.end(), [&](const ActivityStart& start) { return when(start.at_s); });
  };
  if (starts([&](double at_s) { return at_s < first_start_s - slack_s; })) return 1.0;
  if (starts([&](double at_s) { return at_s > last_end_s + rests_after_s; })) return pressed_later;
  const bool moves_again = starts([&](double at_s) { return at_s > first_start_s + rests_after_s && at_s < first_end_s; });
  return moves_again && active_share(first_start_s, first_end_s) < hardly ? pressed_later : held_before;
}

/// Sets the candidate's worth, and its shift where the first lift's shear places it.
void EventAnchors::judge(Candidate& candidate) const {
  constexpr double command_fails = 0.6;
  double likeness = 0, lifts = 0, first_s = infinite, first_end_s = infinite, last_s = -infinite;
  for (const MotionPhase& motion : motions_) {
    last_s = std::max(last_s, end_of(motion) + candidate.shift_s);
    if (is_tap(motion)) continue;
    first_s = std::min(first_s, start_of(motion) + candidate.shift_s);
    first_end_s = std::min(first_end_s, end_of(motion) + candidate.shift_s);
    ++lifts;
    const auto placed = place_shear(ms_, motion, start_of(motion), candidate.shift_s, search_.options.most_slack_m);
    if (!placed) continue;
    likeness += placed->likeness;
    if (lifts == 1 && placed->likeness > 0.5) candidate.shift_s = placed->shift_s;
  }
  candidate.worth = candidate.score * (lifts > 0 ? 0.75 + 0.5 * likeness / lifts : 1.0);
  // After the last motion only a stage that opens causes activity.
  double before = 0, after = 0;
  for (std::size_t i = 0; i < activity_.size(); ++i)
    (search_.grid_s() * static_cast<double>(i) > last_s + rests_after_s ? after : before) += activity_[i];
  if (before + after > 0) candidate.worth *= 0.7 + 0.3 * before / (before + after);
  if (lifts > 0) {
    const double worth = worth_without_press(first_s, first_end_s, last_s);
    candidate.worth *= worth;
    candidate.may_be_press = worth == pressed_later;
  }
  for (const StageCommand& command : commands_) {
    const double at_s = command.at_s + candidate.shift_s;
    if (at_s < 0 || at_s + longest_travel_s > length_s_) continue;
    const ActivityStart* start =
        command.closes ? start_within(starts_, at_s, at_s + longest_travel_s) : start_within(starts_, at_s - 0.1, at_s + 0.2);
    if (start == nullptr) candidate.worth *= command_fails;
  }
}

std::optional<double> EventAnchors::match() {
  constexpr double least_worth = 0.1;
  std::vector<Candidate> all = candidates();
  for (Candidate& candidate : all) judge(candidate);
  std::stable_sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) { return a.worth > b.worth; });
  if (all.empty() || all.front().worth < least_worth) {
    search_.found.doubts.push_back(doubt("skin-unlike-arm", "no activity of the skin matches the arm's motion"));
    return std::nullopt;
  }
  const Candidate& best = all.front();
  const auto second = std::find_if(all.begin(), all.end(),
                                   [&](const Candidate& other) { return std::abs(other.shift_s - best.shift_s) > same_shift_s; });
  const LagMatch match{.offset_us = search_.origins.offset_us(best.shift_s),
                       .likeness = best.worth,
                       .ratio = second != all.end() && second->worth > 0 ? best.worth / second->worth : infinite};
  search_.found.events = match;
  if (best.may_be_press) {
    search_.found.doubts.push_back(doubt(
        "burst-may-be-press",
        "the arm's motion matches only the first burst of events, which may be a press: more follow when the arm would rest"));
    return std::nullopt;
  }
  if (match.ratio >= search_.options.ambiguous_below) return best.shift_s;
  for (const Candidate& candidate : all) {
    if (candidate.worth * search_.options.ambiguous_below > best.worth) possible_s_.push_back(candidate.shift_s);
  }
  search_.found.doubts.push_back(
      doubt("skin-ambiguous",
            "the match of the arm's motion and the events is ambiguous: the best is only {:.2f} times as good as the "
            "second, {:.2f} s away; expected {:.2f}",
            match.ratio, std::abs(second->shift_s - best.shift_s), search_.options.ambiguous_below));
  return std::nullopt;
}

void EventAnchors::add_lift(const MotionPhase& lift, const PlacedMotion& placed) {
  constexpr double shear_common_s = 0.8e-3, ring_common_s = 2e-3;
  // The ringing half a period later looks the same.
  if (placed.sigma_s < 0.1 / std::max(1.0, lift.profile->ringing.hz)) {
    if (const auto ring = place_ring_down(ms_, lift, start_of(lift), placed.shift_s))
      search_.add(end_of(lift), ring->shift_s, ring->sigma_s, AnchorKind::ring_down, ring_common_s);
  }
  search_.add(start_of(lift), placed.shift_s, std::hypot(placed.sigma_s, start_sigma_s(lift)), AnchorKind::first_shear,
              std::hypot(shear_common_s, placed.common_s));
}

void EventAnchors::add_tap(const MotionPhase& tap, const PlacedMotion& placed) {
  constexpr double common_s = 0.4e-3;
  search_.add(search_.origins.seconds_of(*tap.turn), placed.shift_s, std::hypot(placed.sigma_s, 1e-6 * tap.turn_sigma_us),
              AnchorKind::sync_tap, common_s);
}

void EventAnchors::add_anchors(double shift_s) {
  // From the middle of the recording outwards: a drift moves the later ones away.
  std::vector<const MotionPhase*> motions;
  for (const MotionPhase& motion : motions_) motions.push_back(&motion);
  const auto distance = [&](const MotionPhase* motion) { return std::abs(start_of(*motion) - (0.5 * length_s_ - shift_s)); };
  std::stable_sort(motions.begin(), motions.end(),
                   [&](const MotionPhase* a, const MotionPhase* b) { return distance(a) < distance(b); });
  KnownShifts known{.first_s = shift_s, .first_at_s = infinite};
  for (const MotionPhase* motion : motions) {
    const double start_s = start_of(*motion), expected_s = known.nearest(start_s).shift_s;
    const std::optional<PlacedMotion> placed = is_tap(*motion)
                                                   ? place_tap(ms_, *motion, start_s, expected_s)
                                                   : place_shear(ms_, *motion, start_s, expected_s, search_.options.most_slack_m);
    if (!placed) continue;
    if (placed->likeness > 0.5) known.found.emplace_back(start_s, placed->shift_s);
    is_tap(*motion) ? add_tap(*motion, *placed) : add_lift(*motion, *placed);
  }
  add_stage_anchors(search_, commands_, starts_, shift_s);
}

}  // namespace tactile::alignment
