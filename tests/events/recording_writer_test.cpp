#include "tactile/events/recording_writer.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <limits>
#include <new>
#include <set>
#include <thread>

#include "events/aedat4_bytes.hpp"
#include "events/recording_contents.hpp"
#include "events/rewrite.hpp"
#include "support/comes_true.hpp"
#include "support/paths.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"

namespace tactile::events {
namespace {

using test::event;

const std::filesystem::path vendor_files = std::filesystem::path(test::data_folder) / "aedat4";
const Stream mini = event_stream_declaration({640, 480}, "DVXplorer_DXM00001");

Stream other_stream(std::int32_t id, StreamType type, const std::string& name) {
  Stream stream;
  stream.id = id;
  stream.type = type;
  stream.name = name;
  stream.source = "DVXplorer_DXM00001";
  if (type == StreamType::frames) stream.size = SensorSize{640, 480};
  return stream;
}

/// Events at random places and random, never falling times.
std::vector<Event> random_events(std::uint64_t seed, std::size_t count, std::int64_t begin, std::uint64_t most_gap_us) {
  Random random(seed);
  std::vector<Event> events;
  std::int64_t t = begin;
  for (std::size_t i = 0; i < count; ++i) {
    t += static_cast<std::int64_t>(random.below(most_gap_us + 1));
    events.push_back(
        event(t, static_cast<int>(random.below(640)), static_cast<int>(random.below(480)), static_cast<int>(random.below(2))));
  }
  return events;
}

class EveryCompression : public testing::TestWithParam<Compression> {};

TEST_P(EveryCompression, ReadsBackEqualByTableAndByScan) {
  const test::TemporaryFolder folder;
  RecordingReader original(vendor_files / "dv-none.aedat4");
  const auto expected = test::contents_of(original);
  const auto file = folder / "copy.aedat4";
  test::rewrite(original, file, {.compression = GetParam()});

  RecordingReader copy(file);
  EXPECT_EQ(copy.index(), PacketIndex::table) << copy.problems().table;
  EXPECT_EQ(copy.compression(), GetParam());
  EXPECT_TRUE(test::same(test::contents_of(copy), expected));

  std::string bytes = test::bytes_of(file);
  bytes.resize(test::layout_of(bytes).table_at);
  test::put(bytes, test::position_at, std::int64_t{-1});
  RecordingReader cut(test::write_bytes(folder / "cut.aedat4", bytes));
  EXPECT_EQ(cut.index(), PacketIndex::scan);
  EXPECT_TRUE(test::same(test::contents_of(cut), expected));
  ASSERT_EQ(cut.packets().size(), copy.packets().size());
  for (std::size_t i = 0; i < cut.packets().size(); ++i) {
    EXPECT_EQ(cut.packets()[i].elements, copy.packets()[i].elements);
    EXPECT_EQ(cut.packets()[i].first, copy.packets()[i].first);
    EXPECT_EQ(cut.packets()[i].last, copy.packets()[i].last);
  }
}

TEST_P(EveryCompression, StoresFramesThatTheVendorReads) {
  const test::TemporaryFolder folder;
  const auto file = folder / "frames.aedat4";
  const auto events = random_events(1, 20'000, 1'000, 0);  // 320 kB: five blocks of LZ4
  {
    RecordingWriter writer(file, {mini}, {.compression = GetParam(), .packet_events = 20'000});
    writer.write_events(0, events);
    writer.close();
  }
  const std::string bytes = test::bytes_of(file);
  const auto layout = test::layout_of(bytes);
  ASSERT_EQ(layout.packets.size(), 1U);
  const std::string stored = bytes.substr(layout.packets[0].at + 8, layout.packets[0].size);
  const std::string content = test::event_payload(events);
  switch (GetParam()) {
    case Compression::none:
      EXPECT_EQ(stored, content);
      break;
    case Compression::lz4:
      EXPECT_EQ(stored.substr(0, 7), std::string("\x04\x22\x4D\x18\x60\x40\x82")) << "64 KiB independent blocks, nothing else";
      break;
    case Compression::lz4_high:
      EXPECT_EQ(stored.substr(0, 7), std::string("\x04\x22\x4D\x18\x40\x40\xC0")) << "64 KiB linked blocks, nothing else";
      break;
    case Compression::zstd:
    case Compression::zstd_high:
      EXPECT_EQ(ZSTD_getFrameContentSize(stored.data(), stored.size()), content.size());
      EXPECT_EQ(stored == test::zstd(content), GetParam() == Compression::zstd);
      break;
  }
  EXPECT_EQ(test::contents_of(file).events, events);
}

INSTANTIATE_TEST_SUITE_P(All, EveryCompression,
                         testing::Values(Compression::none, Compression::lz4, Compression::lz4_high, Compression::zstd,
                                         Compression::zstd_high),
                         [](const testing::TestParamInfo<Compression>& kind) {
                           std::string name(name_of(kind.param));
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(CompressionNames, ReadBackAsThemselves) {
  for (int i = 0; i < 5; ++i) {
    const auto compression = static_cast<Compression>(i);
    EXPECT_EQ(compression_named(name_of(compression)), compression);
  }
  EXPECT_THROW(compression_named("LZ4"), Error);
  EXPECT_THROW(compression_named(""), Error);
}

// --- the header
// ------------------------------------------------------------------------------------------------------------------

TEST(RecordingHeader, IsWhatTheVendorsReaderDemands) {
  const test::TemporaryFolder folder;
  const auto file = folder / "a.aedat4";
  Stream camera = mini;
  camera.info = {
      {"tsOffset", "1605507430438338"}, {"biasSensitivity", "2"}, {"lens", "f/1.4 <wide>"}, {"empty", ""}, {"half", "0.5"}};
  RecordingWriter(file, {other_stream(2, StreamType::imu, "imu"), camera}, {.compression = Compression::zstd_high}).close();
  const std::string bytes = test::bytes_of(file);
  EXPECT_EQ(bytes.substr(0, 14), "#!AER-DAT4.0\r\n");
  const auto length = test::get<std::uint32_t>(bytes, 14);
  EXPECT_EQ(bytes.substr(14 + 8, 4), "IOHE");
  const std::string header = bytes.substr(14, 4 + length);
  EXPECT_EQ(header.size() % 4, 0U);
  const std::string xml = header.substr(header.find("<dv"), header.rfind('>') - header.find("<dv") + 2);
  EXPECT_EQ(xml, R"(<dv version="2.0">
    <node name="outInfo" path="/mainloop/Recorder/outInfo/">
        <node name="0" path="/mainloop/Recorder/outInfo/0/">
            <attr key="compression" type="string">ZSTD_HIGH</attr>
            <attr key="originalModuleName" type="string">tactile</attr>
            <attr key="originalOutputName" type="string">events</attr>
            <attr key="typeDescription" type="string">Array of events (polarity ON/OFF).</attr>
            <attr key="typeIdentifier" type="string">EVTS</attr>
            <node name="info" path="/mainloop/Recorder/outInfo/0/info/">
                <attr key="biasSensitivity" type="int">2</attr>
                <attr key="empty" type="string"></attr>
                <attr key="half" type="string">0.5</attr>
                <attr key="lens" type="string">f/1.4 &lt;wide&gt;</attr>
                <attr key="sizeX" type="int">640</attr>
                <attr key="sizeY" type="int">480</attr>
                <attr key="source" type="string">DVXplorer_DXM00001</attr>
                <attr key="tsOffset" type="long">1605507430438338</attr>
            </node>
        </node>
        <node name="2" path="/mainloop/Recorder/outInfo/2/">
            <attr key="compression" type="string">ZSTD_HIGH</attr>
            <attr key="originalModuleName" type="string">tactile</attr>
            <attr key="originalOutputName" type="string">imu</attr>
            <attr key="typeDescription" type="string">Inertial Measurement Unit data samples.</attr>
            <attr key="typeIdentifier" type="string">IMUS</attr>
            <node name="info" path="/mainloop/Recorder/outInfo/2/info/">
                <attr key="source" type="string">DVXplorer_DXM00001</attr>
            </node>
        </node>
    </node>
</dv>
)");

  // Byte for byte what the format's description makes by hand; the table's position is tested below.
  std::string by_hand = test::file_start(4, xml).substr(14);
  test::put(by_hand, 40, test::get<std::int64_t>(header, 40));
  EXPECT_EQ(header, by_hand);

  const auto info = RecordingReader(file).stream(0).info;
  EXPECT_EQ(std::set(info.begin(), info.end()), std::set(camera.info.begin(), camera.info.end()));
}

TEST(RecordingHeader, IsOnlyPatchedWhenTheRecordingIsClosed) {
  const test::TemporaryFolder folder;
  const auto file = folder / "a.aedat4";
  RecordingWriter writer(file, {mini});
  writer.write_events(0, random_events(3, 100, 0, 5));
  writer.flush();
  const std::string open = test::bytes_of(file);
  EXPECT_EQ(test::get<std::int64_t>(open, test::position_at), -1);
  writer.close();
  std::string closed = test::bytes_of(file);
  EXPECT_EQ(test::get<std::int64_t>(closed, test::position_at), static_cast<std::int64_t>(open.size()));
  test::put(closed, test::position_at, std::int64_t{-1});
  EXPECT_EQ(closed.substr(0, open.size()), open) << "nothing else moves";
}

TEST(RecordingHeader, RefusesStreamsThatOthersCouldNotRead) {
  const test::TemporaryFolder folder;
  const auto refused = [&](const std::vector<Stream>& streams) {
    EXPECT_THROW(RecordingWriter(folder / "a.aedat4", streams), Error);
    EXPECT_FALSE(std::filesystem::exists(folder / "a.aedat4"));
  };
  refused({});
  Stream bad = mini;
  bad.size.reset();
  refused({bad});
  bad.size = SensorSize{0, 480};
  refused({bad});
  bad.size = SensorSize{640, 40'000};
  refused({bad});
  bad = mini;
  bad.name.clear();
  refused({bad});
  bad = mini;
  bad.source.clear();
  refused({bad});
  bad = mini;
  bad.id = -1;
  refused({bad});
  bad = mini;
  bad.type_identifier = "IMUS";
  refused({bad});
  refused({mini, mini});
  refused({other_stream(3, StreamType::other, "boxes")});
}

TEST(RecordingHeader, RequiresANewFileOfTheRightName) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(RecordingWriter(folder / "a.aedat", {mini}), Error);
  EXPECT_THROW(RecordingWriter(folder / "aedat4", {mini}), Error);
  EXPECT_THROW(RecordingWriter(folder / "missing" / "a.aedat4", {mini}), Error);
  test::write_bytes(folder / "a.aedat4", "precious");
  EXPECT_THROW(RecordingWriter(folder / "a.aedat4", {mini}), Error);
  EXPECT_EQ(test::bytes_of(folder / "a.aedat4"), "precious");
  EXPECT_THROW(RecordingWriter(folder / "b.aedat4", {mini}, {.packet_span = 0us}), Error);
  EXPECT_THROW(RecordingWriter(folder / "b.aedat4", {mini}, {.packet_events = 0}), Error);
  EXPECT_THROW(RecordingWriter(folder / "b.aedat4", {mini}, {.packet_events = std::size_t{1} << 40}), Error);
  EXPECT_FALSE(std::filesystem::exists(folder / "b.aedat4"));
}

// --- packets
// -----------------------------------------------------------------------------------------------------------------------

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
    for (std::size_t i = 0; i < 31 * 17 * bytes; ++i) frame.pixels.push_back(static_cast<std::uint8_t>(i * 7 + 1));
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

TEST(RecordingWriterState, ClosesWhenItGoesAndWhenItIsReplaced) {
  const test::TemporaryFolder folder;
  const auto events = random_events(10, 100, 0, 5);
  {
    RecordingWriter writer(folder / "a.aedat4", {mini});
    writer.write_events(0, events);
    RecordingWriter moved = std::move(writer);
    moved.write_events(0, std::vector<Event>{events.back()});
    moved = RecordingWriter(folder / "b.aedat4", {mini});
    EXPECT_EQ(RecordingReader(folder / "a.aedat4").index(), PacketIndex::table);
    moved.write_events(0, events);
  }
  EXPECT_EQ(test::contents_of(folder / "a.aedat4").events.size(), 101U);
  EXPECT_EQ(RecordingReader(folder / "b.aedat4").index(), PacketIndex::table);
  EXPECT_EQ(test::contents_of(folder / "b.aedat4").events, events);
}

// --- killed
// --------------------------------------------------------------------------------------------------------------------------

/// The event that a writing process makes as its i-th.
Event numbered_event(std::int64_t i) {
  return event(1'700'000'000'000'000 + i / 3, static_cast<int>(i * 7 % 640), static_cast<int>(i * 11 % 480),
               static_cast<int>(i % 2));
}

TEST(KilledRecording, HoldsEveryFlushedPacketAndAnExactPrefix) {
  const test::TemporaryFolder folder;
  Random random(11);
  std::int64_t most = 0;
  for (int moment = 0; moment < 20; ++moment) {
    const auto file = folder / ("killed" + std::to_string(moment) + ".aedat4");
    const auto compression = static_cast<Compression>(moment % 4);
    void* shared = ::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    ASSERT_NE(shared, MAP_FAILED);
    auto* flushed = new (shared) std::atomic<std::int64_t>(-1);  // -1: the file is not begun
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      try {
        RecordingWriter writer(file, {mini}, {.compression = compression, .packet_events = 500});
        flushed->store(0);
        std::vector<Event> events(300);
        for (std::int64_t next = 0;;) {
          for (Event& e : events) e = numbered_event(next++);
          writer.write_events(0, events);
          if (next % 9'000 == 0) {
            writer.flush();
            flushed->store(next);
          }
        }
      } catch (...) {
      }
      ::_exit(1);
    }
    const auto kept = static_cast<std::int64_t>(9'000 * random.below(4));
    const bool has_kept = test::comes_true([&] { return flushed->load() >= kept; });
    std::this_thread::sleep_for(microseconds{random.below(10'000)});
    ::kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status)) << "it was to end by the kill alone";
    ASSERT_TRUE(has_kept) << kept;

    RecordingReader recording(file);
    EXPECT_EQ(recording.index(), PacketIndex::scan);
    EXPECT_EQ(recording.problems().broken_packets + recording.problems().undeclared_packets + recording.problems().empty_packets,
              0U);
    std::int64_t read = 0;
    for_all_events(recording, 0, [&](std::span<const Event> events) {
      for (const Event& e : events) ASSERT_EQ(e, numbered_event(read++));
    });
    EXPECT_GE(read, flushed->load());
    most = std::max(most, read);
    ::munmap(shared, 4096);
  }
  EXPECT_GT(most, 9'000) << "no kill came late enough for a test";
}

TEST(KilledRecording, OnAFullDiskGivesBackTheRoomOfAPartOfAPacket) {
  const test::TemporaryFolder folder;
  const auto file = folder / "full.aedat4";
  rlimit limit{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &limit), 0);
  const auto old_action = ::signal(SIGXFSZ, SIG_IGN);
  std::uintmax_t whole = 0;
  {
    RecordingWriter writer(file, {mini}, {.compression = Compression::none});
    std::vector<Event> events(1000);
    for (std::int64_t i = 0; i < 1000; ++i) events[static_cast<std::size_t>(i)] = numbered_event(i);
    writer.write_events(0, events);
    writer.flush();
    whole = std::filesystem::file_size(file);
    writer.write_events(0, std::array{numbered_event(1000)});
    // Room for a part of the next packet, and none for a table.
    const rlimit little{.rlim_cur = whole + 10, .rlim_max = limit.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &little), 0);
    EXPECT_THROW(writer.close(), Error);
    ::setrlimit(RLIMIT_FSIZE, &limit);
    EXPECT_EQ(writer.written().front().elements, 1000U) << "what waited is not in the file";
  }
  ::signal(SIGXFSZ, old_action);
  EXPECT_EQ(std::filesystem::file_size(file), whole);
  RecordingReader recording(file);
  EXPECT_EQ(recording.index(), PacketIndex::scan);
  std::int64_t read = 0;
  for_all_events(recording, 0, [&](std::span<const Event> events) { read += static_cast<std::int64_t>(events.size()); });
  EXPECT_EQ(read, 1000);
}

TEST(KilledRecording, OnAFullDiskReportsItAndKeepsItsWholePackets) {
  const test::TemporaryFolder folder;
  const auto file = folder / "full.aedat4";
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);  // writing beyond the limit then fails as it does on a full disk
    rlimit limit{};
    ::getrlimit(RLIMIT_FSIZE, &limit);
    const rlimit little{.rlim_cur = 100'000, .rlim_max = limit.rlim_max};
    int outcome = 1;
    try {
      RecordingWriter writer(file, {mini}, {.compression = Compression::none, .packet_events = 500});
      ::setrlimit(RLIMIT_FSIZE, &little);
      std::vector<Event> events(300);
      try {
        for (std::int64_t next = 0; next < 300'000;) {
          for (Event& e : events) e = numbered_event(next++);
          writer.write_events(0, events);
        }
      } catch (const Error&) {
        outcome = 2;
        ::setrlimit(RLIMIT_FSIZE, &limit);
        writer.close();  // there is room again
        outcome = 0;
      }
    } catch (...) {
    }
    ::_exit(outcome);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  RecordingReader recording(file);
  EXPECT_EQ(recording.index(), PacketIndex::table) << recording.problems().table;
  std::int64_t read = 0;
  for_all_events(recording, 0, [&](std::span<const Event> events) {
    for (const Event& e : events) ASSERT_EQ(e, numbered_event(read++));
  });
  EXPECT_GE(read, 5'500);
}

}  // namespace
}  // namespace tactile::events
