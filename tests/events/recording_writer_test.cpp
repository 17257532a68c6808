#include "tactile/events/recording_writer.hpp"

#include <gtest/gtest.h>

#include "events/recording_contents.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"

namespace tactile {
namespace {

const std::filesystem::path vendor_files = std::filesystem::path(TACTILE_TEST_DATA) / "aedat4";

void rewrite(RecordingReader& recording, RecordingWriter& writer) {
  for (const PacketRecord& packet : recording.packets()) {
    switch (recording.stream(packet.stream_id).type) {
      case StreamType::events:
        writer.write_events(packet.stream_id, recording.read_events(packet));
        break;
      case StreamType::imu:
        writer.write_imu(packet.stream_id, recording.read_imu(packet));
        break;
      case StreamType::triggers:
        writer.write_triggers(packet.stream_id, recording.read_triggers(packet));
        break;
      case StreamType::frames:
        if (const auto frame = recording.read_frame(packet)) writer.write_frame(packet.stream_id, *frame);
        break;
      case StreamType::other:
        break;
    }
  }
}

class EveryCompression : public testing::TestWithParam<Compression> {};

TEST_P(EveryCompression, ReadsBackEqual) {
  const test::TemporaryFolder folder;
  RecordingReader original(vendor_files / "dv-none.aedat4");
  const std::vector<Stream> streams(original.streams().begin(), original.streams().end());
  const auto file = folder / "copy.aedat4";
  RecordingWriter writer(file, streams, {.compression = GetParam()});
  rewrite(original, writer);
  writer.close();

  RecordingReader copy(file);
  EXPECT_EQ(copy.index(), PacketIndex::table) << copy.problems().table;
  EXPECT_EQ(copy.compression(), GetParam());
  EXPECT_TRUE(test::same(test::contents_of(copy), test::contents_of(original)));
}

INSTANTIATE_TEST_SUITE_P(All, EveryCompression,
                         testing::Values(Compression::none, Compression::lz4, Compression::lz4_high, Compression::zstd,
                                         Compression::zstd_high),
                         [](const testing::TestParamInfo<Compression>& kind) {
                           std::string name(name_of(kind.param));
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace tactile
