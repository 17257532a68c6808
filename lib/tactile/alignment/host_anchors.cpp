#include "tactile/alignment/host_anchors.hpp"

#include <algorithm>
#include <utility>

namespace tactile::alignment {
namespace {

/// Host times, and by how much the host's clock is later than the device's.
using Arrivals = std::vector<std::pair<std::int64_t, std::int64_t>>;

void add(Arrivals& arrivals, std::int64_t host_us, std::int64_t device_us) {
  std::int64_t later_us = 0;
  if (!__builtin_sub_overflow(host_us, device_us, &later_us)) arrivals.emplace_back(host_us, later_us);
}

/// The least delay of those in [begin, end]; nothing if there are none.
std::optional<std::int64_t> soonest(const Arrivals& arrivals, std::int64_t begin, std::int64_t end) {
  std::optional<std::int64_t> least;
  for (const auto& [host, later] : arrivals) {
    if (host >= begin && host <= end && (!least || later < *least)) least = later;
  }
  return least;
}

}  // namespace

std::vector<ClockAnchor> host_anchors(const AnchorInputs& inputs) {
  constexpr microseconds least_stretch = 2s;
  constexpr std::int64_t most_stretches = 16;
  constexpr double sigma_us = 2'000, common_us = 4'000;  // delays to the host are some milliseconds, and differ
  Arrivals robot, camera;
  for (const robot::RobotState& state : inputs.robot.states) {
    if (state.host_time) add(robot, us_of(*state.host_time), us_of(state.t));
  }
  for (const CameraArrival& arrival : inputs.host_from_camera) add(camera, us_of(arrival.host), us_of(arrival.camera));
  if (robot.empty() || camera.empty()) return {};
  const auto [robot_from, robot_to] = std::minmax_element(robot.begin(), robot.end());
  const auto [camera_from, camera_to] = std::minmax_element(camera.begin(), camera.end());
  const std::int64_t from = std::max(robot_from->first, camera_from->first), to = std::min(robot_to->first, camera_to->first);
  const std::int64_t span = saturating_subtract(to, from);
  if (span < 0) return {};
  const std::int64_t stretches = std::clamp<std::int64_t>(span / least_stretch.count(), 1, most_stretches);
  std::vector<ClockAnchor> anchors;
  for (std::int64_t k = 0; k < stretches; ++k) {
    const std::int64_t begin = from + span / stretches * k, end = k + 1 == stretches ? to : from + span / stretches * (k + 1);
    const auto of_robot = soonest(robot, begin, end), of_camera = soonest(camera, begin, end);
    if (!of_robot || !of_camera) continue;
    const std::int64_t middle = begin + (end - begin) / 2;
    anchors.push_back({.clock_us = saturating_subtract(middle, *of_robot),
                       .camera = camera_time(saturating_subtract(middle, *of_camera)),
                       .sigma_us = sigma_us,
                       .kind = AnchorKind::host_time,
                       .bias_us = common_us});
  }
  return anchors;
}

}  // namespace tactile::alignment
