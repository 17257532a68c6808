#include "tactile/events/run_ticks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "events/made_recording.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"

namespace tactile::events {
namespace {

/// The ticks that follow a run, each with the number of events that were given before it and lie before it.
struct Followed {
  std::vector<Event> given;
  std::vector<std::pair<std::int64_t, std::size_t>> ticks;

  TickFollower follower() {
    return {[this](std::span<const Event> events) { given.insert(given.end(), events.begin(), events.end()); },
            [this](CameraTime t) {
              const auto before = std::count_if(given.begin(), given.end(), [t](const Event& event) { return event.t < t; });
              ticks.emplace_back(us_of(t), static_cast<std::size_t>(before));
            }};
  }
};

const SensorSize sensor{50, 50};

TEST(FollowTicks, GivesAllEventsBeforeATickThenTheTick) {
  // Events at 100, 1100, ... 9100 us: a history of 4 ms fits from 4100 us on, and the last tick is at 8 ms.
  const std::vector<Event> events = test::steady_events(10, 100, 1'000, sensor);
  Followed followed;
  const TickRange ticks = follow_ticks(events, 4ms, 2ms, followed.follower());
  EXPECT_EQ(followed.ticks, (std::vector<std::pair<std::int64_t, std::size_t>>{{6'000, 6}, {8'000, 8}}));
  EXPECT_EQ(ticks.count, 2);
  EXPECT_EQ(ticks.first, CameraTime{6ms});
  EXPECT_EQ(followed.given, events);
}

TEST(FollowTicks, OfARecordingAreThoseOfItsEvents) {
  const test::TemporaryFolder folder;
  const std::vector<Event> events = test::steady_events(30'000, 500, 7, sensor);
  test::write_plain_recording(folder / "events.aedat4", events, sensor);
  Followed whole, recorded;
  const TickRange ticks = follow_ticks(events, 10ms, 2ms, whole.follower());
  RecordingReader reader(folder / "events.aedat4");
  const std::int32_t stream = event_stream(reader).id;
  EXPECT_EQ(follow_ticks(reader, stream, 10ms, 2ms, recorded.follower()).count, ticks.count);
  EXPECT_EQ(recorded.ticks, whole.ticks);
  EXPECT_EQ(listed_ticks(reader, stream, 10ms, 2ms).count, ticks.count);

  // Without its events a run has the same ticks.
  Followed changed;
  const ChangeEvents none = [](std::span<const Event>, bool) { return std::span<const Event>(); };
  RecordingReader again(folder / "events.aedat4");
  EXPECT_EQ(follow_ticks(again, stream, 10ms, 2ms, changed.follower(), none).count, ticks.count);
  EXPECT_EQ(changed.ticks.size(), whole.ticks.size());
  EXPECT_EQ(changed.ticks.back().second, 0U);
}

TEST(FollowTicks, RefusesMoreTicksThanMemoryHolds) {
  std::vector<Event> events = test::steady_events(2, 0, 100, sensor);
  events.push_back(events.back());
  events.back().t = CameraTime{std::chrono::hours{24 * 365}};
  Followed followed;
  EXPECT_THROW(follow_ticks(events, 10ms, 2ms, followed.follower()), Error);
  EXPECT_TRUE(followed.ticks.empty());
}

}  // namespace
}  // namespace tactile::events
