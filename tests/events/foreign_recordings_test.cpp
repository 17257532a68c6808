// Recordings of other writers, other files, and those of several cameras; what is read of one.
#include <gtest/gtest.h>

#include "events/aedat4_bytes.hpp"
#include "events/damaged_recording.hpp"
#include "events/recording_contents.hpp"
#include "tactile/core/error.hpp"
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
using test::vendor_bytes;
using test::with_table;
using test::xml_of;

// --- other writers, other files
// --------------------------------------------------------------------------------------------------------

TEST_F(DamagedRecording, WithoutADeclaredStreamIsRefused) {
  // As aestream writes it: outInfo empty, no identifiers, a table of one entry at byte 0.
  const std::string start = file_start(
      0, "<dv version=\"4.0\">\n    <node name=\"outInfo\" path=\"/mainloop/Recorder/outInfo/\">\n    </node>\n</dv>\n",
      std::string(4, '\0'));
  std::string payload = event_payload(row_of_events(0, 4));
  payload.replace(8, 4, std::string(4, '\0'));
  std::string table = test::table_of({{.offset = 0, .id = 0, .size = 4, .elements = 4, .first = 0, .last = 3}});
  table.replace(8, 4, std::string(4, '\0'));
  EXPECT_SAYS(error_of(with_table(start + packet(0, payload), table)), "declares no stream; expected");
  EXPECT_SAYS(error_of(file_start(0, "<dv version=\"2.0\"></dv>")), "declares no stream");
  EXPECT_SAYS(error_of(file_start(0, "")), "declares no stream");
  EXPECT_SAYS(error_of(file_start(0, "<dv")), "does not parse");
}

TEST_F(DamagedRecording, WithABadHeaderIsRefused) {
  EXPECT_SAYS(error_of(file_start(0, one_camera, "ABCD")), "IOHE");
  EXPECT_SAYS(error_of(file_start(5, one_camera)), "compression 5");
  EXPECT_SAYS(error_of(file_start(-1, one_camera)), "compression -1");
  std::string bytes = file_start(0, one_camera);
  put(bytes, 14 + 48, std::uint32_t{0x7fffffff});
  EXPECT_SAYS(error_of(bytes), "does not decode");
  bytes = file_start(0, one_camera) + std::string(std::size_t{20} << 20, '\0');
  put(bytes, 14, std::uint32_t{18 << 20});
  EXPECT_SAYS(error_of(bytes), "claims a header of");
}

TEST_F(DamagedRecording, MayLackTheOutputsNameAndTheTable) {
  // As faery writes it.
  const auto events = row_of_events(100, 50);
  const std::string node =
      "<node name=\"0\" path=\"/mainloop/Recorder/outInfo/0/\"><attr key=\"typeIdentifier\" type=\"string\">EVTS</attr>"
      "<node name=\"info\"><attr key=\"sizeX\" type=\"int\">640</attr><attr key=\"sizeY\" type=\"int\">480</attr></node></node>";
  RecordingReader recording = reader_of(file_start(3, xml_of(node)) + packet(0, test::zstd_without_size(event_payload(events))));
  EXPECT_EQ(recording.stream(0).name, "");
  EXPECT_EQ(recording.stream(0).source, "");
  EXPECT_EQ(recording.problems().table, "");
  EXPECT_EQ(test::contents_of(recording).events, events);
}

TEST_F(DamagedRecording, AcceptsEveryFormOfInfoThatIsKnown) {
  const std::string xml =
      "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"no\"?>\n<dv version=\"7.3\"><node name=\"somethingElse\"><attr "
      "key=\"a\" "
      "type=\"int\">1</attr></node><node name=\"outInfo\"><attr key=\"b\" type=\"string\">c</attr>" +
      test::plain_node(9, "BBOX") + "<node name=\"extra\"><attr key=\"typeIdentifier\" type=\"string\">EVTS</attr></node>" +
      "<node name=\"12\"></node>" + event_node(3, 640, 480, "DVXplorer_DXM00001") + "</node></dv>";
  std::string box = event_payload({});
  box.replace(8, 4, "BBOX");
  const auto events = row_of_events(5, 3);
  RecordingReader recording = reader_of(file_start(0, xml) + packet(9, box) + packet(3, event_payload(events)));
  ASSERT_EQ(recording.streams().size(), 2U);
  EXPECT_EQ(recording.streams()[0].type, StreamType::other);
  EXPECT_EQ(recording.streams()[0].type_identifier, "BBOX");
  EXPECT_EQ(event_stream(recording).id, 3);
  EXPECT_EQ(recording.packets().size(), 2U);
  EXPECT_EQ(recording.problems().undeclared_packets, 0U);
  EXPECT_EQ(recording.problems().mismatched_packets, 0U);
  EXPECT_EQ(test::contents_of(recording).events, events);
}

TEST_F(DamagedRecording, KeepsFurtherAttributesOfAStream) {
  std::string node = event_node(0, 640, 480, "A");
  node.insert(node.find("<attr key=\"source\""), "<attr key=\"tsOffset\" type=\"long\">1605507430438338</attr>");
  RecordingReader recording = reader_of(file_start(0, xml_of(node)));
  const std::vector<std::pair<std::string, std::string>> expected{{"tsOffset", "1605507430438338"}};
  EXPECT_EQ(recording.stream(0).info, expected);
}

TEST_F(DamagedRecording, NamesWhatAForeignFileIs) {
  EXPECT_SAYS(error_of("version https://git-lfs.github.com/spec/v1\noid sha256:140e\nsize 1191471\n"), "Git LFS pointer");
  EXPECT_SAYS(error_of("#!AER-DAT1.0\r\nxxxxxxxxxxxxxxxx"), "version '1.0'");
  EXPECT_SAYS(error_of("#!AER-DAT2.0\r\n# a comment\r\n"), "version '2.0'");
  EXPECT_SAYS(error_of("#!AER-DAT3.1\r\n#Format: RAW\r\n"), "version '3.1'");
  EXPECT_SAYS(error_of(std::string("\x89HDF\r\n\x1a\n", 8) + std::string(500, 'x')), "expected the line #!AER-DAT4.0");
  for (const std::string& bag :
       {std::string("#ROSBAG V2.0\n"), std::string("SQLite format 3\0", 16), std::string("\x89MCAP0\r\n")})
    EXPECT_SAYS(error_of(bag + std::string(500, 'x')),
                "is a ROS bag, not a recording; expected what 'tactile convert' makes of it");
  EXPECT_THROW(RecordingReader(folder_ / "nowhere.aedat4"), Error);
  EXPECT_THROW(RecordingReader(folder_.path()), Error);
}

// --- several cameras
// -------------------------------------------------------------------------------------------------------------------

TEST_F(DamagedRecording, OfTwoCamerasRequiresAChoice) {
  const auto left = row_of_events(100, 5);
  const auto right = row_of_events(101, 7);
  const std::string xml =
      xml_of(event_node(0, 640, 480, "DVXplorer_L") + event_node(4, 640, 480, "DVXplorer_R") + test::plain_node(2, "IMUS"));
  RecordingReader recording = reader_of(file_start(0, xml) + packet(4, event_payload(right)) + packet(0, event_payload(left)));
  try {
    event_stream(recording);
    FAIL() << "two event streams must not be taken for one";
  } catch (const Error& e) {
    EXPECT_SAYS(e.what(), "0 (DVXplorer_L), 4 (DVXplorer_R)");
  }
  EXPECT_EQ(event_stream(recording, "0").id, 0);
  EXPECT_EQ(event_stream(recording, "4").id, 4);
  EXPECT_EQ(event_stream(recording, "DVXplorer_L").id, 0);
  EXPECT_EQ(event_stream(recording, "DVXplorer_R").id, 4);
  EXPECT_THROW(event_stream(recording, "2"), Error) << "an IMU's";
  EXPECT_THROW(event_stream(recording, "DVXplorer"), Error);
  EXPECT_THROW(recording.stream(1), Error);
  std::size_t found = 0;
  for_all_events(recording, 4, [&](auto events) { found += events.size(); });
  EXPECT_EQ(found, 7U);
  EXPECT_THROW(recording.read_imu(recording.packets()[0]), Error);
  PacketRecord elsewhere = recording.packets()[0];
  elsewhere.payload_offset += 1;
  EXPECT_THROW(recording.read_events(elsewhere), Error);
}

TEST_F(DamagedRecording, OfTwoStreamsWithOneSourceRequiresTheId) {
  const std::string xml = xml_of(event_node(0, 640, 480, "DVXplorer_L") + event_node(1, 640, 480, "DVXplorer_L"));
  RecordingReader recording = reader_of(file_start(0, xml));
  EXPECT_THROW(event_stream(recording, "DVXplorer_L"), Error);
  EXPECT_EQ(event_stream(recording, "1").id, 1);
}

TEST_F(DamagedRecording, WithoutEventsReportsIt) {
  RecordingReader recording = reader_of(file_start(0, xml_of(test::plain_node(2, "IMUS"))));
  try {
    event_stream(recording);
    FAIL();
  } catch (const Error& e) {
    EXPECT_SAYS(e.what(), "no event stream; expected an EVTS stream");
  }
}

// --- only what is needed
// -----------------------------------------------------------------------------------------------------------------

TEST_F(DamagedRecording, IsReadOnlyWhereTheTimesOverlap) {
  std::string bytes = vendor_bytes("dv-lz4");
  RecordingReader sound = reader_of(bytes);
  // Break every packet but the fifth event packet: whoever reads one more, notices.
  const PacketRecord chosen = sound.packets()[4];
  ASSERT_EQ(chosen.stream_id, 0);
  for (const PacketRecord& other : sound.packets()) {
    if (other.payload_offset != chosen.payload_offset) bytes.replace(other.payload_offset, 16, 16, 'x');
  }
  RecordingReader recording = reader_of(bytes);
  ASSERT_EQ(recording.index(), PacketIndex::table) << recording.problems().table;
  std::vector<Event> read;
  const CameraTime begin = sound.packets()[3].last + 1us;
  const CameraTime end = sound.packets()[5].first;
  for_events_between(recording, 0, begin, end, [&](auto events) { read.insert(read.end(), events.begin(), events.end()); });
  EXPECT_EQ(recording.problems().broken_packets, 0U);
  const auto expected = sound.read_events(chosen);
  std::vector<Event> inside;
  std::copy_if(expected.begin(), expected.end(), std::back_inserter(inside),
               [&](const Event& e) { return e.t >= begin && e.t < end; });
  EXPECT_FALSE(inside.empty());
  EXPECT_EQ(read, inside);
  for_all_events(recording, 0, [](auto) {});
  EXPECT_EQ(recording.problems().broken_packets, 8U) << "the others are broken indeed";
  for_all_events(recording, 0, [](auto) {});
  EXPECT_EQ(recording.problems().broken_packets, 8U) << "and are counted once";
}

TEST_F(DamagedRecording, CutByTimeKeepsTheStartAndLeavesTheEnd) {
  RecordingReader recording = reader_of(vendor_bytes("dv-zstd"));
  const auto all = test::contents_of(recording).events;
  const CameraTime begin = all[1000].t;
  const CameraTime end = all[4000].t;
  std::vector<Event> read;
  for_events_between(recording, 0, begin, end, [&](auto events) { read.insert(read.end(), events.begin(), events.end()); });
  std::vector<Event> expected;
  std::copy_if(all.begin(), all.end(), std::back_inserter(expected), [&](const Event& e) { return e.t >= begin && e.t < end; });
  EXPECT_EQ(read, expected);
  for_events_between(recording, 0, begin, begin, [](auto) { FAIL() << "an empty span holds nothing"; });
}

}  // namespace
}  // namespace tactile::events
