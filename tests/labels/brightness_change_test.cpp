#include "tactile/labels/brightness_change.hpp"

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile {
namespace {

Event event(std::int64_t t_us, int x, int y, bool on) {
  Event made;
  made.t = camera_time(t_us);
  made.x = static_cast<std::int16_t>(x);
  made.y = static_cast<std::int16_t>(y);
  made.on = on ? 1 : 0;
  return made;
}

std::vector<BrightnessChange> changes(const std::vector<Event>& events, const std::vector<CameraSpan>& spans,
                                      const std::vector<std::uint32_t>& hot = {}) {
  const test::TemporaryFolder folder;
  RecordingWriter writer(folder / "events.aedat4", {event_stream_declaration({10, 6}, "TEST")});
  writer.write_events(0, events);
  writer.close();
  RecordingReader recording(folder / "events.aedat4");
  return brightness_changes(recording, 0, spans, hot);
}

TEST(BrightnessChanges, CountBrighterLessDarkerInBlocksOfFourPixels) {
  // 10x6 px are 3x2 blocks.
  const auto change = changes({event(10, 0, 0, true), event(20, 3, 3, true), event(30, 4, 0, false), event(40, 9, 5, true)},
                              {{camera_time(0), camera_time(100)}});
  ASSERT_EQ(change.size(), 1U);
  EXPECT_EQ(change[0].blocks, (std::vector<float>{2, -1, 0, 0, 0, 1}));
}

TEST(BrightnessChanges, CancelWhatGoesToAndFroAndKeepSpansApart) {
  const std::vector<Event> events = {event(10, 0, 0, true), event(20, 0, 0, false), event(30, 0, 0, true)};
  const auto change = changes(events, {{camera_time(0), camera_time(30)}, {camera_time(20), camera_time(31)}});
  ASSERT_EQ(change.size(), 2U);
  EXPECT_EQ(change[0].blocks[0], 0);
  EXPECT_EQ(change[1].blocks[0], 0);
  EXPECT_EQ(changes(events, {{camera_time(10), camera_time(11)}})[0].blocks[0], 1);
}

TEST(BrightnessChanges, LeaveHotPixelsOut) {
  EXPECT_EQ(changes({event(10, 5, 2, true)}, {{camera_time(0), camera_time(100)}}, {25})[0].blocks[1], 0);
}

TEST(Likeness, IsOneForTheSameMinusOneForTheReverseAndZeroForNothing) {
  const BrightnessChange a{{1, -2, 3}}, back{{-2, 4, -6}}, aside{{2, 1, 0}}, nothing{{0, 0, 0}};
  EXPECT_DOUBLE_EQ(likeness(a, a), 1);
  EXPECT_DOUBLE_EQ(likeness(a, back), -1);
  EXPECT_DOUBLE_EQ(likeness(a, aside), 0);
  EXPECT_DOUBLE_EQ(likeness(a, nothing), 0);
}

}  // namespace
}  // namespace tactile
