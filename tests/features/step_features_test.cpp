#include "tactile/features/step_features.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "events/made_recording.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"

namespace tactile::features {
namespace {

constexpr events::SensorSize small_sensor{64, 48};

/// The features of each window by its definition, from all events.
std::array<float, step_values> by_definition(const std::vector<events::Event>& events, CameraTime tick,
                                             const StepWindows& windows) {
  std::array<float, step_values> values{};
  for (std::size_t k = 0; k < steps_of_history; ++k) {
    const CameraTime end = before(tick, windows.step * static_cast<std::int64_t>(steps_of_history - 1 - k));
    const auto first = std::lower_bound(events.begin(), events.end(), before(end, windows.window),
                                        [](const events::Event& event, CameraTime t) { return event.t < t; });
    const auto last =
        std::lower_bound(first, events.end(), end, [](const events::Event& event, CameraTime t) { return event.t < t; });
    EventSums sum;
    for (auto event = first; event != last; ++event) {
      EventSums::OfPolarity& of = sum.of[event->on];
      const auto x = static_cast<std::uint64_t>(event->x), y = static_cast<std::uint64_t>(event->y);
      ++of.events, of.x += x, of.y += y, of.xx += x * x, of.yy += y * y, of.xy += x * y;
      ++sum.cells[event->on][y * grid_rows / 48 * grid_columns + x * grid_columns / 64];
    }
    std::array<float, features_of_window> all{};
    window_features(sum, small_sensor, all);
    std::copy_n(all.begin(), features_of_step, values.begin() + static_cast<std::ptrdiff_t>(k * features_of_step));
  }
  return values;
}

std::vector<events::Event> random_events(std::size_t count) {
  Random random(3);
  std::vector<events::Event> events;
  std::int64_t t = 0;
  for (std::size_t i = 0; i < count; ++i) {
    t += static_cast<std::int64_t>(random.below(100));
    events.push_back(test::event_at(t, static_cast<int>(random.below(64)), static_cast<int>(random.below(48)),
                                    static_cast<int>(random.below(2))));
  }
  return events;
}

TEST(StepWindows, OverlapAndFillTheHistory) {
  const StepWindows usual = step_windows(40ms, 2ms, 2ms);
  EXPECT_EQ(usual.window, 10ms);
  EXPECT_EQ(usual.bin, 2ms);
  EXPECT_EQ(step_windows(40ms, 2ms, 1ms).bin, 1ms);
  EXPECT_EQ(step_windows(41ms, 2ms, 2ms).bin, 1ms);
  EXPECT_EQ(step_windows(31ms, 2ms, 2ms).window, 1ms);
  EXPECT_THROW(step_windows(30ms, 2ms, 2ms), Error);
  EXPECT_THROW(step_windows(20ms, 2ms, 2ms), Error);
  EXPECT_THROW(step_windows(40ms, 0ms, 2ms), Error);
  EXPECT_THROW(step_windows(40ms, 2ms, 7us), Error) << "40 000 bins";
}

TEST(StepFeatures, AreThoseOfTheirDefinitionAtAnyTicks) {
  const std::vector<events::Event> events = random_events(6'000);
  for (const microseconds tick : {2'000us, 1'000us, 4'000us, 500us}) {
    const StepWindows windows = step_windows(40ms, 2ms, tick);
    StepFeatures steps(small_sensor, windows);
    steps.add(events);
    Random random(5);
    for (CameraTime t{0us}; t < CameraTime{200ms}; t = after(t, tick * static_cast<std::int64_t>(1 + random.below(3)))) {
      steps.move_to(t);
      ASSERT_EQ(steps.features(), by_definition(events, t, windows)) << us_of(t) << ", " << tick.count();
    }
  }
}

TEST(StepFeatures, ReadAWindowAgainOnceEventsCameLater) {
  const std::vector<events::Event> events = random_events(4'000);
  const StepWindows windows = step_windows(40ms, 2ms, 2ms);
  StepFeatures steps(small_sensor, windows);
  auto given = events.begin();
  for (std::int64_t ms = 40; ms < 180; ms += 2) {
    const CameraTime t{microseconds{1000 * ms}};
    // As the detector does: it counts ahead, rehearses before all events of the tick are there, and rehearses again before those
    // that came are counted.
    for (const microseconds missing : {700us, 0us}) {
      const auto end = std::lower_bound(given, events.end(), before(t, missing),
                                        [](const events::Event& event, CameraTime time) { return event.t < time; });
      steps.add(std::span(given, end));
      given = end;
      steps.features();
      steps.move_to(t);
      const auto features = steps.features();
      if (missing == 0us) {
        ASSERT_EQ(features, by_definition(events, t, windows)) << ms;
      }
    }
  }
}

TEST(StepFeatures, AreFiniteBeforeTheFirstTickWithoutEventsAndSaturated) {
  StepFeatures steps(small_sensor, step_windows(40ms, 2ms, 2ms));
  const auto none = steps.features();
  steps.move_to(CameraTime{40ms});
  EXPECT_EQ(steps.features(), none) << "no events";
  std::vector<events::Event> many;
  for (std::int64_t i = 0; i < 400'000; ++i) many.push_back(test::event_at(40'000 + i / 10, 63, 47, 1));
  steps.add(many);
  steps.move_to(CameraTime{80ms});
  for (const float value : steps.features()) EXPECT_TRUE(std::isfinite(value));
  EXPECT_EQ(steps.events(), 400'000U);
}

TEST(StepFeatures, DoNotDriftWithinAYear) {
  const StepWindows windows = step_windows(40ms, 2ms, 2ms);
  StepFeatures steps(small_sensor, windows);
  const std::vector<events::Event> once = random_events(800);
  std::array<float, step_values> first{};
  for (std::int64_t day = 0; day <= 365; day += 5) {
    const microseconds later = std::chrono::days{day};
    std::vector<events::Event> events = once;
    for (events::Event& event : events) event.t = after(event.t, later);
    steps.add(events);
    steps.move_to(after(CameraTime{40ms}, later));
    if (day == 0) first = steps.features();
    ASSERT_EQ(steps.features(), first) << day;
  }
}

}  // namespace
}  // namespace tactile::features
