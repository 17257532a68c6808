#include "tactile/labels/posterior/motion_course.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "tactile/alignment/film_motions.hpp"
#include "tactile/core/robust_statistics.hpp"

namespace tactile::labels {
namespace {

constexpr std::int64_t stopped_for_us = 60'000;    // then the arm rests
constexpr std::int64_t longest_pause_us = 50'000;  // within a move
constexpr std::int64_t longest_start_us = 60'000;  // before the speed stands out of the log's noise
constexpr std::size_t shortest_steps = 3;
constexpr double least_speed = 0.3;  // [mm/s]
constexpr double clearly = 0.1;      // of the highest speed
constexpr double rings = 0.02;       // of the highest speed: an arm that has stopped may be so fast

std::uint8_t condition_of_speed(double mm_per_s) {
  std::uint8_t condition = 1;
  while (condition < arm_speeds.size() && mm_per_s > std::sqrt(arm_speeds[condition - 1] * arm_speeds[condition])) ++condition;
  return condition;
}

/// The speed [mm/s] of the mean velocity over an odd number of steps.
std::vector<double> smoothed_speed(const std::vector<alignment::Vector3>& velocity, std::size_t steps) {
  const std::size_t half = steps / 2;
  std::vector<double> speed(velocity.size());
  for (std::size_t i = 0; i < velocity.size(); ++i) {
    alignment::Vector3 sum{};
    const std::size_t first = i - std::min(i, half), end = std::min(velocity.size(), i + half + 1);
    for (std::size_t k = first; k < end; ++k) {
      for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += velocity[k][axis];
    }
    speed[i] = 1000 * alignment::length_of(sum) / static_cast<double>(end - first);
  }
  return speed;
}

/// The last step of a motion. Then the arm rings on.
std::size_t stop_of(std::span<const double> speed, double moving) {
  const double highest = *std::max_element(speed.begin(), speed.end());
  std::size_t stop = speed.size() - 1;
  while (stop > 0 && speed[stop] < 0.3 * highest) --stop;
  while (stop + 1 < speed.size() && speed[stop + 1] > std::max(moving, rings * highest)) ++stop;
  return stop;
}

/// Whether a move returns to its start within a second, and does not lead upwards. @param velocity  at each step [m/s]
bool taps(std::span<const alignment::Vector3> velocity, microseconds step) {
  constexpr microseconds longest = 1s;
  constexpr double returned = 0.25;  // of the greatest displacement: what is left at the end
  constexpr double upwards = 0.707;  // of its farthest point: the height
  if (step * std::ssize(velocity) > longest) return false;
  alignment::Vector3 at{}, farthest{};
  for (const alignment::Vector3& v : velocity) {
    for (std::size_t axis = 0; axis < 3; ++axis) at[axis] += v[axis];
    if (alignment::length_of(at) > alignment::length_of(farthest)) farthest = at;
  }
  const double far = alignment::length_of(farthest);
  return alignment::length_of(at) < returned * far && farthest[2] < upwards * far;
}

/// An arm that moves is faster than this [mm/s]. A fifth of the log shows it at rest.
double least_of_motion(const std::vector<double>& speed) { return std::max(least_speed, 7.5 * quantile(speed, 0.2)); }

}  // namespace

MotionCourse::MotionCourse(const alignment::ArmMotion& motion, bool is_whole)
    : begin_(motion.begin), end_(motion.time_of(motion.velocity.size() - 1)), step_(motion.step) {
  // A slow arm stands out of a noisy log only in means over more rows.
  std::vector<double> speed;
  double moving = 0;
  for (const std::size_t steps : {1U, 3U, 7U, 15U}) {
    speed = smoothed_speed(motion.velocity, steps);
    moving = least_of_motion(speed);
    if (moving < clearly * *std::max_element(speed.begin(), speed.end())) break;
  }
  speed_.assign(speed.size(), 0.0F);
  for (std::size_t i = 0; i < motion.known.size(); ++i) {
    if (motion.known[i]) continue;
    const bool continues = !gaps_.empty() && gaps_.back().end_us == us_of(motion.time_of(i));
    if (!continues) gaps_.push_back({.start_us = us_of(motion.time_of(i)), .end_us = 0});
    gaps_.back().end_us = us_of(motion.time_of(i + 1));
  }
  const auto pause = static_cast<std::size_t>(longest_pause_us / step_.count());
  struct {
    bool begins = false, ends = false;  // while the arm moves
  } moves_in_log;
  for (std::size_t first = 0; first < speed.size(); ++first) {
    if (speed[first] <= moving) continue;
    std::size_t last = first;
    for (std::size_t i = first + 1; i < std::min(speed.size(), last + pause); ++i) {
      if (speed[i] > moving) last = i;
    }
    const std::size_t stop = stop_of(std::span(speed).subspan(first, last - first + 1), moving) + first;
    if (stop - first >= shortest_steps) {
      add_move(std::span(speed).subspan(first, stop - first + 1), first);
      moves_in_log.begins |= first == 0;
      moves_in_log.ends |= stop + 2 >= speed.size();
      moves_.back().start_cut = first == 0 || !motion.known[first - 1];
      moves_.back().taps = taps(std::span(motion.velocity).subspan(first, stop - first + 1), step_);
      moves_.back().end_cut = stop + 2 >= speed.size() || !motion.known[stop + 1];
    }
    first = last;
  }
  for (std::size_t i = 0; i < motion.known.size(); ++i) {
    if (!motion.known[i]) speed_[i] = std::numeric_limits<float>::quiet_NaN();
  }
  if (is_whole && !moves_in_log.begins) before_ = arm_still;
  if (is_whole && !moves_in_log.ends) after_ = arm_still;
}

MotionCourse::MotionCourse(const alignment::MotionEnergy& film)
    : begin_(microseconds{us_of(film.begin())}), end_(microseconds{us_of(film.end())}), step_(film.median_step) {
  constexpr std::size_t most = 64;
  for (const alignment::FilmedMotion& motion : alignment::filmed_motions(film, most))
    moves_.push_back({.start_us = us_of(motion.start.low), .end_us = us_of(motion.end.high)});
  if (moves_.size() == most) end_ = RobotTime{microseconds{moves_.back().end_us}};
}

/// From rest, an arm speeds up about as t^2, because its acceleration is smoothed: the root of the speed is a line to its start.
/// @param speed  from where it stands out of the log's noise. @return  the steps from the start to there
double MotionCourse::steps_unseen(std::span<const double> speed) const {
  const double highest = *std::max_element(speed.begin(), speed.end());
  std::size_t faster = 0;
  while (faster + 1 < speed.size() && speed[faster] < std::min(0.3 * highest, 4 * speed[0])) ++faster;
  const double rise = std::sqrt(std::max(speed[faster], speed[0] + 1e-9)) - std::sqrt(speed[0]);
  return std::min(static_cast<double>(longest_start_us) / static_cast<double>(step_.count()),
                  std::max(1.0, static_cast<double>(faster) * std::sqrt(speed[0]) / rise));
}

void MotionCourse::add_move(std::span<const double> speed, std::size_t first) {
  const auto part_at = [](std::size_t i, double steps) {
    const double part = std::max(0.0, 1 - static_cast<double>(i) / steps);
    return part * part;
  };
  const std::size_t last = first + speed.size() - 1;
  const double before = steps_unseen(speed);
  for (std::size_t i = 1; i <= std::min(first, static_cast<std::size_t>(std::ceil(before))); ++i)
    speed_[first - i] = static_cast<float>(std::max(least_speed, speed.front() * part_at(i, before)));
  const std::vector<double> backwards(speed.rbegin(), speed.rend());
  const double after = steps_unseen(backwards);
  for (std::size_t i = 1; i <= std::min(speed_.size() - 1 - last, static_cast<std::size_t>(std::ceil(after))); ++i)
    speed_[last + i] = static_cast<float>(std::max(least_speed, speed.back() * part_at(i, after)));
  for (std::size_t i = 0; i < speed.size(); ++i) speed_[first + i] = static_cast<float>(speed[i]);
  const auto at_us = [&](double step) { return us_of(begin_) + std::llround(step * static_cast<double>(step_.count())); };
  moves_.push_back({.start_us = at_us(static_cast<double>(first) - before), .end_us = at_us(static_cast<double>(last) + after)});
}

std::vector<alignment::CameraSpan> MotionCourse::moves_at(std::int64_t offset_us) const {
  std::vector<alignment::CameraSpan> moves(moves_.size());
  std::transform(moves_.begin(), moves_.end(), moves.begin(), [offset_us](const Move& move) {
    return alignment::CameraSpan{camera_time(saturating_add(move.start_us, offset_us)),
                                 camera_time(saturating_add(move.end_us, offset_us))};
  });
  return moves;
}

double MotionCourse::changes_outside(CameraTime first, CameraTime last, std::int64_t offset_us) const {
  double count = 0;
  const auto is_outside = [&](std::int64_t at_us) {
    const std::int64_t camera_us = saturating_add(at_us, offset_us);
    return camera_us < us_of(first) || camera_us > us_of(last);
  };
  for (const Move& move : moves_)
    count += (!move.start_cut && is_outside(move.start_us)) + (!move.end_cut && is_outside(move.end_us));
  return count;
}

std::vector<std::uint8_t> MotionCourse::conditions(CameraTime first, microseconds bin, std::size_t bins,
                                                   std::int64_t offset_us) const {
  std::vector<std::uint8_t> conditions(bins, before_);
  // The middle of bin 0 on the robot's clock.
  const std::int64_t at_0 = saturating_subtract(us_of(first), offset_us) + bin.count() / 2;
  // The first bin whose middle is not before it.
  const auto bin_at = [&](std::int64_t robot_us) {
    const std::int64_t since_us = saturating_subtract(robot_us, at_0);
    return since_us > 0 ? (since_us - 1) / bin.count() + 1 : since_us / bin.count();
  };
  const auto limited = [&](std::int64_t b) { return std::clamp<std::int64_t>(b, 0, static_cast<std::int64_t>(bins)); };
  std::fill(conditions.begin() + limited(bin_at(us_of(begin_))), conditions.begin() + limited(bin_at(us_of(end_))),
            has_speed() ? arm_still : film_still);
  std::fill(conditions.begin() + limited(bin_at(us_of(end_))), conditions.end(), after_);
  if (!has_speed()) {
    for (const Move& move : moves_)
      std::fill(conditions.begin() + limited(bin_at(move.start_us)), conditions.begin() + limited(bin_at(move.end_us)),
                film_moves);
    return conditions;
  }
  for (const Move& gap : gaps_)
    std::fill(conditions.begin() + limited(bin_at(gap.start_us)), conditions.begin() + limited(bin_at(gap.end_us)), arm_unknown);
  for (const Move& move : moves_) {
    if (move.end_cut) continue;
    std::fill(conditions.begin() + limited(bin_at(move.end_us)),
              conditions.begin() + limited(bin_at(move.end_us + stopped_for_us)), arm_stopped);
  }
  for (const Move& move : moves_) {
    if (move.taps) {
      std::fill(conditions.begin() + limited(bin_at(move.start_us)), conditions.begin() + limited(bin_at(move.end_us)), arm_taps);
      continue;
    }
    const std::int64_t end_us = move.end_cut ? std::min(move.end_us, us_of(end_)) : move.end_us;
    for (std::int64_t b = limited(bin_at(move.start_us)); b < limited(bin_at(end_us)); ++b) {
      const std::int64_t since = at_0 + b * bin.count() - us_of(begin_);
      const auto i = static_cast<std::size_t>(
          std::clamp<std::int64_t>(since / step_.count(), 0, static_cast<std::int64_t>(speed_.size()) - 1));
      conditions[static_cast<std::size_t>(b)] = condition_of_speed(speed_[i]);
    }
    const std::int64_t begins = bin_at(move.start_us);
    if (!move.start_cut && begins >= 0 && begins < static_cast<std::int64_t>(bins))
      conditions[static_cast<std::size_t>(begins)] = arm_starts;
  }
  return conditions;
}

}  // namespace tactile::labels
