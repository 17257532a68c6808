#include "tactile/labels/event_rate.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "labels/made_run.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"

namespace tactile {
namespace {

TEST(EventRate, CountsEveryEventButThoseOfHotPixels) {
  const test::TemporaryFolder folder;
  test::write_made_events(folder / "events.aedat4", {.bursts = {{1'000'000, 1'200'000}}, .hot_pixels = 7});
  RecordingReader recording(folder / "events.aedat4");
  const EventRate rate = event_rate(recording, 0);
  EXPECT_EQ(rate.hot_pixels, 7U);
  ASSERT_EQ(rate.counts.size(), 15'000U);
  const auto sum = [&](std::size_t begin, std::size_t end) {
    return std::accumulate(rate.counts.begin() + static_cast<long>(begin), rate.counts.begin() + static_cast<long>(end), 0.0);
  };
  EXPECT_NEAR(sum(0, 5'000), 15'000, 700);
  EXPECT_NEAR(sum(5'000, 6'000), 43'000, 1'200);
}

TEST(EventRate, RefusesARecordingWithoutEvents) {
  const test::TemporaryFolder folder;
  RecordingWriter(folder / "empty.aedat4", {event_stream_declaration({64, 48}, "DVXplorer_TEST")}).close();
  RecordingReader recording(folder / "empty.aedat4");
  EXPECT_THROW(event_rate(recording, 0), Error);
}

TEST(EventRate, RefusesARecordingThatSpansHours) {
  const test::TemporaryFolder folder;
  RecordingWriter writer(folder / "long.aedat4", {event_stream_declaration({64, 48}, "DVXplorer_TEST")});
  std::vector<Event> events(2);
  events[0].t = camera_time(0);
  events[1].t = camera_time(86'400'000'000);
  writer.write_events(0, events);
  writer.close();
  RecordingReader recording(folder / "long.aedat4");
  EXPECT_THROW(event_rate(recording, 0), Error);
}

}  // namespace
}  // namespace tactile
