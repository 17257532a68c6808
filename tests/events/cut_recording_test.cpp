#include "tactile/events/cut_recording.hpp"

#include <gtest/gtest.h>

#include "events/made_recording.hpp"
#include "events/recording_contents.hpp"
#include "support/error_of.hpp"
#include "support/paths.hpp"
#include "support/real_recordings.hpp"
#include "support/temporary_folder.hpp"
#include "support/vendor_files.hpp"

namespace tactile::events {
namespace {

using test::stored_bytes;

namespace fs = std::filesystem;
constexpr SensorSize small{64, 48};

class CutRecording : public testing::Test {
 protected:
  /// Cuts `in` and returns what was written.
  std::vector<WrittenPiece> cut(const std::vector<std::int64_t>& cuts_us) {
    std::vector<CameraTime> cuts;
    cuts.reserve(cuts_us.size());
    for (const std::int64_t us : cuts_us) cuts.push_back(camera_time(us));
    pieces.clear();
    for (std::size_t i = 0; i <= cuts.size(); ++i) {
      pieces.push_back(folder / ("piece-" + std::to_string(i) + ".aedat4"));
      fs::remove(pieces.back());
    }
    RecordingReader recording(in);
    return cut_recording(recording, recording.streams(), cuts, pieces);
  }

  /// The contents of all pieces, one after the other.
  test::RecordingContents joined() const {
    test::RecordingContents all;
    for (const fs::path& piece : pieces) {
      const test::RecordingContents part = test::contents_of(piece);
      const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
      append(all.events, part.events);
      append(all.imu, part.imu);
      append(all.triggers, part.triggers);
      append(all.frames, part.frames);
    }
    return all;
  }

  test::TemporaryFolder folder;
  fs::path in = folder / "in.aedat4";
  std::vector<fs::path> pieces;
};

TEST_F(CutRecording, GivesEachPieceTheEventsFromItsCutOnUntilTheNext) {
  test::write_plain_recording(in, test::steady_events(1'000, 0, 10, small), small);
  const auto written = cut({2'500, 2'505, 9'990});
  EXPECT_EQ(written[0].streams.front().elements, 250U);
  EXPECT_EQ(written[1].streams.front().elements, 1U);  // the event at 2500
  EXPECT_EQ(written[2].streams.front().elements, 748U);
  EXPECT_EQ(written[3].streams.front().elements, 1U);  // an event at the cut belongs to the later piece
  EXPECT_EQ(written[3].streams.front().first, camera_time(9'990));
  EXPECT_TRUE(same(joined(), test::contents_of(in)));
}

TEST_F(CutRecording, CopiesThePacketsThatLieInOnePieceBitForBit) {
  // Packets of 10 ms, cut once at a packet's start and once inside.
  test::write_plain_recording(in, test::steady_events(5'000, 0, 10, small), small);
  const auto before = test::packets_of(in);
  ASSERT_EQ(before.size(), 5U);
  const auto written = cut({20'000, 34'000});
  EXPECT_EQ(written[0].packets_copied, 2U);
  EXPECT_EQ(written[0].packets_encoded, 0U);
  EXPECT_EQ(written[1].packets_copied, 1U);
  EXPECT_EQ(written[1].packets_encoded, 1U);
  EXPECT_EQ(written[2].packets_copied, 1U);
  const auto first = test::packets_of(pieces[0]), last = test::packets_of(pieces[2]);
  EXPECT_EQ(stored_bytes(pieces[0], first[0]), stored_bytes(in, before[0]));
  EXPECT_EQ(stored_bytes(pieces[0], first[1]), stored_bytes(in, before[1]));
  EXPECT_EQ(stored_bytes(pieces[2], last[1]), stored_bytes(in, before[4]));
}

TEST_F(CutRecording, KeepsAllStreamsOfTheVendorsFilesWhateverTheirCompression) {
  for (const char* name : {"dv-none.aedat4", "dv-lz4.aedat4", "dv-lz4-high.aedat4", "dv-zstd.aedat4", "dv-zstd-high.aedat4"}) {
    in = test::vendor_files / name;
    const test::RecordingContents whole = test::contents_of(in);
    ASSERT_FALSE(whole.imu.empty());
    ASSERT_FALSE(whole.frames.empty());
    const std::int64_t begin = us_of(whole.events.front().t), end = us_of(whole.events.back().t);
    cut({begin + (end - begin) / 3, begin + (end - begin) / 2});
    EXPECT_TRUE(same(joined(), whole)) << name;
    for (const fs::path& piece : pieces) {
      const RecordingReader recording(piece);
      EXPECT_EQ(recording.index(), PacketIndex::table) << name;
      EXPECT_EQ(recording.compression(), RecordingReader(in).compression()) << name;
      EXPECT_EQ(recording.streams().size(), RecordingReader(in).streams().size()) << name;
    }
  }
}

TEST_F(CutRecording, SortsEventsThatStepBackAcrossACutByTheirTime) {
  std::vector<Event> events = test::steady_events(300, 0, 100, small);
  test::write_plain_recording(in, events, small);
  const auto packets = test::packets_of(in);
  test::overwrite(in, test::event_offset(packets[2], 0), std::int64_t{5'000});  // the first event after 20 ms
  const auto written = cut({10'000});
  EXPECT_EQ(written[0].streams.front().elements, 101U);
  EXPECT_EQ(written[1].streams.front().elements, 199U);
}

TEST_F(CutRecording, PutsPacketsOfUnknownTypesIntoThePieceOfThePacketBeforeThem) {
  {
    RecordingWriter writer(
        in, {event_stream_declaration(small, "DVXplorer_A"), test::stream_of(7, StreamType::triggers, "TRIG", "DVXplorer_A")},
        {.compression = Compression::none});
    for (const std::int64_t t : {0, 20'000}) {
      writer.write_events(0, test::steady_events(10, t, 1, small));
      writer.flush();
      writer.write_triggers(7, std::vector<Trigger>{{.t = camera_time(t), .type = 1}});
      writer.flush();
    }
    writer.close();
  }
  std::string bytes = read_text(in);
  for (std::size_t at = bytes.find("TRIG"); at != std::string::npos; at = bytes.find("TRIG", at)) bytes.replace(at, 4, "BBOX");
  write_whole(in, bytes);
  cut({10'000});
  for (const fs::path& piece : pieces) {
    const auto packets = test::packets_of(piece);
    ASSERT_EQ(packets.size(), 2U);
    EXPECT_EQ(packets[1].stream_id, 7);
  }
}

TEST_F(CutRecording, CountsTheEventsOfPiecesFromTheListOfPackets) {
  const std::vector<Event> events = test::steady_events(20'000, 0, 7, small);
  test::write_plain_recording(in, events, small);
  const std::vector<CameraTime> cuts{camera_time(1), camera_time(33'333), camera_time(70'000)};
  RecordingReader recording(in);
  std::vector<std::uint64_t> expected(4);
  for (const Event& event : events) ++expected[piece_of(cuts, event.t)];
  EXPECT_EQ(events_of_pieces(recording, 0, cuts), expected);
}

TEST_F(CutRecording, TakesNoRawFile) {
  in = test::real_recording("expelliarmus/evt2_sample.raw");
  if (in.empty()) GTEST_SKIP() << test::not_tested_without("expelliarmus/evt2_sample.raw");
  EXPECT_NE(test::error_of([&] { cut({10}); }).find("expected AEDAT4"), std::string::npos);
}

}  // namespace
}  // namespace tactile::events
