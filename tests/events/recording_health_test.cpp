#include "tactile/events/recording_health.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "events/made_recording.hpp"
#include "support/paths.hpp"
#include "support/temporary_folder.hpp"
#include "support/vendor_files.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"

namespace tactile::events {
namespace {

using test::event_at;
using test::vendor_files;

bool mentions(const std::vector<std::string>& lines, const std::string& words) {
  return std::any_of(lines.begin(), lines.end(), [&](const std::string& line) { return line.find(words) != std::string::npos; });
}

std::string listed(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

StampHealth stamps_of(const std::vector<std::vector<std::int64_t>>& packets, microseconds gap = 100us, std::size_t kept = 10) {
  StampMeter meter(gap, kept);
  for (const auto& packet : packets) {
    meter.begin_packet();
    for (const std::int64_t t : packet) meter.add(camera_time(t));
  }
  return meter.health();
}

EventHealth health_of(const std::vector<Event>& events, std::optional<SensorSize> size = SensorSize{20, 10},
                      const HealthOptions& options = {}) {
  EventMeter meter(size, options);
  meter.add_packet(events);
  return meter.health();
}

TEST(StampMeter, DistinguishesStepsBackInsidePacketsFromThoseBetweenPackets) {
  const StampHealth stamps = stamps_of({{10, 20, 15, 15, 30}, {29, 31}, {31, 40, 39, 38}});
  EXPECT_EQ(stamps.elements, 11U);
  EXPECT_EQ(stamps.steps_back_in_packets, 3U);
  EXPECT_EQ(stamps.steps_back_between_packets, 1U);
  EXPECT_EQ(stamps.first, camera_time(10));
  EXPECT_EQ(stamps.last, camera_time(40));
}

TEST(StampMeter, FindsSilencesLongerThanTheLimitOnly) {
  const StampHealth stamps = stamps_of({{0, 100, 201}, {401}});
  EXPECT_EQ(stamps.gaps, 2U);
  EXPECT_EQ(stamps.silent, 301us);
  ASSERT_EQ(stamps.longest_gaps.size(), 2U);
  EXPECT_EQ(stamps.longest_gaps[0].begin, camera_time(100));
  EXPECT_EQ(stamps.longest_gaps[1].length(), 200us);
}

TEST(StampMeter, KeepsTheLongestSilencesInOrderOfTime) {
  const StampHealth stamps = stamps_of({{0, 500, 700, 1700, 2000}}, 100us, 2);
  EXPECT_EQ(stamps.gaps, 4U);
  ASSERT_EQ(stamps.longest_gaps.size(), 2U);
  EXPECT_EQ(stamps.longest_gaps[0].length(), 500us);
  EXPECT_EQ(stamps.longest_gaps[1].length(), 1000us);
}

TEST(StampMeter, SeesNoSilenceInTheReturnFromAStepBack) { EXPECT_EQ(stamps_of({{5'000, 0, 5'050}}).gaps, 0U); }

TEST(StampMeter, HoldsItsDurationAtTheEndsOfTheClock) {
  const StampHealth stamps = stamps_of({{std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max()}});
  EXPECT_EQ(stamps.duration(), microseconds::max());
  EXPECT_EQ(stamps.gaps, 1U);
}

TEST(StampHealth, HasNoRateWithoutADuration) {
  EXPECT_FALSE(stamps_of({{7, 7, 7}}).rate_hz().has_value());
  EXPECT_FALSE(stamps_of({}).rate_hz().has_value());
  EXPECT_DOUBLE_EQ(stamps_of({{0, 250'000, 500'000}}, 1s).rate_hz().value(), 6.0);
}

TEST(EventMeter, CountsTheFullestTickAtWholeMultiplesOfTheTick) {
  const EventHealth health =
      health_of({event_at(1'998), event_at(1'999), event_at(2'000), event_at(2'001), event_at(3'999), event_at(4'000)});
  EXPECT_EQ(health.peak_tick_events, 3U);
  EXPECT_DOUBLE_EQ(health.peak_rate_hz, 1'500.0);
}

TEST(EventMeter, LaysTicksBeforeZeroAsAfterIt) {
  EXPECT_EQ(health_of({event_at(-2'001), event_at(-2'000), event_at(-1), event_at(0), event_at(1)}).peak_tick_events, 2U);
}

TEST(EventMeter, CountsBrighterEvents) {
  EXPECT_EQ(health_of({event_at(0, 1, 1, 1), event_at(1, 1, 1, 0), event_at(2, 2, 2, 1)}).on, 2U);
}

TEST(EventMeter, FindsTheReadOutPeriodAlthoughSomeReadOutsAreEmpty) {
  std::vector<Event> events;
  for (int i = 0; i < 1'000; ++i) {
    if (i % 3 == 1 || i % 7 == 2) continue;  // nothing fired
    for (int k = 0; k < 4; ++k) events.push_back(event_at(1'000'000 + 200 * i, k));
  }
  EXPECT_NEAR(health_of(events).readout.period_us.value, 200.0, 1e-6);
}

TEST(EventMeter, FindsTheReadOutPeriodOfAnUnsteadyClock) {
  std::vector<Event> events;
  std::int64_t t = 0;
  events.reserve(1'000);
  for (int i = 0; i < 1'000; ++i) events.push_back(event_at(t += 995 + i % 11));  // 995 .. 1005
  EXPECT_NEAR(health_of(events).readout.period_us.value, 1'000.0, 2.0);
}

TEST(EventMeter, FindsTheReadOutPeriodDespiteReadOutsThatABusySceneStretches) {
  std::vector<Event> events;
  std::int64_t t = 0;
  events.reserve(1'000);
  for (int i = 0; i < 1'000; ++i) events.push_back(event_at(t += i % 4 == 0 ? 200 : 300 + i % 200));
  EXPECT_NEAR(health_of(events).readout.period_us.value, 200.0, 1e-6);
}

TEST(EventMeter, GivesNoReadOutPeriodForAHandfulOfStamps) {
  EXPECT_EQ(health_of({event_at(0), event_at(200), event_at(400)}).readout.kind, Readout::Kind::none);
  EXPECT_EQ(health_of({}).readout.kind, Readout::Kind::none);
}

/// One event at every pixel of 20 x 10 every 100 ms for a second, and `extra` further ones.
std::vector<Event> with_scene(std::vector<Event> extra) {
  for (std::int64_t round = 0; round <= 10; ++round) {
    for (int y = 0; y < 10; ++y) {
      for (int x = 0; x < 20; ++x) extra.push_back(event_at(100'000 * round, x, y));
    }
  }
  std::sort(extra.begin(), extra.end(), [](const Event& a, const Event& b) { return a.t < b.t; });
  return extra;
}

std::vector<Event> firing(int x, int y, int events) {
  std::vector<Event> all;
  all.reserve(static_cast<std::size_t>(events));
  for (int i = 0; i < events; ++i) all.push_back(event_at(1'000'000 * std::int64_t{i} / events, x, y));
  return all;
}

TEST(HotPixels, AreThoseThatFireFarMoreThanTheMedian) {
  const EventHealth health = health_of(with_scene(firing(5, 4, 289)));
  ASSERT_EQ(health.hot_pixels, 1U);
  EXPECT_EQ(health.hottest[0].x, 5);
  EXPECT_EQ(health.hottest[0].y, 4);
  EXPECT_EQ(health.hottest[0].events, 300U);  // 289 of its own and 11 of the scene's
  EXPECT_DOUBLE_EQ(health.hottest[0].rate_hz, 300.0);
  EXPECT_EQ(health.hot_events, 300U);
  EXPECT_EQ(health.pixels_fired, 200U);
}

TEST(HotPixels, NeedTenTimesTheMedian) {
  EXPECT_EQ(health_of(with_scene(firing(5, 4, 98))).hot_pixels, 0U);  // 109 of 11
  EXPECT_EQ(health_of(with_scene(firing(5, 4, 99))).hot_pixels, 1U);  // 110 of 11
}

TEST(HotPixels, AreNotTheEdgeOfSomethingThatTrembles) {
  std::vector<Event> edge;
  for (int y = 0; y < 10; ++y) {
    const auto one = firing(7, y, 500);
    edge.insert(edge.end(), one.begin(), one.end());
  }
  EXPECT_EQ(health_of(with_scene(edge)).hot_pixels, 0U);
}

TEST(HotPixels, AreFoundInPairsAndInTheCorner) {
  std::vector<Event> extra = firing(0, 0, 500);
  for (const auto& pixel : {firing(10, 5, 400), firing(11, 5, 450)}) extra.insert(extra.end(), pixel.begin(), pixel.end());
  const EventHealth health = health_of(with_scene(extra));
  ASSERT_EQ(health.hot_pixels, 3U);
  EXPECT_EQ(health.hottest[0].events, 511U);
  EXPECT_EQ(health.hottest[1].events, 461U);
  EXPECT_EQ(health.hottest[2].events, 411U);
}

TEST(HotPixels, AreFoundWhereNothingElseFires) { EXPECT_EQ(health_of(firing(9, 9, 200), SensorSize{640, 480}).hot_pixels, 1U); }

TEST(HotPixels, FireFiftyTimesASecondAtLeast) {
  HealthOptions options;
  options.gap = 10s;
  std::vector<Event> slow;
  slow.reserve(245);
  for (int i = 0; i < 245; ++i) slow.push_back(event_at(20'408 * std::int64_t{i}, 9, 9));  // 49 a second for 5 s
  EXPECT_EQ(health_of(slow, SensorSize{640, 480}, options).hot_pixels, 0U);
}

TEST(HotPixels, AreCountedBeyondThoseListed) {
  HealthOptions options;
  options.listed = 1;
  std::vector<Event> extra = firing(2, 2, 500);
  const auto other = firing(15, 7, 600);
  extra.insert(extra.end(), other.begin(), other.end());
  const EventHealth health = health_of(with_scene(extra), SensorSize{20, 10}, options);
  EXPECT_EQ(health.hot_pixels, 2U);
  ASSERT_EQ(health.hottest.size(), 1U);
  EXPECT_EQ(health.hottest[0].x, 15);
}

TEST(HotPixels, AreNotLookedForOnASensorOfAbsurdSize) {
  EXPECT_FALSE(health_of({event_at(0)}, SensorSize{32'767, 32'767}).pixels_counted);
  EXPECT_FALSE(health_of({event_at(0)}, SensorSize{2'000'000'000, 2'000'000'000}).pixels_counted);
  EXPECT_FALSE(health_of({event_at(0)}, std::nullopt).pixels_counted);
}

TEST(ExamineRecording, FindsTheVendorsFilesHealthyAndCountsWhatIsInThem) {
  const nlohmann::json truth = read_json(vendor_files / "truth.json");
  for (const auto& [name, expected] : truth.items()) {
    const RecordingHealth health = examine_recording(vendor_files / (name + ".aedat4"));
    EXPECT_TRUE(health.healthy()) << name << ": " << listed(health.reasons);
    EXPECT_EQ(health.file_size, expected.at("bytes"));
    for (const StreamHealth& stream : health.streams) {
      switch (stream.stream.type) {
        case StreamType::events:
          EXPECT_EQ(stream.stamps.elements, expected.at("events"));
          EXPECT_EQ(stream.events->on, expected.at("on"));
          EXPECT_EQ(stream.packets, expected.at("event_packets"));
          EXPECT_EQ(us_of(stream.stamps.first), expected.at("first_us"));
          EXPECT_EQ(us_of(stream.stamps.last), expected.at("last_us"));
          EXPECT_NEAR(stream.events->readout.period_us.value, 200.0, 1e-6) << name;
          break;
        case StreamType::imu:
          EXPECT_EQ(stream.stamps.elements, expected.value("imu", 0U));
          break;
        case StreamType::triggers:
          EXPECT_EQ(stream.stamps.elements, expected.value("triggers", 0U));
          break;
        case StreamType::frames:
          EXPECT_EQ(stream.stamps.elements, expected.value("frames", 0U));
          break;
        case StreamType::other:
          ADD_FAILURE() << "no such stream was written";
          break;
      }
    }
  }
}

/// 3000 events in 30 packets of 10 ms on 64 x 48 pixels.
class HealthOfADamagedRecording : public testing::Test {
 protected:
  HealthOfADamagedRecording() {
    test::write_plain_recording(file, test::steady_events(3'000, 1'000'000, 100, {64, 48}), {64, 48});
    packets = test::packets_of(file);
  }
  RecordingHealth examine() const { return examine_recording(file); }

  test::TemporaryFolder folder;
  std::filesystem::path file = folder / "events.aedat4";
  std::vector<PacketRecord> packets;
};

TEST_F(HealthOfADamagedRecording, IsHealthyBeforeItIsDamaged) {
  ASSERT_EQ(packets.size(), 30U);
  const RecordingHealth health = examine();
  EXPECT_TRUE(health.healthy()) << listed(health.reasons);
  EXPECT_TRUE(health.notes.empty()) << listed(health.notes);
  EXPECT_EQ(health.index, PacketIndex::table);
}

TEST_F(HealthOfADamagedRecording, IsSickWhereItIsTruncated) {
  std::filesystem::resize_file(file, packets.back().payload_offset + 100);
  test::overwrite(file, test::table_position_offset, std::int64_t{-1});
  const RecordingHealth health = examine();
  EXPECT_TRUE(mentions(health.reasons, "truncated: 108 bytes")) << listed(health.reasons);
  EXPECT_EQ(health.streams.front().stamps.elements, 2'900U);
}

TEST_F(HealthOfADamagedRecording, IsOnlyANoteIfItWasNeverClosed) {
  test::cut_off_table(file);
  const RecordingHealth health = examine();
  EXPECT_TRUE(health.healthy()) << listed(health.reasons);
  EXPECT_TRUE(mentions(health.notes, "never closed")) << listed(health.notes);
  EXPECT_EQ(health.streams.front().stamps.elements, 3'000U);
}

TEST_F(HealthOfADamagedRecording, IsSickWhereItsTableIsOutOfPlace) {
  test::overwrite(file, test::table_position_offset, std::int64_t{1} << 40);
  EXPECT_TRUE(mentions(examine().reasons, "data table")) << listed(examine().reasons);
}

TEST_F(HealthOfADamagedRecording, IsSickWhereAPacketDoesNotDecode) {
  test::overwrite(file, packets[3].payload_offset + 28, std::uint32_t{1'000'000});  // it claims more events than it has room for
  const RecordingHealth health = examine();
  EXPECT_TRUE(mentions(health.reasons, "1 packet does not decode")) << listed(health.reasons);
  EXPECT_EQ(health.streams.front().stamps.elements, 2'900U);
}

TEST_F(HealthOfADamagedRecording, IsSickWhereAPacketHoldsAnotherType) {
  test::overwrite(file, packets[3].payload_offset + 8, std::array{'I', 'M', 'U', 'S'});
  EXPECT_TRUE(mentions(examine().reasons, "another type")) << listed(examine().reasons);
}

TEST_F(HealthOfADamagedRecording, IsSickWhereEventsLieOutsideTheSensor) {
  test::overwrite(file, test::event_offset(packets[1], 4) + 8, std::int16_t{64});
  test::overwrite(file, test::event_offset(packets[1], 5) + 10, std::int16_t{-1});
  const RecordingHealth health = examine();
  EXPECT_TRUE(mentions(health.reasons, "2 events lie outside")) << listed(health.reasons);
  EXPECT_EQ(health.streams.front().stamps.elements, 2'998U);
}

TEST_F(HealthOfADamagedRecording, IsSickWhereTimeStepsBack) {
  test::overwrite(file, test::event_offset(packets[1], 4), std::int64_t{1'000'000});
  const RecordingHealth health = examine();
  EXPECT_TRUE(mentions(health.reasons, "time steps back 1 time inside packets and 0 times from one")) << listed(health.reasons);
}

TEST_F(HealthOfADamagedRecording, IsSickWhereItsTableHasOtherTimesThanThePackets) {
  // The last place of the time in the file is in the table.
  const std::string bytes = read_text(file);
  const std::int64_t first = us_of(packets[4].first);
  const std::size_t at = bytes.rfind(std::string(reinterpret_cast<const char*>(&first), sizeof first));
  ASSERT_GT(at, packets.back().payload_offset + packets.back().payload_size);
  test::overwrite(file, at, first + 50);
  const RecordingHealth health = examine();
  EXPECT_EQ(health.index, PacketIndex::table) << health.problems.table;
  EXPECT_TRUE(mentions(health.reasons, "disagrees with the elements of 1 packet")) << listed(health.reasons);
}

TEST(ExamineRecording, FindsARecordingWithoutEventsSick) {
  const test::TemporaryFolder folder;
  test::write_plain_recording(folder / "empty.aedat4", {}, {64, 48});
  const RecordingHealth health = examine_recording(folder / "empty.aedat4");
  EXPECT_TRUE(mentions(health.reasons, "no events")) << listed(health.reasons);
  EXPECT_EQ(health.duration(), 0us);
}

/// Events pause from 0.3 s to 0.6 s; the inertial sensor does too, or does not.
RecordingHealth health_with_pause(bool imu_pauses) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "events.aedat4";
  RecordingWriter writer(file,
                         {event_stream_declaration({64, 48}, "DVXplorer_DXM00001"), test::stream_of(2, StreamType::imu, "IMUS")});
  for (std::int64_t t = 0; t < 900'000; t += 1'000) {
    const bool pause = t >= 300'000 && t < 600'000;
    const Event event = event_at(t, static_cast<int>(t / 1'000 % 64), 3);
    if (!pause) writer.write_events(0, {&event, 1});
    ImuSample sample;
    sample.t = camera_time(t);
    if (!pause || !imu_pauses) writer.write_imu(2, {&sample, 1});
  }
  writer.close();
  return examine_recording(file);
}

TEST(ExamineRecording, TakesASilenceOfTheEventsAloneForAQuietScene) {
  const RecordingHealth health = health_with_pause(false);
  EXPECT_TRUE(health.healthy()) << listed(health.reasons);
  EXPECT_TRUE(mentions(health.notes, "1 silence longer than 100000 us")) << listed(health.notes);
}

TEST(ExamineRecording, TakesASilenceOfEventsAndImuForMissingData) {
  const RecordingHealth health = health_with_pause(true);
  EXPECT_TRUE(mentions(health.reasons, "data is missing")) << listed(health.reasons);
  EXPECT_TRUE(health.streams.front().stamps.longest_gaps.at(0).imu_silent);
}

TEST(ExamineRecording, KeepsTwoCamerasApart) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "two.aedat4";
  Stream second = test::stream_of(1, StreamType::events, "EVTS", "DVXplorer_B");
  second.size = SensorSize{32, 24};
  RecordingWriter writer(file, {event_stream_declaration({64, 48}, "DVXplorer_A"), second});
  writer.write_events(0, test::steady_events(300, 0, 100, {64, 48}));
  writer.write_events(1, test::steady_events(200, 0, 100, {32, 24}));
  writer.close();

  const RecordingHealth both = examine_recording(file);
  ASSERT_EQ(both.streams.size(), 2U);
  EXPECT_EQ(both.streams[0].stamps.elements, 300U);
  EXPECT_EQ(both.streams[1].stamps.elements, 200U);
  const RecordingHealth one = examine_recording(file, {.stream = "DVXplorer_B"});
  ASSERT_EQ(one.streams.size(), 1U);
  EXPECT_EQ(one.streams[0].stamps.elements, 200U);
  EXPECT_THROW(examine_recording(file, {.stream = "DVXplorer_C"}), Error);
}

}  // namespace
}  // namespace tactile::events
