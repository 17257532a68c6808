#include "tactile/simulation/run_clocks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>
#include <string>

namespace tactile::simulation {
namespace {

constexpr std::array objects{"3d-printed-object", "uhu-glue-stick", "sprayer",           "water-bottle", "fan",
                             "white-box",         "textured-box",   "plastic-container", "small-box",    "usb-hub"};
constexpr double longest_run_s = 5;

RunClocks clocks_of(std::uint64_t seed, std::string_view object, int run, const ClockPhysics& physics = {}) {
  return clocks_of_run(physics, seed, object, run, longest_run_s);
}

std::set<std::string> sharing(std::uint64_t seed, const ClockPhysics& physics = {}) {
  std::set<std::string> found;
  for (const char* object : objects) {
    if (clocks_of(seed, object, 1, physics).session == clocks_of(seed, object, 2, physics).session) found.insert(object);
  }
  return found;
}

void expect_same(const ClockRelation& a, const ClockRelation& b) {
  EXPECT_EQ(a.offset_us, b.offset_us);
  EXPECT_EQ(a.drift_ppm, b.drift_ppm);
  EXPECT_EQ(a.reference_us, b.reference_us);
}

TEST(ClocksOfRun, AreSharedByTheRunsOfExactlyHalfTheObjects) {
  std::set<std::string> sharing_once;
  std::set<std::set<std::string>> halves;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const std::set<std::string> half = sharing(seed);
    EXPECT_EQ(half.size(), 5U) << "seed " << seed;
    sharing_once.insert(half.begin(), half.end());
    halves.insert(half);
  }
  EXPECT_EQ(sharing_once.size(), objects.size()) << "any object may be among them";
  EXPECT_GT(halves.size(), 20U) << "the seed chooses";
  for (const auto& [share, count] : {std::pair{0.0, 0U}, {0.39, 3U}, {0.7, 7U}, {1.0, 10U}}) {
    ClockPhysics physics;
    physics.shared_session_share = share;
    EXPECT_EQ(sharing(1, physics).size(), count) << share;
  }
}

TEST(ClocksOfRun, OfAnotherObjectAreSharedByChanceAndChangeNoOthers) {
  int shared = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed)
    shared += clocks_of(seed, "a mug", 1).session == clocks_of(seed, "a mug", 7).session;
  EXPECT_NEAR(shared, 100, 30);
}

TEST(ClocksOfRun, AreOneSetThatRunsOnInASession) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    for (const std::string& object : sharing(seed)) {
      const RunClocks first = clocks_of(seed, object, 1);
      RunClocks before = first;
      for (int run = 2; run <= 10; ++run) {
        const RunClocks clocks = clocks_of(seed, object, run);
        EXPECT_EQ(clocks.session, first.session);
        EXPECT_EQ(clocks.host_from_camera_us, first.host_from_camera_us);
        EXPECT_EQ(clocks.robot.drift_ppm, first.robot.drift_ppm);
        EXPECT_EQ(clocks.video.drift_ppm, first.video.drift_ppm);
        // A stamp of the controller is the same instant to whichever run it is given.
        for (const std::int64_t stamp :
             {first.robot.reference_us, clocks.robot.reference_us, clocks.robot.reference_us + 60'000'000})
          EXPECT_NEAR(static_cast<double>((clocks.robot.camera_from(stamp) - first.robot.camera_from(stamp)).count()), 0.0, 1.0);
        const double after_s = 1e-6 * static_cast<double>(clocks.camera_start_us - before.camera_start_us);
        EXPECT_GE(after_s, longest_run_s + 20 - 0.001);
        EXPECT_LE(after_s, longest_run_s + 60 + 0.001);
        before = clocks;
      }
    }
  }
}

TEST(ClocksOfRun, AreEveryRunsOwnOtherwise) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const std::set<std::string> half = sharing(seed);
    for (const std::string object : objects) {
      if (half.contains(object)) continue;
      std::set<std::string> sessions;
      std::set<double> drifts;
      std::set<std::int64_t> starts;
      for (int run = 1; run <= 10; ++run) {
        const RunClocks clocks = clocks_of(seed, object, run);
        sessions.insert(clocks.session);
        starts.insert(clocks.camera_start_us);
        drifts.insert({clocks.robot.drift_ppm, clocks.video.drift_ppm});
      }
      EXPECT_EQ(sessions.size(), 10U);
      EXPECT_EQ(starts.size(), 10U);
      EXPECT_EQ(drifts.size(), 20U);
    }
  }
}

TEST(ClocksOfRun, DependOnNoOtherRun) {
  for (const std::string object : objects) {
    const RunClocks alone = clocks_of(3, object, 3);
    for (int run = 1; run <= 5; ++run) clocks_of(3, object, run);
    const RunClocks among_others = clocks_of(3, object, 3);
    EXPECT_EQ(alone.session, among_others.session);
    EXPECT_EQ(alone.camera_start_us, among_others.camera_start_us);
    expect_same(alone.robot, among_others.robot);
    expect_same(alone.video, among_others.video);
  }
}

TEST(ClocksOfRun, StayWithinWhatIsStated) {
  double least_drift = 0, most_drift = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    for (const std::string object : objects) {
      for (const int run : {1, 4}) {
        const RunClocks clocks = clocks_of(seed, object, run);
        EXPECT_EQ(clocks.video.reference_us, 0);
        for (const ClockRelation& relation : {clocks.robot, clocks.video}) {
          least_drift = std::min(least_drift, relation.drift_ppm);
          most_drift = std::max(most_drift, relation.drift_ppm);
          const double before_s =
              1e-6 * static_cast<double>(clocks.camera_start_us - us_of(relation.camera_from(relation.reference_us)));
          EXPECT_GE(before_s, 0.1 - 2e-6);
          EXPECT_LE(before_s, 1.5 + 2e-6);
        }
        EXPECT_GE(clocks.robot.reference_us, 600'000'000);
      }
    }
  }
  EXPECT_GE(least_drift, -100);
  EXPECT_LT(least_drift, -80);
  EXPECT_LE(most_drift, 100);
  EXPECT_GT(most_drift, 80);
}

TEST(ClocksOfRun, GiveASessionANameWithoutOtherInformation) {
  std::set<std::string> names;
  for (const std::string object : objects) {
    for (int run = 1; run <= 3; ++run) names.insert(clocks_of(8, object, run).session);
  }
  EXPECT_EQ(names.size(), 5U + 5U * 3U);
  for (const std::string& name : names) {
    EXPECT_EQ(name.size(), 24U);
    EXPECT_EQ(name.find_first_not_of("0123456789abcdef", 8), std::string::npos) << name;
  }
}

TEST(ContinuedClocks, KeepTheirRates) {
  RunClocks first, drawn;
  first.session = "monday";
  first.camera_start_us = 10'000'000;
  first.host_from_camera_us = -7;
  first.robot = {.offset_us = 4'000'000, .drift_ppm = 100, .reference_us = 5'000'000};  // it began at 9 s of the camera
  first.video = {.offset_us = 9'500'000, .drift_ppm = -50, .reference_us = 0};
  drawn.camera_start_us = 77'000'000;
  drawn.robot = {.offset_us = 70'000'000, .drift_ppm = 3, .reference_us = 6'750'000};  // a quarter of a second before the camera
  drawn.video = {.offset_us = 76'000'000, .drift_ppm = 4, .reference_us = 0};          // a second
  const RunClocks next = continued_clocks(drawn, first, camera_time(1'010'000'000));
  EXPECT_EQ(next.session, "monday");
  EXPECT_EQ(next.camera_start_us, 1'010'000'000);
  EXPECT_EQ(next.host_from_camera_us, -7);
  EXPECT_EQ(next.video.offset_us, 1'009'000'000);
  EXPECT_EQ(next.video.drift_ppm, -50);
  // At 1009.75 s of the camera the robot has counted 1000.75 s / 1.0001 since its stamp of 5 s.
  EXPECT_EQ(next.robot.reference_us, 5'000'000 + 1'000'649'935);
  EXPECT_EQ(us_of(next.robot.camera_from(next.robot.reference_us)), 1'009'750'000);
  EXPECT_EQ(next.robot.drift_ppm, 100);
}

}  // namespace
}  // namespace tactile::simulation
