#include "tactile/events/recording_writer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "events/aedat4_bytes.hpp"
#include "events/made_streams.hpp"
#include "events/recording_contents.hpp"
#include "events/rewrite.hpp"
#include "support/file_size_limit.hpp"
#include "support/paths.hpp"
#include "support/temporary_folder.hpp"
#include "support/vendor_files.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"

namespace tactile::events {
namespace {

using test::mini;
using test::other_stream;
using test::random_events;
using test::vendor_files;

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

TEST_P(EveryCompression, HasTheSameBytesWithAnyNumberOfThreads) {
  const test::TemporaryFolder folder;
  RecordingReader original(vendor_files / "dv-none.aedat4");
  const auto bytes_with = [&](unsigned threads) {
    const auto file = folder / ("with" + std::to_string(threads) + ".aedat4");
    test::rewrite(original, file, {.compression = GetParam(), .packet_events = 100, .threads = threads});
    return test::bytes_of(file);
  };
  const std::string bytes = bytes_with(1);
  EXPECT_GT(test::contents_of(folder / "with1.aedat4").events.size(), 40 * 100U);  // more packets than wait for each other
  for (const unsigned threads : {2U, 5U}) EXPECT_EQ(bytes_with(threads) == bytes, true) << threads << " threads";
}

TEST_P(EveryCompression, AFullDiskLeavesWholePacketsWithAnyNumberOfThreads) {
  const test::TemporaryFolder folder;
  const auto events = random_events(4, 60'000, 1'000, 0);
  for (const unsigned threads : {1U, 3U}) {
    const auto file = folder / ("full" + std::to_string(threads) + ".aedat4");
    RecordingWriter writer(file, {mini}, {.compression = GetParam(), .packet_events = 500, .threads = threads});
    {
      const test::FileSizeLimit little(100'000);
      EXPECT_THROW(
          {
            for (std::size_t i = 0; i < events.size(); i += 1000) writer.write_events(0, std::span(events).subspan(i, 1000));
            writer.flush();
          },
          Error);
      EXPECT_THROW(writer.close(), Error);
    }
    const auto kept = test::contents_of(file).events;
    EXPECT_GT(kept.size(), 500U) << threads;
    EXPECT_EQ(kept.size() % 500, 0U) << threads;
    EXPECT_TRUE(std::equal(kept.begin(), kept.end(), events.begin())) << threads << " threads: not the first events";
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

TEST(RecordingWriterState, MayGoWhileOtherThreadsWrite) {
  const test::TemporaryFolder folder;
  const auto events = random_events(10, 40'000, 0, 5);
  const RecordingWriterOptions options{.compression = Compression::zstd, .packet_events = 50, .threads = 3};
  {
    RecordingWriter writer(folder / "a.aedat4", {mini}, options);
    writer.write_events(0, events);
    EXPECT_LE(writer.written()[0].elements, events.size());
    RecordingWriter moved = std::move(writer);
    moved.write_events(0, std::vector<Event>{events.back()});
    moved = RecordingWriter(folder / "b.aedat4", {mini}, options);
    EXPECT_EQ(RecordingReader(folder / "a.aedat4").index(), PacketIndex::table);
    moved.write_events(0, events);
  }
  EXPECT_EQ(test::contents_of(folder / "a.aedat4").events.size(), 40'001U);
  EXPECT_EQ(test::contents_of(folder / "b.aedat4").events, events);
}

TEST(RecordingWriterState, WritesTheRestWhereTheDiskHasRoomAgain) {
  const test::TemporaryFolder folder;
  const auto events = random_events(4, 60'000, 1'000, 0);
  for (const unsigned threads : {1U, 3U}) {
    const auto file = folder / ("again" + std::to_string(threads) + ".aedat4");
    RecordingWriter writer(file, {mini}, {.compression = Compression::lz4, .packet_events = 100, .threads = threads});
    std::size_t given = 0;
    const auto write_until_refused = [&] {
      for (; given < events.size(); given += 500) writer.write_events(0, std::span(events).subspan(given, 500));
    };
    {
      const test::FileSizeLimit little(100'000);
      EXPECT_THROW(write_until_refused(), Error);
    }
    try {
      writer.close();
    } catch (const Error&) {
      // The error of a packet that another thread wrote in the meantime.
    }
    const auto kept = test::contents_of(file).events;
    EXPECT_GE(kept.size(), given) << threads;  // the refused call's events may be there too
    EXPECT_TRUE(std::equal(kept.begin(), kept.end(), events.begin())) << threads;
  }
}

}  // namespace
}  // namespace tactile::events
