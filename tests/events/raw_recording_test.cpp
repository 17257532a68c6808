// Prophesee RAW files. The real ones are not part of this project.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <tuple>

#include "events/made_raw.hpp"
#include "events/made_recording.hpp"
#include "support/real_recordings.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/events/evt2.hpp"
#include "tactile/events/evt3.hpp"
#include "tactile/events/recording_health.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/repair.hpp"

namespace tactile::events {
namespace {

namespace fs = std::filesystem;
using test::event_at;

std::vector<Event> all_events(RecordingReader& recording) {
  std::vector<Event> events;
  for_all_events(recording, 0, [&](std::span<const Event> some) { events.insert(events.end(), some.begin(), some.end()); });
  return events;
}

std::vector<Trigger> all_triggers(RecordingReader& recording) {
  std::vector<Trigger> triggers;
  for (const PacketRecord& packet : recording.packets()) {
    if (recording.stream(packet.stream_id).type != StreamType::triggers) continue;
    const auto some = recording.read_triggers(packet);
    triggers.insert(triggers.end(), some.begin(), some.end());
  }
  return triggers;
}

std::string complaint_about(std::string_view header) {
  const test::TemporaryFolder folder;
  test::write_raw(folder / "a.raw", header, std::vector<std::uint16_t>{0x8001, 0x6002});
  try {
    const RecordingReader recording(folder / "a.raw");
    return "no error";
  } catch (const Error& e) {
    const std::string what = e.what();
    return what.substr(what.find("a.raw") + 5);
  }
}

std::optional<SensorSize> size_by(const std::string& header) {
  const test::TemporaryFolder folder;
  test::write_raw(folder / "a.raw", header, std::vector<std::uint16_t>{});
  return RecordingReader(folder / "a.raw").stream(0).size;
}

TEST(RawRecording, OfEvt2HasEventsAndTriggers) {
  const test::TemporaryFolder folder;
  test::write_raw<std::uint32_t>(folder / "a.raw", test::evt2_header,
                                 {test::evt2_event(1, 5, 1, 1), test::evt2_time(2), test::evt2_event(1, 5, 639, 479),
                                  test::evt2_event(0, 6, 640, 0), test::evt2_trigger(1, 7, 0), 0xE000'0000, 0xF000'0000,
                                  0x3000'0000, test::evt2_time(3), test::evt2_event(0, 0, 3, 4), test::evt2_trigger(0, 63, 0)},
                                 "\1\2\3");
  RecordingReader recording(folder / "a.raw");
  EXPECT_EQ(recording.encoding(), RecordingEncoding::evt2);
  EXPECT_EQ(recording.index(), PacketIndex::pieces);
  EXPECT_EQ(recording.stream(0).source, "Prophesee_42");
  EXPECT_EQ(recording.stream(0).size, (SensorSize{640, 480}));
  EXPECT_EQ(all_events(recording), (std::vector{event_at(133, 639, 479, 1), event_at(192, 3, 4, 0)}));
  const auto triggers = all_triggers(recording);
  ASSERT_EQ(triggers.size(), 2U);
  EXPECT_EQ(us_of(triggers[0].t), 135);
  EXPECT_EQ(triggers[0].type, 1);
  EXPECT_EQ(us_of(triggers[1].t), 255);
  EXPECT_EQ(triggers[1].type, 2);
  EXPECT_EQ(recording.problems().out_of_range_events, 1U);
  EXPECT_EQ(recording.problems().skipped_bytes, 4U);
  EXPECT_EQ(recording.problems().truncated_bytes, 3U);
}

TEST(Evt2Decoder, CarriesTheTimeOverItsRollOverAndTakesASmallStepBackAsDisorder) {
  Evt2Decoder decoder({640, 480});
  std::vector<Event> events;
  std::vector<Evt3Trigger> triggers;
  const std::vector<std::uint32_t> words{test::evt2_time(0xFFF'FFFF),  test::evt2_event(1, 1, 0, 0), test::evt2_time(0),
                                         test::evt2_event(1, 2, 0, 0), test::evt2_time(0xFFF'FFFF),  test::evt2_event(1, 3, 0, 0),
                                         test::evt2_time(1),           test::evt2_event(1, 4, 0, 0)};
  decoder.decode(std::as_bytes(std::span(words)), events, triggers);
  constexpr std::int64_t turn = std::int64_t{1} << 34;
  ASSERT_EQ(events.size(), 4U);
  EXPECT_EQ(us_of(events[0].t), turn - 64 + 1);
  EXPECT_EQ(us_of(events[1].t), turn + 2);
  EXPECT_EQ(us_of(events[2].t), turn - 64 + 3);
  EXPECT_EQ(us_of(events[3].t), turn + 64 + 4);
}

TEST(RawRecording, IsReadInPiecesAsInOnePass) {
  const test::TemporaryFolder folder;
  const auto words = test::steady_evt3(2'000'000);  // more than one roll-over of 16.8 s
  test::write_raw(folder / "a.raw", test::evt3_header, words);
  std::vector<Event> expected;
  std::vector<Evt3Trigger> edges;
  Evt3Decoder({640, 480}).decode(std::as_bytes(std::span(words)), expected, edges);
  RecordingReader recording(folder / "a.raw");
  EXPECT_GT(recording.packets().size(), 100U);
  const std::vector<Event> events = all_events(recording);
  EXPECT_EQ(events, expected);
  EXPECT_EQ(us_of(events.back().t) - us_of(events.front().t), 19'999'990);
  EXPECT_EQ(all_triggers(recording).size(), 2'000U);
  // Any piece may be read at any time.
  const PacketRecord& late = recording.packets()[90];
  const PacketRecord& early = recording.packets()[2];
  ASSERT_EQ(late.stream_id, 0);
  ASSERT_EQ(early.stream_id, 0);
  const std::span<const Event> some = recording.read_events(late);
  EXPECT_EQ(some.front().t, late.first);
  EXPECT_EQ(some.back().t, late.last);
  EXPECT_EQ(recording.read_events(early).front().t, early.first);
  std::size_t between_times = 0;
  for_events_between(recording, 0, camera_time(5'000'000), camera_time(5'001'000),
                     [&](std::span<const Event> part) { between_times += part.size(); });
  EXPECT_EQ(between_times, 100U);
}

TEST(RawRecording, IsHealthyAndDeclaresTriggersOnlyIfItHasAny) {
  const test::TemporaryFolder folder;
  test::write_raw(folder / "a.raw", test::evt3_header, test::steady_evt3(999));
  const RecordingHealth health = examine_recording(folder / "a.raw");
  EXPECT_TRUE(health.healthy()) << health.reasons.front();
  EXPECT_EQ(health.encoding, RecordingEncoding::evt3);
  ASSERT_EQ(health.streams.size(), 1U);
  EXPECT_EQ(health.streams[0].stamps.elements, 999U);
  test::write_raw(folder / "b.raw", test::evt3_header, test::steady_evt3(1000));
  EXPECT_EQ(RecordingReader(folder / "b.raw").streams().size(), 2U);
}

TEST(RawRecording, HasTheSizeOfItsHeaderOrOfItsCamerasGeneration) {
  EXPECT_EQ(size_by("% evt 3.0\n% geometry 1280x720\n"), (SensorSize{1280, 720}));
  EXPECT_EQ(size_by("% format EVT2;height=10;width=20\n% end\n"), (SensorSize{20, 10}));
  EXPECT_EQ(size_by("% evt 2.0\r\n% plugin_name hal_plugin_gen3_fx3\r\n"), (SensorSize{640, 480}));
  EXPECT_EQ(size_by("% evt 3.0\n% plugin_name hal_plugin_gen41_evk3\n"), (SensorSize{1280, 720}));
  EXPECT_EQ(size_by("% evt 3.0\n% sensor_generation 4.2\n"), (SensorSize{1280, 720}));
  EXPECT_EQ(size_by("% format EVT3\n% sensor_name GenX320\n% end\n"), (SensorSize{320, 320}));
  EXPECT_EQ(size_by("% evt 3.0\n"), std::nullopt);
}

TEST(RawRecording, EndsItsHeaderWhereALineIsNoText) {
  const test::TemporaryFolder folder;
  // The first word, a row of 0x025, has the bytes "% " as a line of the header.
  std::vector<std::uint16_t> words{0x2025, test::evt3_time_high(1), test::evt3_time_low(2), test::evt3_row(10),
                                   test::evt3_event(1, 7)};
  test::write_raw(folder / "a.raw", "% evt 3.0\n% geometry 640x480\n", words);
  RecordingReader recording(folder / "a.raw");
  EXPECT_EQ(all_events(recording), std::vector{event_at(4098, 7, 10, 1)});
}

TEST(RawRecording, IsRefusedWithTheReason) {
  EXPECT_EQ(complaint_about("% format EVT21;height=720;width=1280\n% end\n"),
            ": is encoded as 'evt21'; expected a RAW file of EVT2 or EVT3");
  EXPECT_EQ(complaint_about("% evt 4.0\n"), ": is encoded as 'evt4.0'; expected a RAW file of EVT2 or EVT3");
  EXPECT_EQ(complaint_about("% Data file containing CD events.\n% Version 2\n"),
            ": its header names no encoding; expected a RAW file of EVT2 or EVT3");
  EXPECT_EQ(complaint_about("% evt 3.0\n% geometry 0x720\n"),
            ": its header gives a sensor of '0' x '720' pixels; expected 1 to 2048 each");
  EXPECT_EQ(complaint_about("% evt 3.0\n% geometry 1280x4294967297\n"),
            ": its header gives a sensor of '1280' x '4294967297' pixels; expected 1 to 2048 each");
  const test::TemporaryFolder folder;
  test::write_raw(folder / "a.raw", test::evt3_header, test::steady_evt3(10));
  EXPECT_THROW(repair_recording(folder / "a.raw", folder / "b.aedat4"), Error);
}

/// Decodes the words one by one, in Python, and prints the number of events and sums of each column.
constexpr const char* python_decoder = R"(
import struct, sys
data = open(sys.argv[1], 'rb').read()
at = 0
while data[at:at + 2] == b'% ': at = data.index(b'\n', at) + 1
n = t = x_sum = y_sum = on_sum = t_sum = high = low = y = base = on_base = 0
def put(x, on):
    global n, t_sum, x_sum, y_sum, on_sum
    n += 1; t_sum += t * (n % 1000); x_sum += x * (n % 1000); y_sum += y * (n % 1000); on_sum += on * (n % 1000)
if sys.argv[2] == '3':
    for (word,) in struct.iter_unpack('<H', data[at:]):
        kind, value = word >> 12, word & 0xfff
        if kind == 0: y = value & 0x7ff
        elif kind == 2: put(value & 0x7ff, value >> 11)
        elif kind == 3: base, on_base = value & 0x7ff, value >> 11
        elif kind in (4, 5):
            for bit in range(12 if kind == 4 else 8):
                if value >> bit & 1: put(base + bit, on_base)
            base += 12 if kind == 4 else 8
        elif kind == 6: low = value; t = high * 4096 + low
        elif kind == 8:
            if value != high: high, low = value, 0
            t = high * 4096 + low
else:
    for (word,) in struct.iter_unpack('<I', data[at:]):
        kind = word >> 28
        if kind == 8: high = word & 0xfffffff
        elif kind < 2: t = high * 64 + (word >> 22 & 63); y = word & 0x7ff; put(word >> 11 & 0x7ff, kind)
print(n, t_sum, x_sum, y_sum, on_sum)
)";

class RealRaw : public testing::TestWithParam<const char*> {};

TEST_P(RealRaw, HasTheEventsThatAnIndependentReaderFinds) {
  const std::string name = std::string("expelliarmus/evt") + GetParam() + "_sample.raw";
  const fs::path file = test::real_recording(name);
  if (file.empty()) GTEST_SKIP() << test::not_tested_without(name);
  RecordingReader recording(file);
  std::int64_t n = 0, t = 0, x = 0, y = 0, on = 0;
  for (const Event& event : all_events(recording)) {
    const std::int64_t weight = ++n % 1000;
    t += us_of(event.t) * weight;
    x += event.x * weight;
    y += event.y * weight;
    on += event.on * weight;
  }
  const test::TemporaryFolder script;
  write_whole(script / "decode.py", python_decoder);
  const test::CommandResult python = test::run_shell("python3 decode.py " + file.string() + " " + GetParam(), script.path());
  std::string expected;
  for (const std::int64_t sum : {n, t, x, y, on}) expected += (expected.empty() ? "" : " ") + std::to_string(sum);
  EXPECT_EQ(python.out, expected + "\n") << python.err;
  EXPECT_GT(n, 200'000);
  EXPECT_TRUE(examine_recording(file).healthy());
}

INSTANTIATE_TEST_SUITE_P(Evt, RealRaw, testing::Values("2", "3"));

TEST(RealRawReference, HasThePixelsAndPolaritiesOfThePublishedReference) {
  const fs::path samples = test::real_recording("expelliarmus");
  if (samples.empty()) GTEST_SKIP() << test::not_tested_without("expelliarmus");
  const std::string npy = read_text(samples / "evt3_sample.npy");  // 16 bytes an event: t, x, y, p, three of padding
  RecordingReader recording(samples / "evt3_sample.raw");
  const std::vector<Event> events = all_events(recording);
  ASSERT_GT(npy.size(), 16 * events.size());
  const char* row = npy.data() + (npy.size() - 16 * events.size());
  std::int64_t ahead = 0;
  for (const Event& event : events) {
    std::int64_t t = 0;
    std::int16_t x = 0, y = 0;
    std::memcpy(&t, row, 8);
    std::memcpy(&x, row + 8, 2);
    std::memcpy(&y, row + 10, 2);
    ASSERT_EQ(std::tuple(x, y, row[12]), std::tuple(event.x, event.y, static_cast<char>(event.on)));
    // The reference takes each step back of the time's lower half as a roll-over, so it runs ahead by 4096 us at each.
    const std::int64_t now_ahead = t - us_of(event.t);
    ASSERT_TRUE(now_ahead == ahead || now_ahead == ahead + 4096) << now_ahead;
    ahead = now_ahead;
    row += 16;
  }
  EXPECT_EQ(ahead, 11 * 4096);
}

}  // namespace
}  // namespace tactile::events
