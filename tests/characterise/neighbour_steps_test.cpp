#include "tactile/characterise/neighbour_steps.hpp"

#include <gtest/gtest.h>

#include "characterise/made_sensor.hpp"

namespace tactile::characterise {
namespace {

NeighbourSteps steps_of(const test::MadeSensor& made, const std::vector<events::Event>& events) {
  NeighbourSteps steps(made.size, camera_time(1'000'000));
  steps.add(events);
  return steps;
}

const test::MadeSensor made{.seconds = 0.3};

TEST(NeighbourSteps, AreCorrelatedAsTheFormulaSays) {
  NeighbourSteps steps({2, 1}, camera_time(0));
  EXPECT_EQ(steps.correlation(0), 0) << "without events";
  // Both fire in the same 10 of 100 steps.
  for (int i = 0; i < 10; ++i) steps.add(std::vector{test::event(20'000 * i, 0, 0, 1), test::event(20'000 * i + 1'999, 1, 0, 0)});
  const double variance = 0.1 * 0.9;
  EXPECT_NEAR(steps.correlation(0), variance / (2 * 2 * variance), 1e-12);
  EXPECT_NEAR(steps.correlation(10), variance / (2 * 2 * variance), 1e-12);
  EXPECT_NEAR(steps.correlation(5), -10.0 / 95 * 9 / 95 / (2 * 2 * variance), 1e-12);
  steps.add(std::vector{test::event(-1, 0, 0, 1), test::event(200'000, 0, 0, 1)});
  EXPECT_NEAR(steps.correlation(0), 0.25, 1e-12) << "outside the 0.2 s";
}

TEST(NeighbourSteps, OfNoiseAreNoMotion) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) EXPECT_FALSE(steps_of(made, events_of(made, seed)).is_motion()) << seed;
}

TEST(NeighbourSteps, OfEdgesAreMotion) {
  const NeighbourSteps steps = steps_of(made, with_edges(made, events_of(made, 1)));
  EXPECT_GT(steps.correlation(0), 0.01);
  EXPECT_TRUE(steps.is_motion());
}

TEST(NeighbourSteps, OfPulsesAreNoMotion) {
  for (const double hz : {20.0, 30.0, 37.0, 40.0, 83.3, 250.0}) {
    const NeighbourSteps steps = steps_of(made, with_pulses(made, events_of(made, 2), hz));
    EXPECT_GT(steps.correlation(0), 0.01) << hz;
    EXPECT_FALSE(steps.is_motion()) << hz;
  }
}

}  // namespace
}  // namespace tactile::characterise
