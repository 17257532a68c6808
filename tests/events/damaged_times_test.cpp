// Times that overflowed or were damaged.
#include <gtest/gtest.h>

#include <limits>

#include "events/aedat4_bytes.hpp"
#include "events/damaged_recording.hpp"
#include "events/recording_contents.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::events {
namespace {

using test::DamagedRecording;
using test::event;
using test::event_node;
using test::event_payload;
using test::file_start;
using test::one_camera;
using test::packet;
using test::put;
using test::row_of_events;
using test::with_table;
using test::xml_of;

constexpr std::int64_t wrap = std::int64_t{1} << 32;

/// The packets of `all`, with a table or without.
std::string recording_of(const std::vector<std::vector<Event>>& all, bool table) {
  std::string bytes = file_start(0, one_camera);
  std::vector<test::TableEntry> entries;
  for (const auto& events : all) {
    const std::string payload = event_payload(events);
    entries.push_back({.offset = static_cast<std::int64_t>(bytes.size() + 8),
                       .id = 0,
                       .size = static_cast<std::int32_t>(payload.size()),
                       .elements = static_cast<std::int64_t>(events.size()),
                       .first = us_of(events.front().t),
                       .last = us_of(events.back().t)});
    bytes += packet(0, payload);
  }
  return table ? with_table(bytes, test::table_of(entries)) : bytes;
}

TEST_F(DamagedRecording, PutsRightTimesThatWentBackBy2To32) {
  const std::int64_t base = 1'600'000'000'000'000;
  for (const bool table : {false, true}) {
    // What was recorded in two hours: 32 bits of microseconds with a sign wrap after 2147 s and after 6442 s.
    const std::vector<std::int64_t> wraps{0, 0, 1, 1, 1, 2};
    std::vector<std::int64_t> truth;
    for (const std::int64_t s : {0, 2000, 3000, 4500, 6000, 7000}) truth.push_back(base + s * 1'000'000);
    std::vector<std::vector<Event>> packets;
    for (std::size_t i = 0; i < truth.size(); ++i) packets.push_back(row_of_events(truth[i] - wraps[i] * wrap, 5));
    RecordingReader recording = reader_of(recording_of(packets, table));
    EXPECT_EQ(recording.index(), table ? PacketIndex::table : PacketIndex::scan) << recording.problems().table;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      EXPECT_EQ(us_of(recording.packets()[i].first), truth[i]) << i;
      EXPECT_EQ(us_of(recording.packets()[i].last), truth[i] + 4) << i;
      for (int time = 0; time < 2; ++time) {
        const auto events = recording.read_events(recording.packets()[i]);
        EXPECT_EQ(us_of(events.front().t), truth[i]) << i;
        EXPECT_EQ(us_of(events.back().t), truth[i] + 4) << i;
      }
    }
    EXPECT_EQ(recording.problems().unwrapped_packets, 4U);
    std::size_t found = 0;
    for_events_between(recording, 0, camera_time(truth[4] + 1), camera_time(truth[5] + 2),
                       [&](auto events) { found += events.size(); });
    EXPECT_EQ(found, 6U);
  }
}

TEST_F(DamagedRecording, PutsRightAWrapInsideAPacket) {
  for (const bool table : {false, true}) {
    const std::vector<Event> first{event(1000, 1, 1, 1), event(1001, 2, 2, 1), event(1002 - wrap, 3, 3, 0),
                                   event(1003 - wrap, 4, 4, 0)};
    RecordingReader recording = reader_of(recording_of({first, row_of_events(2000 - wrap, 3)}, table));
    EXPECT_EQ(recording.index(), PacketIndex::scan) << "its table has an entry that ends before it begins";
    const auto all = test::contents_of(recording).events;
    std::vector<std::int64_t> times;
    for (const Event& e : all) times.push_back(us_of(e.t));
    EXPECT_EQ(times, (std::vector<std::int64_t>{1000, 1001, 1002, 1003, 2000, 2001, 2002}));
    EXPECT_EQ(recording.problems().unwrapped_packets, 2U);
  }
}

TEST_F(DamagedRecording, TakesOneDamagedTimeForNoOverflow) {
  const std::int64_t base = 1'600'000'000'000'000;
  for (const std::int64_t off : {wrap, -wrap, wrap - 1'000'000'000, 1'000'000'000 - wrap}) {
    for (const bool table : {false, true}) {
      for (const std::size_t hit : {std::size_t{0}, std::size_t{4}, std::size_t{9}}) {
        std::vector<std::vector<Event>> packets;
        for (int p = 0; p < 5; ++p) packets.push_back(row_of_events(base + 1000 * p, 10));
        std::vector<std::vector<Event>> expected = packets;
        packets[2][hit].t += microseconds{off};
        RecordingReader recording = reader_of(recording_of(packets, table));
        for (int time = 0; time < 2; ++time) {  // read again, they are the same
          for (std::size_t p = 0; p < packets.size(); ++p) {
            const auto read = recording.read_events(recording.packets()[p]);
            ASSERT_EQ(read.size(), 10U);
            for (std::size_t i = 0; i < 10; ++i) {
              if (p == 2 && i == hit) continue;
              EXPECT_EQ(read[i].t, expected[p][i].t) << p << ", " << i << " where " << hit << " is off by " << off;
            }
            // A packet's last time that is too early may be an overflow; the next packet decides.
            if (p == 2 && !(off < 0 && hit == 9)) {
              EXPECT_EQ(us_of(read[hit].t), us_of(packets[2][hit].t)) << hit << " is off by " << off;
            }
          }
        }
        for (const std::size_t p : {0U, 1U, 3U, 4U}) {
          EXPECT_EQ(recording.packets()[p].first, expected[p].front().t) << p << " where " << hit << " is off by " << off;
          EXPECT_EQ(recording.packets()[p].last, expected[p].back().t) << p << " where " << hit << " is off by " << off;
        }
        std::size_t found = 0;
        for_events_between(recording, 0, expected[2][1].t, expected[3][5].t, [&](auto events) { found += events.size(); });
        EXPECT_GE(found, 13U) << hit << " is off by " << off;
      }
    }
  }
}

TEST_F(DamagedRecording, DoesNotTakeADamagedTimeAfterAnOverflowForAnother) {
  const std::int64_t base = 1'600'000'000'000'000;
  for (const std::int64_t off : {wrap, -wrap}) {
    for (const bool table : {false, true}) {
      std::vector<std::vector<Event>> packets, expected;
      for (int p = 0; p < 6; ++p) {
        expected.push_back(row_of_events(base + 1000 * p, 10));
        packets.push_back(row_of_events(base + 1000 * p - (p == 0 ? 0 : wrap), 10));
      }
      packets[4][3].t += microseconds{off};
      RecordingReader recording = reader_of(recording_of(packets, table));
      for (std::size_t p = 0; p < packets.size(); ++p) {
        const auto read = recording.read_events(recording.packets()[p]);
        for (std::size_t i = 0; i < 10; ++i) {
          if (p != 4 || i != 3) {
            EXPECT_EQ(read[i].t, expected[p][i].t) << p << ", " << i << " with " << off;
          }
        }
      }
    }
  }
}

TEST_F(DamagedRecording, LeavesEveryOtherStepBack) {
  const std::int64_t t = 10'000'000'000;
  for (const std::int64_t step : {std::int64_t{-1}, std::int64_t{-1'000'000}, -(wrap / 2), -wrap - 5, -2 * wrap}) {
    for (const bool table : {false, true}) {
      const std::vector<std::vector<Event>> packets{{event(t, 1, 1, 1)}, {event(t + step, 2, 2, 0)}};
      RecordingReader recording = reader_of(recording_of(packets, table));
      const auto all = test::contents_of(recording).events;
      EXPECT_EQ(us_of(all[1].t) - us_of(all[0].t), step);
      EXPECT_EQ(recording.problems().unwrapped_packets, 0U);
    }
  }
  // The two corrected ones lie just inside.
  for (const std::int64_t step : {-(wrap / 2) - 1, -wrap}) {
    const auto all = contents_of(recording_of({{event(t, 1, 1, 1)}, {event(t + step, 2, 2, 0)}}, false)).events;
    EXPECT_EQ(us_of(all[1].t) - us_of(all[0].t), step + wrap);
  }
}

TEST_F(DamagedRecording, GivesAllEventsOfASpanThoughTheyAreOutOfOrder) {
  const std::vector<Event> mixed{event(50, 1, 1, 1), event(10, 2, 2, 1), event(30, 3, 3, 1), event(20, 4, 4, 1),
                                 event(40, 5, 5, 1)};
  RecordingReader recording = reader_of(recording_of({mixed}, false));
  EXPECT_EQ(recording.packets()[0].first, camera_time(10));
  EXPECT_EQ(recording.packets()[0].last, camera_time(50));
  std::vector<int> places;
  for_events_between(recording, 0, camera_time(20), camera_time(50), [&](auto events) {
    for (const Event& e : events) places.push_back(e.x);
  });
  EXPECT_EQ(places, (std::vector<int>{3, 4, 5}));
}

TEST_F(DamagedRecording, LeavesATimestampResetForOthersToJudge) {
  std::string trigger(56, '\0');  // one TIMESTAMP_RESET: its type is the default and left out
  put(trigger, 4, std::uint32_t{16});
  trigger.replace(8, 4, "TRIG");
  for (const auto& [at, value] : {std::pair{14, 6}, {16, 8}, {18, 4}, {36, 6}, {38, 12}, {40, 4}}) {
    put(trigger, static_cast<std::size_t>(at), static_cast<std::uint16_t>(value));
  }
  put(trigger, 20, std::int32_t{6});
  put(trigger, 24, std::uint32_t{4});
  put(trigger, 28, std::uint32_t{1});
  put(trigger, 32, std::uint32_t{12});
  put(trigger, 44, std::int32_t{8});
  put(trigger, 48, std::int64_t{5'000'000});
  const auto read = contents_of(file_start(0, xml_of(event_node(0, 640, 480, "A") + test::plain_node(3, "TRIG"))) +
                                packet(0, event_payload(row_of_events(5'000'000, 2))) + packet(3, test::prefixed(trigger)) +
                                packet(0, event_payload(row_of_events(0, 2))));
  ASSERT_EQ(read.triggers.size(), 1U);
  EXPECT_EQ(read.triggers[0].type, 0);
  EXPECT_EQ(read.triggers[0].t, camera_time(5'000'000));
  ASSERT_EQ(read.events.size(), 4U);
  EXPECT_EQ(read.events[1].t, camera_time(5'000'001));
  EXPECT_EQ(read.events[2].t, camera_time(0));
}

TEST_F(DamagedRecording, HoldsTimesUpToTheEndsOfInt64) {
  constexpr auto low = std::numeric_limits<std::int64_t>::min();
  constexpr auto high = std::numeric_limits<std::int64_t>::max();
  const std::vector<std::vector<Event>> packets{{event(low, 1, 1, 1), event(low + 1, 2, 2, 1)},
                                                {event(-1, 3, 3, 1), event(0, 4, 4, 1)},
                                                {event(high - 1, 5, 5, 1), event(high, 6, 6, 1)},
                                                {event(low, 7, 7, 1)}};
  for (const bool table : {false, true}) {
    RecordingReader recording = reader_of(recording_of(packets, table));
    const auto all = test::contents_of(recording).events;
    ASSERT_EQ(all.size(), 7U);
    EXPECT_EQ(us_of(all[0].t), low);
    EXPECT_EQ(us_of(all[5].t), high);
    EXPECT_EQ(us_of(all[6].t), low);
    EXPECT_EQ(recording.problems().unwrapped_packets, 0U);
    std::vector<int> places;
    for_events_between(recording, 0, CameraTime::min(), CameraTime::max(), [&](auto events) {
      for (const Event& e : events) places.push_back(e.x);
    });
    EXPECT_EQ(places, (std::vector<int>{1, 2, 3, 4, 5, 7})) << "the end is left out";
  }
}

}  // namespace
}  // namespace tactile::events
