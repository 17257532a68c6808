// Two public recordings of real cameras, which are not part of this project.
#include "support/real_recordings.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "events/aedat4_bytes.hpp"
#include "events/recording_contents.hpp"
#include "events/rewrite.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::events {
namespace {

/// What is known of a recording from a reading that owes nothing to this code.
struct Known {
  const char* file;
  std::uint64_t bytes;
  const char* sha256;
  std::size_t data_begin, table_at;
  const char* source;
  SensorSize size;
  const char* ts_offset;
  std::vector<std::pair<std::int32_t, StreamType>> streams;
  std::vector<std::size_t> packets_by_type;  ///< events, frames, imu, triggers
  std::vector<std::int64_t> first_packets;   ///< events in each of the first five
  std::int64_t last_packet, fewest, median, most;
  std::size_t events;
  std::int64_t on, first_us, last_us;
  Event first, last;
  std::int64_t sum_x, sum_y;
  std::size_t distinct_times;
  SensorSize largest;  ///< largest x and y seen
  const char* digest;
  std::size_t imu;
  std::int64_t imu_first_us, imu_last_us;
  std::vector<double> imu_first;  ///< temperature, acceleration, angular rate, to four decimals
  std::vector<std::int64_t> frames_us;
  const char* frames_sha256;
  std::vector<std::size_t> triggers_by_type;
  std::int64_t trigger_first_us, trigger_last_us;
  int trigger_first_type, trigger_last_type;
};

const Known tonic{
    .file = "tonic-sample.aedat4",
    .bytes = 949253,
    .sha256 = "b42f119af2548d4328e6c0f249e369a4b755d82eeb6ddceb14441492d979444c",
    .data_begin = 2334,
    .table_at = 945243,
    .source = "DVXplorer_DXB00010",
    .size = {320, 240},
    .ts_offset = "1605507430438338",
    .streams = {{0, StreamType::events}, {2, StreamType::imu}, {3, StreamType::triggers}},
    .packets_by_type = {59, 0, 59, 0},
    .first_packets = {918, 944, 1060, 1126, 1210},
    .last_packet = 2001,
    .fewest = 918,
    .median = 1877,
    .most = 3018,
    .events = 111954,
    .on = 55023,
    .first_us = 1605537493718345,
    .last_us = 1605537494308262,
    .first = test::event(1605537493718345, 154, 204, 0),
    .last = test::event(1605537494308262, 88, 237, 1),
    .sum_x = 18342405,
    .sum_y = 15105898,
    .distinct_times = 87721,
    .largest = {319, 239},
    .digest = "8e8467d9ac3912a53647b8500d294e4beb233b54fa2345d08a9be133a44155b2",
    .imu = 475,
    .imu_first_us = 1605537493718788,
    .imu_last_us = 1605537494307448,
    .imu_first = {38.1523, 0.1263, -0.9951, -0.3931, 0.4120, 0.0763, -0.4120},
    .frames_us = {},
    .frames_sha256 = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855",  // of nothing
    .triggers_by_type = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    .trigger_first_us = 0,
    .trigger_last_us = 0,
    .trigger_first_type = 0,
    .trigger_last_type = 0,
};

const Known aestream{
    .file = "aestream-sample.aedat4",
    .bytes = 1191471,
    .sha256 = "140ed9a82548ec3c3e66baf5948adb8c0f2e22fac6d22344685b0dc26a2584f0",
    .data_begin = 3126,
    .table_at = 1190063,
    .source = "DAVIS346_00000104",
    .size = {346, 260},
    .ts_offset = "1633953629213182",
    .streams = {{0, StreamType::events}, {1, StreamType::frames}, {2, StreamType::imu}, {3, StreamType::triggers}},
    .packets_by_type = {13, 3, 13, 11},
    .first_packets = {9920, 11020, 10306, 9394, 8466},
    .last_packet = 10099,
    .fewest = 7402,
    .median = 8806,
    .most = 11020,
    .events = 117667,
    .on = 72363,
    .first_us = 1633953690975950,
    .last_us = 1633953691105949,
    .first = test::event(1633953690975950, 218, 15, 1),
    .last = test::event(1633953691105949, 137, 56, 0),
    .sum_x = 17676033,
    .sum_y = 10498046,
    .distinct_times = 67132,
    .largest = {345, 259},
    .digest = "b76c70c59d56fab241605ae21b64c4df0736accb70c1cc9ad151f646a812c06a",
    .imu = 130,
    .imu_first_us = 1633953690976628,
    .imu_last_us = 1633953691105605,
    .imu_first = {27.7529, -0.0604, -0.9912, -0.0974, 6.4545, 2.5787, -0.1678},
    .frames_us = {1633953690978904, 1633953691018904, 1633953691058904},
    .frames_sha256 = "d993d5b6451d0e8eb05c697a332104a9c22b0752cbd2ca13af7503e6939b8e99",
    .triggers_by_type = {0, 0, 0, 0, 0, 0, 3, 4, 4, 4},
    .trigger_first_us = 1633953690976518,
    .trigger_last_us = 1633953691110744,
    .trigger_first_type = 8,
    .trigger_last_type = 7,
};

class RealRecording : public testing::TestWithParam<const Known*> {
 protected:
  void SetUp() override {
    file_ = test::real_recording(GetParam()->file);
    if (file_.empty()) GTEST_SKIP() << test::not_tested_without(GetParam()->file);
  }
  std::filesystem::path file_;
};

TEST_P(RealRecording, HoldsWhatIsKnownOfIt) {
  const Known& known = *GetParam();
  EXPECT_EQ(sha256_of_file(file_), known.sha256);
  RecordingReader recording(file_);
  EXPECT_EQ(recording.file_size(), known.bytes);
  EXPECT_EQ(recording.index(), PacketIndex::table) << recording.problems().table;
  EXPECT_EQ(recording.compression(), Compression::lz4);
  const auto layout = test::layout_of(test::bytes_of(file_));
  EXPECT_EQ(layout.data_begin, known.data_begin);
  EXPECT_EQ(layout.table_at, known.table_at);
  std::vector<std::pair<std::int32_t, StreamType>> streams;
  for (const Stream& stream : recording.streams()) streams.emplace_back(stream.id, stream.type);
  EXPECT_EQ(streams, known.streams);
  const Stream& camera = event_stream(recording);
  EXPECT_EQ(camera.source, known.source);
  EXPECT_EQ(camera.size, known.size);
  const std::vector<std::pair<std::string, std::string>> info{{"tsOffset", known.ts_offset}};
  EXPECT_EQ(camera.info, info);

  std::vector<std::size_t> by_type(4);
  std::vector<std::int64_t> sizes;
  for (const PacketRecord& packet : recording.packets()) {
    const StreamType type = recording.stream(packet.stream_id).type;
    ++by_type.at(static_cast<std::size_t>(type));
    if (type != StreamType::events) continue;
    sizes.push_back(packet.elements);
    const auto events = recording.read_events(packet);  // the table is correct
    EXPECT_EQ(static_cast<std::int64_t>(events.size()), packet.elements);
    EXPECT_EQ(events.front().t, packet.first);
    EXPECT_EQ(events.back().t, packet.last);
  }
  EXPECT_EQ(by_type, known.packets_by_type);
  EXPECT_EQ(std::vector(sizes.begin(), sizes.begin() + 5), known.first_packets);
  EXPECT_EQ(sizes.back(), known.last_packet);
  std::sort(sizes.begin(), sizes.end());
  EXPECT_EQ(sizes.front(), known.fewest);
  EXPECT_EQ(sizes[sizes.size() / 2], known.median);
  EXPECT_EQ(sizes.back(), known.most);

  const auto all = test::contents_of(recording);
  ASSERT_EQ(all.events.size(), known.events);
  EXPECT_EQ(us_of(all.events.front().t), known.first_us);
  EXPECT_EQ(us_of(all.events.back().t), known.last_us);
  EXPECT_EQ(all.events.front(), known.first);
  EXPECT_EQ(all.events.back(), known.last);
  std::int64_t on = 0;
  std::int64_t sum_x = 0;
  std::int64_t sum_y = 0;
  SensorSize largest;
  SensorSize smallest{1000, 1000};
  std::set<CameraTime> times;
  for (const Event& e : all.events) {
    on += e.on;
    sum_x += e.x;
    sum_y += e.y;
    largest = {std::max<int>(largest.width, e.x), std::max<int>(largest.height, e.y)};
    smallest = {std::min<int>(smallest.width, e.x), std::min<int>(smallest.height, e.y)};
    times.insert(e.t);
  }
  EXPECT_EQ(on, known.on);
  EXPECT_EQ(sum_x, known.sum_x);
  EXPECT_EQ(sum_y, known.sum_y);
  EXPECT_EQ(largest, known.largest);
  EXPECT_EQ(smallest, (SensorSize{0, 0}));
  EXPECT_EQ(times.size(), known.distinct_times);
  EXPECT_EQ(all.event_digest(), known.digest);
  EXPECT_TRUE(std::is_sorted(all.events.begin(), all.events.end(), [](const Event& a, const Event& b) { return a.t < b.t; }));

  ASSERT_EQ(all.imu.size(), known.imu);
  const ImuSample& imu = all.imu.front();
  EXPECT_EQ(us_of(imu.t), known.imu_first_us);
  EXPECT_EQ(us_of(all.imu.back().t), known.imu_last_us);
  const std::vector<double> values{imu.temperature_c,      imu.acceleration_g[0],   imu.acceleration_g[1],
                                   imu.acceleration_g[2],  imu.angular_rate_dps[0], imu.angular_rate_dps[1],
                                   imu.angular_rate_dps[2]};
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_NEAR(values[i], known.imu_first[i], 0.5001e-4) << i;

  std::vector<std::int64_t> frames_us;
  for (const Frame& frame : all.frames) {
    frames_us.push_back(us_of(frame.t));
    EXPECT_EQ(frame.width, known.size.width);
    EXPECT_EQ(frame.height, known.size.height);
    EXPECT_EQ(frame.format, 0);
  }
  EXPECT_EQ(frames_us, known.frames_us);
  EXPECT_EQ(all.frame_digest(), known.frames_sha256);

  std::vector<std::size_t> triggers(10);
  for (const Trigger& trigger : all.triggers) ++triggers.at(static_cast<std::size_t>(trigger.type));
  EXPECT_EQ(triggers, known.triggers_by_type);
  if (!all.triggers.empty()) {
    EXPECT_EQ(us_of(all.triggers.front().t), known.trigger_first_us);
    EXPECT_EQ(all.triggers.front().type, known.trigger_first_type);
    EXPECT_EQ(us_of(all.triggers.back().t), known.trigger_last_us);
    EXPECT_EQ(all.triggers.back().type, known.trigger_last_type);
  }

  const RecordingProblems& problems = recording.problems();
  EXPECT_EQ(problems.table, "");
  EXPECT_EQ(problems.truncated_bytes + problems.empty_packets + problems.undeclared_packets + problems.mismatched_packets +
                problems.broken_packets + problems.out_of_range_events + problems.unwrapped_packets,
            0U);
}

TEST_P(RealRecording, IsScannedToTheSameContents) {
  const test::TemporaryFolder folder;
  std::string bytes = test::bytes_of(file_);
  bytes.resize(GetParam()->table_at);
  RecordingReader recording(test::write_bytes(folder / "cut.aedat4", bytes));
  EXPECT_EQ(recording.index(), PacketIndex::scan);
  RecordingReader whole(file_);
  ASSERT_EQ(recording.packets().size(), whole.packets().size());
  for (std::size_t i = 0; i < whole.packets().size(); ++i) {
    EXPECT_EQ(recording.packets()[i].elements, whole.packets()[i].elements);
    EXPECT_EQ(recording.packets()[i].first, whole.packets()[i].first);
    EXPECT_EQ(recording.packets()[i].last, whole.packets()[i].last);
  }
  EXPECT_EQ(test::contents_of(recording).event_digest(), GetParam()->digest);
}

TEST_P(RealRecording, RewrittenHasTheSameContents) {
  const test::TemporaryFolder folder;
  RecordingReader original(file_);
  for (const Compression compression :
       {Compression::none, Compression::lz4, Compression::lz4_high, Compression::zstd, Compression::zstd_high}) {
    const auto file = folder / (std::string(name_of(compression)) + ".aedat4");
    test::rewrite(original, file, {.compression = compression});
    RecordingReader copy(file);
    EXPECT_EQ(copy.index(), PacketIndex::table) << copy.problems().table;
    const auto all = test::contents_of(copy);
    EXPECT_EQ(all.event_digest(), GetParam()->digest);
    EXPECT_EQ(all.frame_digest(), GetParam()->frames_sha256);
    EXPECT_TRUE(test::same(all, test::contents_of(original)));
    EXPECT_EQ(event_stream(copy).info, event_stream(original).info);
  }
}

INSTANTIATE_TEST_SUITE_P(All, RealRecording, testing::Values(&tonic, &aestream),
                         [](const testing::TestParamInfo<const Known*>& known) {
                           return known.index == 0 ? "tonic" : "aestream";
                         });

}  // namespace
}  // namespace tactile::events
