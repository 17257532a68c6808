#include "tactile/detect/live_detector.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <thread>

#include "detect/live.hpp"
#include "support/error_of.hpp"
#include "tactile/heatmaps/run_heatmaps.hpp"

namespace tactile::detect {
namespace {

using namespace test;

TEST(LiveDetector, ReportsEachTickOnceALaterEventHasArrived) {
  Live live;
  for (std::int64_t t = 0; t <= 14'000; t += 1'000) {
    live.take({t}, base + t + 300);
    live.report_all(base + t + 300);
  }
  ASSERT_EQ(live.reported.size(), 3U);
  EXPECT_EQ(live.reported[0].verdict.t, camera_time(10'000));
  EXPECT_EQ(live.reported[0].verdict.events, 10U);
  EXPECT_EQ(live.reported[0].verdict.verdict, Touch::slip);
  EXPECT_TRUE(live.reported[0].due.by_events);
  EXPECT_EQ(live.reported[2].verdict.t, camera_time(14'000));
  EXPECT_EQ(live.detector.deadlines().counts().skipped, 0U);
}

TEST(LiveDetector, ContinuesInSilenceUntilTheHistoryIsEmpty) {
  Live live;
  for (std::int64_t t = 0; t <= 10'000; t += 500) live.take({t}, base + t);
  for (std::int64_t now = 10'000; now <= 40'000; now += 100) live.report_all(base + now);
  ASSERT_GE(live.reported.size(), 13U);
  for (std::size_t i = 0; i < live.reported.size(); ++i)
    EXPECT_EQ(live.reported[i].verdict.t, camera_time(10'000 + 2'000 * static_cast<std::int64_t>(i)));
  EXPECT_EQ(live.reported[1].due.by_events, false);
  EXPECT_EQ(live.reported.back().verdict.verdict, Touch::none);
  EXPECT_EQ(live.reported.back().verdict.events, 0U);
  EXPECT_EQ(live.detector.deadlines().counts().skipped, 0U);
  live.detector.check_silence(host_time(base + 3'000'000));
  live.detector.check_silence(host_time(base + 3'100'000));
  ASSERT_EQ(live.faults.size(), 1U) << "reported once";
  EXPECT_EQ(live.faults[0].kind, "silence");
}

TEST(LiveDetector, EndsAReplayAfterItsDuration) {
  Live live(true, {}, 20ms);
  std::vector<std::int64_t> times;
  for (std::int64_t t = 0; t <= 100'000; t += 500) times.push_back(t);
  live.take(times, base);
  ASSERT_EQ(live.reported.size(), 10U) << "at 10 to 28 ms";
  EXPECT_EQ(live.reported.back().verdict.t, camera_time(28'000));
  EXPECT_EQ(live.detector.deadlines().counts().reported, 10U) << "ticks that are not reported do not count";
  live.take({200'000}, base);
  live.report_all(base);
  EXPECT_EQ(live.reported.size(), 10U);
}

constexpr std::int64_t a_year = 365LL * 24 * 3'600 * 1'000'000;

TEST(LiveDetector, RejectsAReplayWithATimeAYearAhead) {
  Live live(true);
  std::vector<std::int64_t> times;
  for (std::int64_t t = 0; t <= 20'000; t += 500) times.push_back(t);
  live.take(times, base);
  EXPECT_EQ(live.reported.size(), 6U) << "at 10 to 20 ms";
  const std::string refused = test::error_of([&] { live.take({a_year}, base); });
  EXPECT_NE(refused.find("ticks of 2000 us from the first event to the last; expected at most 100000000"), std::string::npos)
      << refused;
  EXPECT_EQ(live.reported.size(), 6U);
  std::vector<events::Event> events(2);
  events[1].t = camera_time(a_year);
  EXPECT_NE(test::error_of([&] {
              heatmaps::for_every_tick(events, sensor, {.history = 10ms, .tick = 2ms}, {});
            }).find("expected at most"),
            std::string::npos)
      << "as whoever looks at whole recordings does";
}

TEST(LiveDetector, PlaysAPartOfAReplayWithATimeAYearAhead) {
  Live live(true, {}, 20ms);
  live.take({0, 500, a_year}, base);
  EXPECT_EQ(live.reported.size(), 10U) << "at 10 to 28 ms";
  EXPECT_EQ(live.reported.back().verdict.t, camera_time(28'000));
}

TEST(LiveDetector, StopsWithinTheTicksThatOneEventCloses) {
  Live live(true);
  capture::PacketQueue queue(std::size_t{1} << 20);
  capture::PacketQueue::Packet packet = queue.take();
  packet.front().arrived = host_time(base);
  packet.front().elements.events.resize(2);
  packet.front().elements.events[1].t = camera_time(100'000'000'000);  // 50 million ticks
  ASSERT_TRUE(queue.push(packet, true));
  Queued queued(queue);
  live.detector.run(queued, [&] { return live.reported.size() >= 100; });
  EXPECT_GE(live.reported.size(), 100U);
  EXPECT_LE(live.reported.size(), 101U) << "one that is due may follow";
}

TEST(LiveDetector, SkipsToTheNewestTickWhenItIsLate) {
  Live live;
  for (std::int64_t t = 0; t <= 50'000; t += 500) live.take({t}, base + t);
  live.report_all(base + 50'100);  // much later
  ASSERT_EQ(live.reported.size(), 1U);
  EXPECT_EQ(live.reported[0].verdict.t, camera_time(50'000));
  EXPECT_EQ(live.reported[0].due.skipped, 20U);
  EXPECT_EQ(live.detector.deadlines().counts().skipped, 20U);
  EXPECT_EQ(live.reported[0].verdict.events, 20U) << "all events of the history, those of skipped ticks too";
  // The tick of 50 ms closed with the event at 50 ms.
  ASSERT_TRUE(live.reported[0].lateness);
  EXPECT_GE(*live.reported[0].lateness, 100us);
  Live replay(true);
  for (std::int64_t t = 0; t <= 50'000; t += 500) replay.take({t}, base + t);
  replay.report_all(base + 50'100);
  ASSERT_FALSE(replay.reported.empty());
  EXPECT_FALSE(replay.reported[0].lateness) << "a replay has no deadline";
}

TEST(LiveDetector, CountsTheNetworkAsLateness) {
  Live live(false, {}, microseconds::max(), [](std::span<const std::uint8_t>) {
    std::this_thread::sleep_for(3ms);
    return model::Logits{};
  });
  for (std::int64_t t = 0; t <= 10'000; t += 500) live.take({t}, base + t);
  live.report_all(base + 10'100);
  ASSERT_EQ(live.reported.size(), 1U);
  ASSERT_TRUE(live.reported[0].lateness);
  EXPECT_GE(*live.reported[0].lateness, 3'100us) << "the tick closed 100 us before, and the network takes 3 ms";
}

TEST(LiveDetector, WarnsOnceOfPacketsLongerThanATick) {
  Live live;
  live.take({0, 1'999}, base + 2'000);
  EXPECT_TRUE(live.faults.empty());
  live.take({2'000, 9'000}, base + 9'000);
  live.take({9'500, 19'000}, base + 19'000);
  ASSERT_EQ(live.faults.size(), 1U);
  EXPECT_EQ(live.faults[0].kind, "long packets");
}

TEST(LiveDetector, MarksVerdictsWithAnIncompleteHistory) {
  Live live;
  for (std::int64_t t = 0; t <= 10'000; t += 500) live.take({t}, base + t), live.report_all(base + t);
  EXPECT_FALSE(live.reported.back().incomplete);
  live.detector.note_lost(7);
  for (std::int64_t t = 11'000; t <= 30'000; t += 500) live.take({t}, base + t), live.report_all(base + t);
  EXPECT_EQ(live.detector.counts().lost_events, 7U);
  for (const ReportedTick& tick : live.reported)
    EXPECT_EQ(tick.incomplete, tick.verdict.t > camera_time(11'000) && tick.verdict.t < camera_time(21'000))
        << us_of(tick.verdict.t);
}

TEST(LiveDetector, CountsSkippedTicksAsNoneForTheConfirmation) {
  Live live(false, {2, 3});
  for (std::int64_t t = 0; t <= 12'000; t += 500) live.take({t}, base + t), live.report_all(base + t);
  ASSERT_EQ(live.reported.size(), 2U);
  EXPECT_EQ(live.reported[0].verdict.verdict, Touch::none);
  EXPECT_EQ(live.reported[1].verdict.verdict, Touch::slip);
  for (std::int64_t t = 12'500; t <= 40'000; t += 500) live.take({t}, base + t);
  live.report_all(base + 40'000);
  EXPECT_EQ(live.reported.back().verdict.predicted, Touch::slip);
  EXPECT_EQ(live.reported.back().verdict.verdict, Touch::none);
}

TEST(LiveDetector, ReportsEveryTickOfAReplay) {
  // At both ends of int64, and with a second of silence in between.
  for (const std::int64_t begin : {std::numeric_limits<std::int64_t>::min(), std::int64_t{-5'000}, std::int64_t{1} << 31,
                                   std::numeric_limits<std::int64_t>::max() - 1'200'000}) {
    std::vector<std::int64_t> times;
    for (std::int64_t t = 0; t <= 30'000; t += 70) times.push_back(begin + t);
    for (std::int64_t t = 1'100'000; t <= 1'130'000; t += 70) times.push_back(begin + t);
    std::vector<events::Event> events;
    for (const std::int64_t t : times) {
      events::Event event;
      event.t = camera_time(t);
      events.push_back(event);
    }
    std::vector<std::pair<CameraTime, std::uint64_t>> offline;
    heatmaps::for_every_tick(
        events, sensor, {.history = 10ms, .tick = 2ms},
        [&](CameraTime t, std::span<const std::uint8_t>, std::uint64_t count) { offline.emplace_back(t, count); });
    Live live(true);
    for (std::size_t i = 0; i < times.size(); i += 37)
      live.take({times.begin() + static_cast<std::ptrdiff_t>(i),
                 times.begin() + static_cast<std::ptrdiff_t>(std::min(times.size(), i + 37))},
                base);
    ASSERT_EQ(live.reported.size(), offline.size()) << begin;
    for (std::size_t i = 0; i < offline.size(); ++i) {
      EXPECT_EQ(live.reported[i].verdict.t, offline[i].first);
      EXPECT_EQ(live.reported[i].verdict.events, offline[i].second);
    }
    EXPECT_EQ(live.detector.deadlines().counts().skipped, 0U);
  }
}

TEST(TickDetector, GivesTheSameVerdictsIfEventsWereCountedAhead) {
  std::vector<std::vector<std::uint8_t>> heatmaps[2];
  for (const int ahead : {0, 1}) {
    auto& seen = heatmaps[ahead];
    TickDetector detector(model_of([&seen](std::span<const std::uint8_t> heatmap) {
                            seen.emplace_back(heatmap.begin(), heatmap.end());
                            return model::Logits{};
                          }),
                          {.rendering = short_history});
    std::uint32_t random = 1;
    for (std::int64_t tick = 2'000; tick <= 100'000; tick += 2'000) {
      for (std::int64_t packet = tick - 2'000; packet < tick; packet += 250) {
        std::vector<events::Event> events(7);
        for (std::size_t i = 0; i < events.size(); ++i) {
          random = random * 1'664'525 + 1'013'904'223;
          events[i].t = camera_time(packet + (i > 4 ? 300 : 0));  // the last ones may be later than the tick
          events[i].x = static_cast<std::int16_t>(random >> 16U & 15U);
          events[i].y = static_cast<std::int16_t>(random >> 24U & 15U);
        }
        if (packet % 2'000 > 0) std::fill(events.begin(), events.end() - 2, events.front());
        for (events::Event& event : events) event.t = std::max(event.t, camera_time(packet + 50));
        detector.add(events);
        if (ahead == 1 && random % 3 != 0) detector.count_ahead(camera_time(tick));
      }
      if (tick % 6'000 == 0) continue;  // skipped: a later one is reported instead
      TickCost cost;
      detector.verdict_at(camera_time(tick), tick % 6'000 == 2'000 && tick > 2'000 ? 1 : 0, cost);
    }
  }
  ASSERT_EQ(heatmaps[0].size(), 34U);
  EXPECT_EQ(heatmaps[0], heatmaps[1]);
}

}  // namespace
}  // namespace tactile::detect
