#include "tactile/detect/quiet_stream.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <thread>
#include <vector>

#include "detect/live.hpp"
#include "support/comes_true.hpp"
#include "tactile/core/host_clock.hpp"

namespace tactile::detect {
namespace {

using namespace test;

TEST(LiveDetector, WakesOnlyForPacketsThatCloseATickOrAreLarge) {
  // Ticks of 1000 s, so that none closes by the host's time meanwhile, however busy it is.
  constexpr std::int64_t tick = 1'000'000'000;
  std::vector<ReportedTick> reported;
  const heatmaps::HeatmapOptions rendering{.history = 1000s, .tick = 1000s};
  LiveDetector detector(
      {model_of(slip_where_anything_is, rendering), {.rendering = rendering}},
      {.clock = {.tick = 1000s, .history = 1000s, .slack = 2ms}, .jump = 10'000s, .stopped_for = 10'000s},
      [&reported](const ReportedTick& each) { reported.push_back(each); }, [](const DetectionFault&) {});
  const auto events_at = [](std::int64_t t, std::size_t count) {
    events::Event event;
    event.t = camera_time(t);
    return std::vector<events::Event>(count, event);
  };
  capture::PacketQueue queue(1U << 20U);
  const auto push = [&](std::int64_t t, bool wakes) {
    capture::PacketQueue::Packet packet = queue.take();
    packet.front().arrived = host_now();
    packet.front().elements.events = events_at(t, 1);
    return queue.push(packet, false, wakes);
  };
  EXPECT_TRUE(detector.awaits(events_at(0, 1))) << "nothing is known yet";
  Queued queued(queue);
  std::thread running([&] { detector.run(queued, [] { return false; }); });
  EXPECT_TRUE(push(0, true));
  EXPECT_TRUE(test::comes_true([&] { return !detector.awaits(events_at(tick - 1, 1)); })) << "the first tick is at 1000 s";
  EXPECT_TRUE(detector.awaits(events_at(tick, 1)));
  EXPECT_TRUE(detector.awaits(events_at(tick / 2, 1'000)));
  EXPECT_TRUE(detector.awaits({})) << "the stream may restart";
  EXPECT_TRUE(push(tick - 1, false)) << "it lies there until the next one";
  EXPECT_TRUE(push(tick, true));
  EXPECT_TRUE(test::comes_true([&] { return !detector.awaits(events_at(2 * tick - 1, 1)); }));
  queue.close();
  running.join();
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_EQ(reported[0].verdict.t, camera_time(tick));
  EXPECT_EQ(reported[0].verdict.events, 2U);
}

/// Packets of 1 ms whose last event comes 0.1 to 0.2 ms after it happened; those that close a tick bring `events` of them.
void play_quietly(Live& live, std::int64_t from_ms, std::int64_t to_ms, bool is_exact, std::size_t events = 2) {
  for (std::int64_t ms = from_ms; ms < to_ms; ++ms) {
    const std::int64_t last = 1'000 * ms + 900, at = base + last + 100 + 10 * (ms / 2 % 11);
    std::vector<std::int64_t> times(ms % 2 == 0 ? events : 2, 1'000 * ms);
    times.back() = last;
    live.take(times, at, 0, is_exact);
    live.report_all(at);
  }
}

TEST(LiveDetector, LetsPacketsOfAQuietStreamWaitUntilTheNextTickCanClose) {
  Live live;
  const HostTime start = host_time(base + 21'000);
  play_quietly(live, 0, 20, true);
  EXPECT_EQ(live.detector.rests_until(start), start) << "not known for long";
  play_quietly(live, 20, 600, true);
  // The tick at 600 ms is closed by the packet that ends at 600.9 ms and comes 0.1 ms later at the earliest.
  const HostTime now = host_time(base + 600'050);
  EXPECT_EQ(live.detector.rests_until(now), host_time(base + 601'000));
  EXPECT_EQ(live.detector.rests_until(host_time(base + 601'500)), host_time(base + 601'500)) << "it is late";
  const HostTime later = host_time(base + 2'000'000);
  EXPECT_EQ(live.detector.rests_until(later), later) << "it was long ago";
  play_quietly(live, 600, 603, true, 1'000);
  const HostTime busy = host_time(base + 603'200);
  EXPECT_EQ(live.detector.rests_until(busy), busy) << "much is to be counted as it comes";
  play_quietly(live, 603, 1'700, true);
  EXPECT_GT(live.detector.rests_until(host_time(base + 1'700'050)), host_time(base + 1'700'050)) << "quiet again";
}

TEST(LiveDetector, LetsNoPacketWaitWithoutAKnownArrival) {
  Live live;
  play_quietly(live, 0, 1'000, false);
  const HostTime now = host_time(base + 1'000'050);
  EXPECT_EQ(live.detector.rests_until(now), now) << "what is read late would seem to come late, and be read later still";
}

TEST(LiveDetector, LearnsNothingFromPacketsThatArrivedWithLaterOnes) {
  Live live;
  for (std::int64_t ms = 0; ms < 1'000; ++ms) {
    capture::QueuedPacket packet{.source_index = 0, .arrived = host_time(base + 1'000 * ms + 1'000), .elements = {}};
    packet.elements.events.resize(1);
    packet.elements.events[0].t = camera_time(1'000 * ms);
    packet.elements.arrived = packet.arrived;
    packet.elements.more_came = true;
    live.detector.take(packet);
    live.report_all(base + 1'000 * ms + 1'000);
  }
  const HostTime now = host_time(base + 1'000'050);
  EXPECT_EQ(live.detector.rests_until(now), now) << "how early they came is not known";
}

TEST(LiveDetector, DoesNotCloseATickWhoseEventsMayStillWait) {
  Live live;
  for (std::int64_t t = 0; t <= 10'000; t += 500) live.take({t}, base + t);
  live.report_all(base + 10'000);
  ASSERT_EQ(live.reported.size(), 1U);
  // Held up for 20 ms, of which 5 have been read.
  live.take({10'500, 11'500}, base + 11'500);
  EXPECT_FALSE(live.detector.report_due(host_time(base + 30'000), host_time(base + 11'500))) << "the tick at 12 ms";
  live.take({11'900, 15'000}, base + 15'000);
  EXPECT_TRUE(live.detector.report_due(host_time(base + 30'000), host_time(base + 15'000)));
  EXPECT_EQ(live.reported.back().verdict.t, camera_time(14'000)) << "the newest whose events are known to be here";
  EXPECT_TRUE(live.reported.back().due.by_events);
  EXPECT_FALSE(live.detector.report_due(host_time(base + 30'000), host_time(base + 15'000)));
  EXPECT_EQ(live.detector.counts().late_events, 0U);
  EXPECT_TRUE(live.detector.report_due(host_time(base + 30'000))) << "by the host's time, once nothing waits";
  EXPECT_FALSE(live.reported.back().due.by_events);
}

}  // namespace
}  // namespace tactile::detect
