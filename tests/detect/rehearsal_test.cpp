#include "tactile/detect/rehearsal.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <thread>
#include <vector>

#include "detect/live.hpp"

namespace tactile::detect {
namespace {

using namespace test;

/// A detector whose network takes some ms and is seen at its work. Its times are counted in 0.1 ms: a tick is 1'000'000 of them,
/// 100 s, beside which the network takes next to nothing even where the machine is busy.
struct Rehearsing {
  std::vector<std::vector<std::uint8_t>> asked;
  std::vector<ReportedTick> reported;
  LiveDetector detector;

  inline static const heatmaps::HeatmapOptions long_history{.history = 100s, .tick = 100s};
  static HostTime host_at(std::int64_t t) { return host_time(base + 100 * t); }

  explicit Rehearsing(bool rehearses)
      : detector(
            {model_of(
                 [this](std::span<const std::uint8_t> heatmap) {
                   asked.emplace_back(heatmap.begin(), heatmap.end());
                   std::this_thread::sleep_for(2ms);
                   return slip_where_anything_is(heatmap);
                 },
                 long_history),
             {.rendering = long_history, .decision = {.confirmation = {2, 3}}}},
            {.clock = {.tick = 100s, .history = 100s, .slack = 2ms}, .rehearses = rehearses},
            [this](const ReportedTick& tick) { reported.push_back(tick); }, [](const DetectionFault&) {}) {}

  /// Reported at once, if it closes a tick.
  void take(std::int64_t t, std::size_t count = 1) {
    capture::QueuedPacket packet{.arrived = host_at(t), .elements = {}};
    events::Event event;
    event.t = camera_time(100 * t);
    event.x = static_cast<std::int16_t>(t / 100'000 % 50);
    packet.elements.events.assign(count, event);
    detector.take(packet);
    while (detector.report_due(host_at(t))) {
    }
  }
  /// As `run` does: rehearses at the announced time. @return  whether it did
  bool rehearse_within(std::int64_t from, std::int64_t to) {
    const std::uint64_t before = detector.counts().rehearsals;
    constexpr std::int64_t step = 100;
    for (std::int64_t t = from; t < to; t += step) {
      const HostTime wakes = detector.wakes_at(host_at(t));
      if (wakes < host_at(t + step)) detector.rehearse(wakes);
    }
    return detector.counts().rehearsals > before;
  }
  std::vector<std::vector<std::uint8_t>> asked_without_rehearsals;
};

TEST(LiveDetector, RunsTheNetworkBeforeEachTickWithTheSameVerdicts) {
  Rehearsing with(true), without(false);
  for (Rehearsing* each : {&with, &without}) {
    for (std::int64_t t = 0; t <= 10'000'000; t += 100'000) {
      const std::size_t before = each->reported.size();
      each->take(t);
      if (each->reported.size() > before) each->asked_without_rehearsals.push_back(each->asked.back());
      each->rehearse_within(t, t + 100'000);
    }
    ASSERT_EQ(each->reported.size(), 10U) << "at 100 to 1000 s";
  }
  EXPECT_EQ(with.detector.counts().rehearsals, 9U) << "once between two";
  EXPECT_EQ(with.asked.size(), 19U);
  EXPECT_EQ(without.detector.counts().rehearsals, 0U);
  EXPECT_EQ(without.asked.size(), 10U);
  EXPECT_EQ(with.asked_without_rehearsals, without.asked) << "of the same heatmaps";
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(with.reported[i].verdict.t, without.reported[i].verdict.t);
    EXPECT_EQ(with.reported[i].verdict.events, without.reported[i].verdict.events);
    EXPECT_EQ(with.reported[i].verdict.verdict, i == 0 ? Touch::none : Touch::slip) << "confirmed by two of three reported ticks";
    EXPECT_EQ(without.reported[i].verdict.verdict, with.reported[i].verdict.verdict);
  }
}

TEST(LiveDetector, RehearsesNeitherTooEarlyNorTooLate) {
  // Ahead of the next tick, in what the last one took.
  for (const auto& [ahead, times] : {std::pair{5, 0U}, {3, 1U}, {2, 0U}, {0, 0U}, {-1, 0U}}) {
    Rehearsing live(true);
    live.take(0);
    live.take(1'000'000);
    ASSERT_EQ(live.reported.size(), 1U);
    const DeadlineMonitor& deadlines = live.detector.deadlines();
    const auto taken = std::chrono::duration_cast<microseconds>(deadlines.rendering().max() + deadlines.network().max());
    live.detector.rehearse(Rehearsing::host_at(2'000'000) - ahead * taken);
    EXPECT_EQ(live.detector.counts().rehearsals, times) << ahead;
    EXPECT_EQ(live.asked.size(), 1U + times) << ahead;
  }
}

}  // namespace
}  // namespace tactile::detect
