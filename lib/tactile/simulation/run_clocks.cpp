#include "tactile/simulation/run_clocks.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace tactile::simulation {
namespace {

// The paper's ten objects, listed here so that adding an object does not change the clocks of another.
constexpr std::array<std::string_view, 10> the_ten{
    "3d-printed-object", "uhu-glue-stick", "sprayer",           "water-bottle", "fan",
    "white-box",         "textured-box",   "plastic-container", "small-box",    "usb-hub"};

// The camera has the computer's time of day, within a year and a half from November 2023 on.
constexpr std::int64_t earliest_start_us = 1'700'000'000'000'000;
constexpr std::uint64_t start_span_us = 50'000'000'000'000;
constexpr double host_apart_s = 3;

std::int64_t us_in(double seconds) { return std::llround(1e6 * seconds); }

bool shares_a_session(const ClockPhysics& physics, std::uint64_t seed, std::string_view object) {
  if (std::find(the_ten.begin(), the_ten.end(), object) == the_ten.end())
    return Random(seed_for(seed, {"shares a session", object})).uniform() < physics.shared_session_share;
  std::vector<std::string_view> objects(the_ten.begin(), the_ten.end());
  Random(seed_for(seed, {"objects that share a session"})).shuffle(objects);
  const auto place = std::find(objects.begin(), objects.end(), object) - objects.begin();
  constexpr double rounding = 1e-9;  // 0.7 * 10 may be below 7
  return static_cast<double>(place) < std::floor(10.0 * physics.shared_session_share + rounding);
}

/// The clocks after a start of camera and controller, for the first run.
RunClocks started_clocks(const ClockPhysics& physics, Random& random) {
  RunClocks clocks;
  clocks.camera_start_us = earliest_start_us + static_cast<std::int64_t>(random.below(start_span_us));
  const auto relation = [&](std::int64_t first_stamp_us) {
    const std::int64_t first_in_camera_us = clocks.camera_start_us - us_in(drawn(physics.before_camera_s, random));
    return ClockRelation{.offset_us = first_in_camera_us - first_stamp_us,
                         .drift_ppm = drawn(physics.drift_ppm, random),
                         .reference_us = first_stamp_us};
  };
  clocks.robot = relation(us_in(drawn(physics.robot_up_s, random)));
  clocks.video = relation(0);
  clocks.host_from_camera_us = us_in(random.uniform(-host_apart_s, host_apart_s));
  return clocks;
}

}  // namespace

RunClocks clocks_of_run(const ClockPhysics& physics, std::uint64_t seed, std::string_view object, int run_number,
                        double longest_run_s) {
  const std::string run = std::to_string(run_number);
  const bool is_shared = shares_a_session(physics, seed, object);
  // Both kinds of session names have the same form.
  const std::string_view session = is_shared ? std::string_view("all") : std::string_view(run);
  const std::uint64_t session_seed = seed_for(seed, {"session", object, session});
  Random random(session_seed);
  RunClocks clocks = started_clocks(physics, random);
  clocks.session = fmt::format("session-{:016x}", seed_for(seed, {"session's name", object, session}));
  if (!is_shared || run_number == 1) return clocks;

  // Every run gets the time of the longest, so that its start does not depend on other runs. Whole milliseconds are whole
  // read-outs.
  std::int64_t start_ms = 0;
  for (int earlier = 1; earlier < run_number; ++earlier) {
    Random for_gap(seed_for(seed, {"gap after a run", object, std::to_string(earlier)}));
    start_ms += std::llround(1e3 * (longest_run_s + drawn(physics.between_runs_s, for_gap)));
  }
  Random for_run(seed_for(seed, {"run of a session", object, run}));
  return continued_clocks(started_clocks(physics, for_run), clocks, camera_time(clocks.camera_start_us + 1000 * start_ms));
}

RunClocks continued_clocks(const RunClocks& drawn, const RunClocks& first, CameraTime start) {
  RunClocks clocks;
  clocks.session = first.session;
  clocks.camera_start_us = us_of(start);
  clocks.host_from_camera_us = first.host_from_camera_us;
  const auto first_stamp_in_camera = [&](const ClockRelation& relation) {
    return start - (camera_time(drawn.camera_start_us) - relation.camera_from(relation.reference_us));
  };
  const std::int64_t robot_us = first.robot.clock_us_from(first_stamp_in_camera(drawn.robot));
  clocks.robot = {.offset_us = us_of(first.robot.camera_from(robot_us)) - robot_us,
                  .drift_ppm = first.robot.drift_ppm,
                  .reference_us = robot_us};
  clocks.video = {.offset_us = us_of(first_stamp_in_camera(drawn.video)), .drift_ppm = first.video.drift_ppm, .reference_us = 0};
  return clocks;
}

}  // namespace tactile::simulation
