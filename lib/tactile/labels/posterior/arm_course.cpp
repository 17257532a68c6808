#include "tactile/labels/posterior/arm_course.hpp"

#include <algorithm>
#include <cmath>

#include "tactile/core/robust_statistics.hpp"

namespace tactile::labels {
namespace {

constexpr std::int64_t stopped_for_us = 60'000;    // then the arm rests
constexpr std::int64_t longest_pause_us = 50'000;  // within a move
constexpr std::int64_t longest_start_us = 60'000;  // before the speed stands out of the log's noise
constexpr std::size_t shortest_steps = 3;
constexpr double least_speed = 0.3;  // [mm/s]

std::uint8_t condition_of_speed(double mm_per_s) {
  std::uint8_t condition = 1;
  while (condition < arm_speeds.size() && mm_per_s > std::sqrt(arm_speeds[condition - 1] * arm_speeds[condition])) ++condition;
  return condition;
}

}  // namespace

ArmCourse::ArmCourse(const alignment::ArmMotion& motion)
    : begin_(motion.begin), end_(motion.time_of(motion.velocity.size() - 1)), step_(motion.step) {
  std::vector<double> speed;
  for (const alignment::Vector3& velocity : motion.velocity) speed.push_back(1000 * alignment::length_of(velocity));
  speed_.assign(speed.size(), 0.0F);
  const double moving = std::max(least_speed, 5 * median(speed));
  const auto pause = static_cast<std::size_t>(longest_pause_us / step_.count());
  for (std::size_t first = 0; first < speed.size(); ++first) {
    if (speed[first] <= moving) continue;
    std::size_t last = first;
    for (std::size_t i = first + 1; i < std::min(speed.size(), last + pause); ++i) {
      if (speed[i] > moving) last = i;
    }
    if (last - first >= shortest_steps) add_move(speed, first, last, moving);
    first = last;
  }
}

/// From rest, an arm speeds up about as t^2, because its acceleration is smoothed: the root of the speed is a line to its start.
void ArmCourse::add_move(const std::vector<double>& speed, std::size_t first, std::size_t last, double moving) {
  const double highest = *std::max_element(speed.begin() + static_cast<std::ptrdiff_t>(first),
                                           speed.begin() + static_cast<std::ptrdiff_t>(last) + 1);
  std::size_t faster = first;
  while (faster < last && speed[faster] < std::min(0.3 * highest, 4 * moving)) ++faster;
  const double rise = std::sqrt(std::max(speed[faster], speed[first] + 1e-9)) - std::sqrt(speed[first]);
  const double steps_before = std::min(static_cast<double>(longest_start_us) / static_cast<double>(step_.count()),
                                       std::max(1.0, static_cast<double>(faster - first) * std::sqrt(speed[first]) / rise));
  const auto before = std::min(first, static_cast<std::size_t>(std::ceil(steps_before)));
  for (std::size_t i = 1; i <= before; ++i) {
    const double part = std::max(0.0, 1 - static_cast<double>(i) / steps_before);
    speed_[first - i] = static_cast<float>(std::max(least_speed, speed[first] * part * part));
  }
  for (std::size_t i = first; i <= last; ++i) speed_[i] = static_cast<float>(speed[i]);
  const auto at_us = [&](double step) { return us_of(begin_) + std::llround(step * static_cast<double>(step_.count())); };
  moves_.push_back({at_us(static_cast<double>(first) - steps_before), at_us(static_cast<double>(last))});
}

std::vector<std::uint8_t> ArmCourse::conditions(CameraTime first, microseconds bin, std::size_t bins,
                                                std::int64_t offset_us) const {
  std::vector<std::uint8_t> conditions(bins, arm_still);
  // The middle of bin 0 on the robot's clock.
  const std::int64_t at_0 = saturating_subtract(us_of(first), offset_us) + bin.count() / 2;
  const auto bin_at = [&](std::int64_t robot_us) { return (robot_us - at_0 + bin.count() - 1) / bin.count(); };
  const auto limited = [&](std::int64_t b) {
    return static_cast<std::size_t>(std::clamp<std::int64_t>(b, 0, static_cast<std::int64_t>(bins)));
  };
  for (const Move& move : moves_) {
    for (std::size_t b = limited(bin_at(move.end_us)); b < limited(bin_at(move.end_us + stopped_for_us)); ++b)
      conditions[b] = arm_stopped;
  }
  for (const Move& move : moves_) {
    for (std::size_t b = limited(bin_at(move.start_us)); b < limited(bin_at(move.end_us)); ++b) {
      const std::int64_t since = at_0 + static_cast<std::int64_t>(b) * bin.count() - us_of(begin_);
      const auto i = static_cast<std::size_t>(
          std::clamp<std::int64_t>(since / step_.count(), 0, static_cast<std::int64_t>(speed_.size()) - 1));
      conditions[b] = condition_of_speed(speed_[i]);
    }
  }
  return conditions;
}

}  // namespace tactile::labels
