#include <gtest/gtest.h>

#include <limits>

#include "events/aedat4_bytes.hpp"
#include "events/made_streams.hpp"
#include "events/recording_contents.hpp"
#include "events/rewrite.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::events {
namespace {

using test::event;
using test::mini;
using test::other_stream;
using test::random_events;

TEST(RecordingPackets, HoldNoMoreThanTheirSpanAndTheirCount) {
  const test::TemporaryFolder folder;
  const auto file = folder / "a.aedat4";
  const auto events = random_events(5, 50'000, 1'700'000'000'000'000, 40);  // a second
  {
    RecordingWriter writer(file, {mini}, {.packet_span = 3ms, .packet_events = 140});
    Random random(6);
    for (std::size_t at = 0; at < events.size();) {  // however they come in
      const std::size_t count = std::min<std::size_t>(random.below(400), events.size() - at);
      writer.write_events(0, std::span(events).subspan(at, count));
      at += count;
    }
    writer.close();
  }
  RecordingReader recording(file);
  std::size_t by_count = 0;
  std::size_t by_span = 0;
  CameraTime last = recording.packets()[0].first;
  for (const PacketRecord& packet : recording.packets()) {
    ASSERT_GT(packet.elements, 0);
    ASSERT_LE(packet.elements, 140);
    ASSERT_LT(packet.last - packet.first, 3ms);
    ASSERT_GE(packet.first, last);
    last = packet.last;
    by_count += packet.elements == 140 ? 1U : 0U;
    by_span += packet.elements < 140 ? 1U : 0U;
  }
  EXPECT_GT(by_count, 10U);
  EXPECT_GT(by_span, 10U);
  EXPECT_EQ(test::contents_of(recording).events, events);
}

TEST(RecordingPackets, AreTheSameHoweverTheEventsComeIn) {
  const test::TemporaryFolder folder;
  auto events = random_events(7, 5'000, 0, 20);
  RecordingWriter whole(folder / "whole.aedat4", {mini});
  whole.write_events(0, events);
  whole.close();
  RecordingWriter single(folder / "single.aedat4", {mini});
  for (Event& e : events) {
    e.padding[1] = 77;  // is not part of an event
    single.write_events(0, {&e, 1});
  }
  single.close();
  EXPECT_EQ(test::bytes_of(folder / "whole.aedat4"), test::bytes_of(folder / "single.aedat4"));
}

TEST(RecordingPackets, BreakAtWholeSpansFromTheirFirstEvent) {
  const test::TemporaryFolder folder;
  const auto file = folder / "a.aedat4";
  RecordingWriter writer(file, {mini});
  writer.write_events(0, std::vector<Event>{event(5, 1, 1, 1), event(10'004, 1, 1, 1), event(10'005, 2, 2, 0),
                                            event(20'004, 3, 3, 0), event(500'000, 4, 4, 1)});
  writer.close();
  RecordingReader recording(file);
  ASSERT_EQ(recording.packets().size(), 3U) << "and none for the time without events";
  EXPECT_EQ(recording.packets()[0].last, camera_time(10'004));
  EXPECT_EQ(recording.packets()[1].first, camera_time(10'005));
  EXPECT_EQ(recording.packets()[1].last, camera_time(20'004));
  EXPECT_EQ(recording.packets()[2].first, camera_time(500'000));
}

TEST(RecordingPackets, AreNotWrittenEmpty) {
  const test::TemporaryFolder folder;
  const auto file = folder / "a.aedat4";
  RecordingWriter writer(file, {mini, other_stream(1, StreamType::imu, "imu")});
  writer.write_events(0, {});
  writer.write_imu(1, {});
  writer.flush();
  writer.flush();
  writer.close();
  writer.close();
  RecordingReader recording(file);
  EXPECT_EQ(recording.index(), PacketIndex::table) << recording.problems().table;
  EXPECT_TRUE(recording.packets().empty());
  EXPECT_EQ(recording.problems().empty_packets, 0U);
}

TEST(RecordingPackets, HoldTimesAtTheEndsOfInt64) {
  const test::TemporaryFolder folder;
  const auto file = folder / "a.aedat4";
  constexpr auto low = std::numeric_limits<std::int64_t>::min();
  constexpr auto high = std::numeric_limits<std::int64_t>::max();
  const std::vector<Event> events{event(low, 1, 1, 1),      event(low + 1, 2, 2, 0), event(-1, 3, 3, 1),  event(0, 4, 4, 1),
                                  event(high - 1, 5, 5, 0), event(high, 6, 6, 1),    event(high, 7, 7, 1)};
  RecordingWriter writer(file, {mini});
  writer.write_events(0, events);
  writer.close();
  RecordingReader recording(file);
  EXPECT_EQ(recording.packets().size(), 3U);
  EXPECT_EQ(test::contents_of(recording).events, events);
}

TEST(RecordingPackets, TakeNothingOfAnInvalidSpan) {
  const test::TemporaryFolder folder;
  const auto file = folder / "a.aedat4";
  RecordingWriter writer(file, {mini, other_stream(1, StreamType::imu, "imu"), other_stream(2, StreamType::triggers, "triggers"),
                                other_stream(3, StreamType::frames, "frames")});
  const std::vector<Event> sound{event(100, 0, 0, 0), event(100, 639, 479, 1)};
  writer.write_events(0, sound);
  const Event good = event(200, 5, 5, 1);
  for (const Event& bad : {event(99, 1, 1, 1), event(199, 1, 1, 1), event(300, 640, 1, 1), event(300, 1, 480, 1),
                           event(300, -1, 1, 1), event(300, 1, -1, 1), event(300, 1, 1, 2)}) {
    EXPECT_THROW(writer.write_events(0, std::vector<Event>{good, bad}), Error);
  }
  EXPECT_THROW(writer.write_events(0, std::vector<Event>{event(99, 1, 1, 1)}), Error) << "older than what was written before";
  EXPECT_THROW(writer.write_events(9, sound), Error);
  EXPECT_THROW(writer.write_events(1, sound), Error);
  ImuSample sample;
  sample.t = camera_time(50);
  ImuSample older;
  older.t = camera_time(49);
  EXPECT_THROW(writer.write_imu(1, std::vector<ImuSample>{sample, older}), Error);
  EXPECT_THROW(writer.write_triggers(2, std::vector<Trigger>{{.t = camera_time(2)}, {.t = camera_time(1)}}), Error);
  Frame frame;
  frame.width = 2;
  frame.height = 2;
  frame.pixels.resize(3);
  EXPECT_THROW(writer.write_frame(3, frame), Error);
  frame.pixels.resize(4);
  frame.format = -1;
  EXPECT_THROW(writer.write_frame(3, frame), Error);
  frame.format = 16;
  EXPECT_THROW(writer.write_frame(3, frame), Error);
  writer.close();
  EXPECT_THROW(writer.write_events(0, sound), Error) << "closed";
  const auto all = test::contents_of(file);
  EXPECT_EQ(all.events, sound);
  EXPECT_TRUE(all.imu.empty() && all.triggers.empty() && all.frames.empty());
}

TEST(RecordingPackets, KeepEveryFieldOfTheOtherStreams) {
  const test::TemporaryFolder folder;
  const auto file = folder / "a.aedat4";
  std::vector<ImuSample> imu(50);
  std::vector<Trigger> triggers(30);
  for (std::size_t i = 0; i < imu.size(); ++i) {
    const auto f = static_cast<float>(i);
    imu[i] = {.t = camera_time(1'000'000 + 1250 * static_cast<std::int64_t>(i)),
              .temperature_c = 30.F + f,
              .acceleration_g = {f, -f, 0.F},
              .angular_rate_dps = {f / 3.F, std::numeric_limits<float>::infinity(), -1.F},
              .magnetic_field_ut = {f * 1e-30F, 4.F, std::numeric_limits<float>::max()}};
  }
  for (std::size_t i = 0; i < triggers.size(); ++i) {
    triggers[i] = {.t = camera_time(static_cast<std::int64_t>(i / 3)), .type = static_cast<std::int8_t>(i % 10)};
  }
  std::vector<Frame> frames;
  for (const int format : {0, 16, 24, 2, 5}) {
    Frame frame;
    frame.t = camera_time(40'000 * (1 + static_cast<std::int64_t>(frames.size())));
    frame.frame_start = before(frame.t, 900us);
    frame.frame_end = after(frame.t, 901us);
    frame.exposure_start = before(frame.t, 400us);
    frame.exposure_end = after(frame.t, 402us);
    frame.format = static_cast<std::int8_t>(format);
    frame.width = 31;
    frame.height = 17;
    frame.position_x = 3;
    frame.position_y = -4;
    const std::size_t bytes = format == 16 ? 3 : format == 24 ? 4 : format == 2 ? 2 : format == 5 ? 4 : 1;
    for (std::size_t i = 0; i < std::size_t{31} * 17 * bytes; ++i) frame.pixels.push_back(static_cast<std::uint8_t>(i * 7 + 1));
    frames.push_back(frame);
  }
  {
    RecordingWriter writer(file, {mini, other_stream(1, StreamType::frames, "frames"), other_stream(2, StreamType::imu, "imu"),
                                  other_stream(3, StreamType::triggers, "triggers")});
    writer.write_imu(2, imu);
    writer.write_triggers(3, triggers);
    for (const Frame& frame : frames) writer.write_frame(1, frame);
    writer.close();
  }
  RecordingReader recording(file);
  const auto all = test::contents_of(recording);
  EXPECT_TRUE(test::same(all.imu, imu));
  EXPECT_TRUE(test::same(all.triggers, triggers));
  EXPECT_TRUE(test::same(all.frames, frames));
  for (const PacketRecord& packet : recording.packets()) EXPECT_LT(packet.last - packet.first, 10ms);
}

TEST(RecordingPackets, OfAFrameAreInTheFileAtOnce) {
  const test::TemporaryFolder folder;
  const auto file = folder / "a.aedat4";
  Frame frame;
  frame.width = 2;
  frame.height = 1;
  frame.pixels = {10, 20};
  RecordingWriter writer(file, {other_stream(1, StreamType::frames, "frames")});
  writer.write_frame(1, frame);
  EXPECT_EQ(writer.written().at(0).packets, 1U);
  EXPECT_TRUE(test::same(test::contents_of(file).frames, std::vector<Frame>{frame}));
}

TEST(RecordingPackets, OfTwoCamerasStayApart) {
  const test::TemporaryFolder folder;
  const auto file = folder / "a.aedat4";
  Stream right = mini;
  right.id = 5;
  right.source = "DVXplorer_DXM00002";
  const auto of_left = random_events(8, 3000, 1000, 30);
  const auto of_right = random_events(9, 2000, 500, 40);
  {
    RecordingWriter writer(file, {mini, right});
    for (std::size_t at = 0; at < 2000; at += 100) {
      writer.write_events(5, std::span(of_right).subspan(at, 100));
      writer.write_events(0, std::span(of_left).subspan(at, 100));
    }
    writer.write_events(0, std::span(of_left).subspan(2000));
    writer.close();
  }
  RecordingReader recording(file);
  for (const auto& [choice, expected] : {std::pair{"DVXplorer_DXM00001", &of_left}, {"5", &of_right}}) {
    std::vector<Event> read;
    for_all_events(recording, event_stream(recording, choice).id,
                   [&](std::span<const Event> events) { read.insert(read.end(), events.begin(), events.end()); });
    EXPECT_EQ(read, *expected);
  }
}

}  // namespace
}  // namespace tactile::events
