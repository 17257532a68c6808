#include "tactile/splitting/device_clock.hpp"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <utility>

#include "tactile/core/table_file.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile::splitting {
namespace {

bool has_host_times(const std::filesystem::path& log) {
  return TableFile(log, {.name = "a log", .header = "host_time_us", .ends_in_any_bytes = true}).find("host_time_us").has_value();
}

/// By camera time.
std::vector<alignment::CameraArrival> arrivals_of(const SplitSource& source) {
  if (!source.info) return {};
  std::vector<alignment::CameraArrival> arrivals = alignment::arrivals_in(*source.info);
  std::stable_sort(arrivals.begin(), arrivals.end(), [](const auto& a, const auto& b) { return a.camera < b.camera; });
  return arrivals;
}

std::optional<labels::Labels> labels_of(const SplitSource& source) {
  return source.labels ? std::optional(labels::read_labels(*source.labels)) : std::nullopt;
}

DeviceClock by_label(const alignment::FittedClock& fitted) {
  return {.relation = fitted.relation, .within = fitted.uncertainty(), .how = "labels.json of the whole recording"};
}

}  // namespace

std::int64_t DeviceClock::device_us_at(CameraTime t) const {
  if (!is_by_host()) return relation.clock_us_from(t);
  // The nearest arrival: so the clocks' drift does not add up.
  const auto later = std::lower_bound(arrivals.begin(), arrivals.end(), t,
                                      [](const alignment::CameraArrival& a, CameraTime at) { return a.camera < at; });
  const auto nearest = later == arrivals.end()                                            ? std::prev(later)
                       : later == arrivals.begin()                                        ? later
                       : between(std::prev(later)->camera, t) < between(t, later->camera) ? std::prev(later)
                                                                                          : later;
  return saturating_add(us_of(nearest->host), between(nearest->camera, t).count());
}

CameraTime DeviceClock::camera_at(std::int64_t us) const {
  if (!is_by_host()) return relation.camera_from(us);
  const auto nearest = std::min_element(arrivals.begin(), arrivals.end(), [us](const auto& a, const auto& b) {
    return std::abs(saturating_subtract(us_of(a.host), us)) < std::abs(saturating_subtract(us_of(b.host), us));
  });
  return after(nearest->camera, microseconds{saturating_subtract(us, us_of(nearest->host))});
}

DeviceClockSearch known_robot_clock(const SplitSource& source, const robot::RobotLogFile& log) {
  if (log.pieces.empty()) return {.clock = {}, .why_not = "the log has no row"};
  if (auto arrivals = arrivals_of(source); !arrivals.empty() && source.robot_columns.empty() && has_host_times(*source.robot))
    return {.clock = DeviceClock{.arrivals = std::move(arrivals), .within = 100ms, .how = "host times"}};
  if (log.pieces.size() > 1)
    return {.clock = {}, .why_not = "the robot's clock restarts within the log, and there are no host times"};
  if (const auto labels = labels_of(source); labels && labels->robot_clocks.size() == 1)
    return {.clock = by_label(labels->robot_clocks.front())};
  return {};
}

alignment::CoarseOffset offset_around(const DeviceClock& clock, const robot::RobotLog& log, CameraTime t) {
  const std::int64_t device_us = clock.device_us_at(t);
  if (!clock.is_by_host()) return {.offset_us = saturating_subtract(us_of(t), device_us), .within = clock.within};
  // Rows arrive late and in bursts. The row that arrived fastest gives the offset.
  constexpr std::int64_t around_us = 2'000'000;
  std::optional<std::int64_t> fastest_us, nearest_apart_us;
  std::int64_t nearest_us = 0;
  for (const robot::RobotState& row : log.states) {
    if (!row.host_time) continue;
    const std::int64_t late_us = saturating_subtract(us_of(*row.host_time), us_of(row.t));
    const std::int64_t apart_us =
        std::abs(std::max(saturating_subtract(us_of(*row.host_time), device_us), -std::numeric_limits<std::int64_t>::max()));
    if (apart_us <= around_us) fastest_us = std::min(fastest_us.value_or(late_us), late_us);
    if (nearest_apart_us && *nearest_apart_us <= apart_us) continue;
    nearest_apart_us = apart_us;
    nearest_us = late_us;
  }
  return {.offset_us =
              saturating_add(saturating_subtract(us_of(clock.camera_at(device_us)), device_us), fastest_us.value_or(nearest_us)),
          .within = clock.within};
}

DeviceClockSearch find_film_clock(const SplitSource& source) {
  std::vector<alignment::CameraArrival> arrivals = arrivals_of(source);
  if (!arrivals.empty() && source.video_times && has_host_times(*source.video_times))
    return {.clock = DeviceClock{.arrivals = std::move(arrivals), .within = 100ms, .how = "host times"}};
  if (const auto labels = labels_of(source); labels && labels->video_clock) return {.clock = by_label(*labels->video_clock)};
  return {.clock = {}, .why_not = "there are no host times, and no labels of the whole recording"};
}

}  // namespace tactile::splitting
