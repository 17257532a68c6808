#include "tactile/detect/late_events.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "detect/live.hpp"
#include "tactile/core/host_clock.hpp"

namespace tactile::detect {
namespace {

using namespace test;

TEST(LiveDetector, ReportsManyLateEvents) {
  Live live;
  live.play_with_late_packets_each(5'000);
  const auto count = std::count_if(live.faults.begin(), live.faults.end(),
                                   [](const DetectionFault& fault) { return fault.kind == "late events"; });
  ASSERT_EQ(count, 1) << "in three seconds";
  EXPECT_NE(live.faults.back().text.find("try --slack-us 10000"), std::string::npos) << live.faults.back().text;
  EXPECT_EQ(live.detector.late_events().proposed_slack(), 10ms) << "5 ms more than the longest packet, which ticks wait for";
  EXPECT_NE(live.faults.back().text.find("up to 5.0 ms after"), std::string::npos) << live.faults.back().text;
  EXPECT_TRUE(live.reported.back().incomplete);
}

TEST(LateEvents, NeedTheSlackThatMostOfThemWaitFor) {
  LateEvents late(500ms, [](const DetectionFault&) {});
  EXPECT_EQ(late.proposed_slack(), std::nullopt);
  const auto add = [&](std::int64_t delay_us, microseconds waits = 2ms) {
    const events::Event event{.t = camera_time(1'000'000 - delay_us), .x = 0, .y = 0, .on = true};
    late.add({&event, 1}, 1, camera_time(1'000'000), waits, HostTime{1s});
  };
  for (int i = 0; i < 500; ++i) add(3'200);
  add(400'000);
  EXPECT_EQ(late.proposed_slack(), 6ms) << "2 + 3.2 ms; one that came 0.4 s late does not count";
  for (int i = 0; i < 500; ++i) add(3'200, 10ms);
  EXPECT_EQ(late.proposed_slack(), 14ms) << "with packets of 10 ms the ticks waited for 10 ms";
  for (int i = 0; i < 500; ++i) add(100'000);
  EXPECT_EQ(late.proposed_slack(), std::nullopt) << "the source stalls";
}

TEST(Backlog, SaysHowOftenEventsWereReadLateSinceTheLastReport) {
  Backlog backlog([](const DetectionFault&) {});
  const auto text_at = [&](std::chrono::seconds at) { return backlog.text_of(600ms, HostTime{1'000s + at}); };
  const std::string once = text_at(0s);
  EXPECT_NE(once.find("read 0.6 s late: more events"), std::string::npos) << once;
  EXPECT_EQ(text_at(1s), "");
  const std::string again = text_at(10s);
  EXPECT_NE(again.find("read 0.6 s late, 2 times: more events"), std::string::npos) << again;
}

TEST(LiveDetector, IgnoresAFewLateEvents) {
  Live live;
  live.play_with_late_packets_each(500'000);
  EXPECT_GT(live.detector.counts().late_events, 3U);
  for (const DetectionFault& fault : live.faults) EXPECT_EQ(fault.kind, "long packets") << fault.text;
  EXPECT_FALSE(live.reported.at(5).incomplete) << "none was late yet";
}

TEST(LiveDetector, LeavesOutLateEventsAndCountsThem) {
  Live live;
  for (std::int64_t t = 0; t <= 10'000; t += 500) live.take({t}, base + t);
  for (std::int64_t now = 10'000; now <= 20'000; now += 100) live.report_all(base + now);
  const std::size_t before = live.reported.size();
  ASSERT_EQ(before, 5U) << "10 ms by an event, 12 to 18 ms by the host's time";
  const CameraTime last = live.reported.back().verdict.t;
  live.take({us_of(last) - 500, us_of(last) - 1, us_of(last), us_of(last) + 2'500}, base + 20'100);
  EXPECT_EQ(live.detector.counts().late_events, 2U);
  live.report_all(base + 20'100);
  ASSERT_EQ(live.reported.size(), before + 1);
  EXPECT_EQ(live.reported.back().verdict.t, after(last, 2ms));
  EXPECT_EQ(live.reported.back().verdict.events, 2U) << "those at 10 and 18 ms";
}

TEST(LiveDetector, RestartsWhenTheCameraJumpsAhead) {
  Live live;
  for (std::int64_t t = 0; t <= 20'000; t += 500) live.take({t}, base + t), live.report_all(base + t);
  const std::size_t before = live.reported.size();
  for (std::int64_t t = 3'600'000'000; t <= 3'600'012'000; t += 500) {
    const std::int64_t now = base + 20'500 + t - 3'600'000'000;
    live.take({t}, now), live.report_all(now);
  }
  ASSERT_EQ(live.faults.size(), 1U);
  EXPECT_EQ(live.faults[0].kind, "jump");
  EXPECT_NE(live.faults[0].text.find("3599.9"), std::string::npos) << live.faults[0].text;
  EXPECT_EQ(live.forgotten, 1);
  ASSERT_EQ(live.reported.size(), before + 2);
  EXPECT_EQ(live.reported[before].verdict.t, camera_time(3'600'010'000)) << "a whole history after the restart";
  EXPECT_EQ(live.reported[before].beginning, 1U);
  EXPECT_EQ(live.reported[before].verdict.events, 20U);
}

TEST(LiveDetector, NeverMixesEventsOfTwoOpenings) {
  Live live;
  // A clock of 31 bits begins again, as another opening of the source.
  constexpr std::int64_t end = std::int64_t{1} << 31;
  for (std::int64_t t = end - 20'000; t < end; t += 500) live.take({t}, base + t), live.report_all(base + t);
  const std::size_t before = live.reported.size();
  ASSERT_GE(before, 3U);
  live.take({}, base + end, 1);
  live.report_all(base + end + 100'000);
  EXPECT_EQ(live.reported.size(), before) << "while the source is gone nothing is known";
  for (std::int64_t t = 0; t <= 12'000; t += 500)
    live.take({t}, base + end + 200'000 + t, 2), live.report_all(base + end + 200'000 + t);
  ASSERT_EQ(live.reported.size(), before + 2);
  EXPECT_EQ(live.reported[before].verdict.t, camera_time(10'000));
  EXPECT_EQ(live.reported[before].verdict.events, 20U) << "of the new clock alone";
  EXPECT_EQ(live.detector.counts().late_events, 0U);
}

TEST(LiveDetector, RestartsWhenAllEventsAreLate) {
  Live live;
  for (std::int64_t t = 0; t <= 20'000; t += 500) live.take({t}, base + t), live.report_all(base + t);
  // From here on the stream is 5 s late, for good.
  for (std::int64_t now = 20'000; now < 5'000'000; now += 10'000) live.report_all(base + now);
  const std::size_t before = live.reported.size();
  for (std::int64_t t = 20'500; t <= 700'000; t += 500)
    live.take({t}, base + t + 5'000'000), live.report_all(base + t + 5'000'000);
  ASSERT_GE(live.faults.size(), 1U);
  EXPECT_EQ(live.faults.back().kind, "late");
  EXPECT_GT(live.detector.counts().late_events, 900U);
  ASSERT_GT(live.reported.size(), before);
  EXPECT_TRUE(live.reported.back().due.by_events) << "on time again";
  EXPECT_EQ(live.reported.back().verdict.events, 20U);
}

TEST(LiveDetector, ReportsAStreamThatIsSlowerThanTheHost) {
  Live live;
  for (std::int64_t now = 0; now <= 30'000'000; now += 1'000) live.take({now / 2}, base + now), live.report_all(base + now);
  std::vector<std::string> texts;
  std::size_t times = 0;
  for (const DetectionFault& fault : live.faults) {
    if (fault.kind != "late") continue;
    ++times;
    if (!fault.text.empty()) texts.push_back(fault.text);
  }
  EXPECT_GT(times, 20U) << "each is counted";
  ASSERT_EQ(texts.size(), 3U) << "and reported once in ten seconds";
  EXPECT_NE(texts[0].find("the stream's delay has grown"), std::string::npos) << texts[0];
  EXPECT_NE(texts[1].find("the stream's time runs slower than ours"), std::string::npos) << texts[1];
}

/// 4 s of packets of 0.5 ms that are read at 0.8 of the pace at which they were sent: another one always waits. Ticks are
/// reported after each `several` of them.
void read_too_slowly(Live& live, std::int64_t several) {
  for (std::int64_t t = 0; t <= 4'000'000; t += 500) {
    const std::int64_t now = base + t * 5 / 4;
    live.take_of_several({t}, now);
    while (t / 500 % several == 0 && live.detector.report_due(host_time(now), HostTime{})) {
    }
  }
}

TEST(LiveDetector, CountsATickAsMissedIfItsEventsWereReadLate) {
  Live live;
  read_too_slowly(live, 8);
  const DeadlineMonitor::Counts& counts = live.detector.deadlines().counts();
  EXPECT_GT(counts.missed_share(), 0.9);
  EXPECT_GT(counts.skipped, 0U) << "the newest closed tick is reported";
  EXPECT_GT(live.detector.deadlines().queued().max(), 400ms) << "they waited for us";
  EXPECT_LT(live.detector.deadlines().waiting().percentile(1), 2'200us) << "and not for the sender";
}

TEST(LiveDetector, DropsWaitingPacketsWhenItCannotKeepUp) {
  Live live;
  read_too_slowly(live, 1);
  ASSERT_EQ(live.faults.size(), 1U);
  EXPECT_EQ(live.faults[0].kind, "behind");
  EXPECT_NE(live.faults[0].text.find("read 0.5 s late"), std::string::npos) << live.faults[0].text;
  EXPECT_EQ(live.forgotten, 1);
  const std::size_t before = live.reported.size();
  ASSERT_GT(before, 10U);
  EXPECT_LT(live.reported.back().verdict.t, camera_time(2'100'000)) << "the delay reaches 0.5 s after 2.5 s";
  const std::uint64_t counted = live.detector.counts().events;
  EXPECT_EQ(live.detector.counts().lost_events, 8'001 - counted) << "dropped and counted";

  live.take({4'000'500}, base + 5'001'000);  // the last one that waited
  for (std::int64_t t = 4'001'000; t <= 4'030'000; t += 500)
    live.take({t}, base + 1'000'500 + t), live.report_all(base + 1'000'500 + t);
  ASSERT_GT(live.reported.size(), before);
  EXPECT_EQ(live.reported[before].verdict.t, camera_time(4'012'000)) << "a whole history of what was not dropped";
  EXPECT_EQ(live.reported[before].verdict.events, 20U);
  EXPECT_EQ(live.reported[before].beginning, 1U);
  EXPECT_EQ(live.detector.counts().lost_events, 8'002 - counted);
}

TEST(LiveDetector, ReportsAgainThatItCannotKeepUp) {
  Live live;
  for (std::int64_t t = 0; t <= 30'000'000; t += 10'000) {
    live.take_of_several({t / 2}, base + t);
    live.detector.report_due(host_time(base + t), HostTime{});
  }
  ASSERT_EQ(live.faults.size(), 3U) << "at 1 s, 11 s and 21 s";
  EXPECT_EQ(live.faults[2].kind, "behind");
  EXPECT_NE(live.faults[2].text.find("more events arrive than can be read"), std::string::npos) << live.faults[2].text;
}

TEST(LiveDetector, NeverMixesEventsOfAClockOf31BitsThatStartedAgain) {
  // A source that reconnects reports it. Otherwise such events are late until the stream restarts.
  constexpr std::int64_t end = std::int64_t{1} << 31;
  Live live;
  std::int64_t now = base;
  const auto play = [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t t = from; t < to; t += 500, now += 500) live.take({t}, now), live.report_all(now);
  };
  play(end - 50'000, end);
  const std::size_t before = live.reported.size();
  ASSERT_GT(before, 10U);
  play(0, 700'000);
  ASSERT_EQ(live.faults.size(), 1U);
  EXPECT_EQ(live.faults[0].kind, "late");
  EXPECT_EQ(live.forgotten, 1);
  ASSERT_GT(live.reported.size(), before);
  for (std::size_t i = before; i < live.reported.size(); ++i) {
    const TickVerdict& verdict = live.reported[i].verdict;
    const bool is_old = live.reported[i].beginning == 0;
    EXPECT_EQ(is_old, verdict.t > camera_time(end - 50'000)) << i;
    EXPECT_LE(verdict.events, 20U) << "of one history alone";
    if (!is_old) {
      EXPECT_EQ(verdict.events, 20U) << us_of(verdict.t);
    }
  }
  EXPECT_EQ(live.reported.back().beginning, 1U);
}

/// What a stopped process finds when it resumes: packets that came long ago, one at a look. One came each second, so that what a
/// busy machine takes to read them all is nothing beside it.
struct WaitingPackets final : PacketSupply {
  bool next(capture::PacketQueue::Packet& packet, microseconds /*patience*/, microseconds /*rest*/) override {
    if (given == 3'000) return false;
    packet.clear();
    packet.emplace_back();
    packet.front().arrived = begun - 3'000s + given * 1s;
    packet.front().elements.arrived = packet.front().arrived;
    packet.front().elements.more_came = more_came;
    packet.front().elements.events.resize(1);
    packet.front().elements.events[0].t = camera_time(1'000'000 * given++);
    return true;
  }
  void give_back(capture::PacketQueue::Packet /*packet*/) override {}
  std::uint64_t lost_events() const override { return 0; }
  bool more_came = false;
  HostTime begun = host_now();
  std::int64_t given = 0;
};

TEST(LiveDetector, ReportsNoSilenceDuringABacklog) {
  for (const bool more_came : {false, true}) {
    std::uint64_t reported = 0;
    std::string faults;
    const heatmaps::HeatmapOptions rendering{.history = 10s, .tick = 2s};
    LiveDetector detector(
        {model_of(slip_where_anything_is, rendering), {.rendering = rendering}},
        {.clock = {.tick = 2s, .history = 10s, .slack = 2s},
         .silence = 2'000s,
         .jump = 1'000s,
         .late_for = 500s,
         .longest_lateness = 500s,
         .stopped_for = 500s},
        [&](const ReportedTick&) { ++reported; }, [&](const DetectionFault& fault) { faults += fault.text + "\n"; });
    WaitingPackets backlog;
    backlog.more_came = more_came;
    detector.run(backlog, [] { return false; });
    EXPECT_EQ(backlog.given, 3'000);
    EXPECT_EQ(faults, "");
    EXPECT_EQ(detector.counts().late_events, 0U);
    EXPECT_GT(reported, 0U);
  }
}

TEST(LiveDetector, TreatsTheBacklogOfAStallAsLateAndNotAsAJump) {
  Live live;
  for (std::int64_t t = 0; t <= 20'000; t += 500) live.take({t}, base + t), live.report_all(base + t);
  for (std::int64_t now = 20'500; now <= 3'020'000; now += 500) live.report_all(base + now);  // 3 s of nothing
  const CameraTime last = live.reported.back().verdict.t;
  EXPECT_GE(last, camera_time(3'010'000));
  for (std::int64_t t = 20'500; t <= 3'000'000; t += 500) live.take({t}, base + 3'020'000), live.report_all(base + 3'020'000);
  for (std::int64_t t = 3'020'500; t <= 3'100'000; t += 500) live.take({t}, base + t), live.report_all(base + t);
  for (const DetectionFault& fault : live.faults) EXPECT_TRUE(fault.kind == "late events") << fault.text;
  EXPECT_EQ(live.detector.counts().beginnings, 0U);
  for (std::size_t i = 1; i < live.reported.size(); ++i) EXPECT_GT(live.reported[i].verdict.t, live.reported[i - 1].verdict.t);
  EXPECT_GE(live.reported.back().verdict.t, camera_time(3'098'000)) << "verdicts continue with the events that are in time";
}

TEST(LiveDetector, RestartsAfterItWasStopped) {
  Live live;
  for (std::int64_t t = 0; t <= 20'000; t += 500) live.take({t}, base + t), live.report_all(base + t);
  live.detector.check_stop(host_time(base + 22'000), host_time(base + 500'000));
  EXPECT_EQ(live.faults.size(), 0U);
  live.detector.check_stop(host_time(base + 22'000), host_time(base + 3'022'000));
  ASSERT_EQ(live.faults.size(), 1U);
  EXPECT_EQ(live.faults[0].kind, "stopped");
  EXPECT_NE(live.faults[0].text.find("3.0 s"), std::string::npos) << live.faults[0].text;
  EXPECT_EQ(live.detector.counts().beginnings, 1U);
  live.detector.check_stop(host_time(base + 22'000), host_time(base + 3'022'000));
  EXPECT_EQ(live.faults.size(), 1U) << "nothing is known that could be forgotten";
  for (std::int64_t t = 20'500; t <= 40'000; t += 500)
    live.take({t}, base + 3'000'000 + t), live.report_all(base + 3'000'000 + t);
  EXPECT_EQ(live.reported.back().verdict.t, camera_time(40'000));
  EXPECT_EQ(live.faults.size(), 1U);
}

TEST(LiveDetector, RestartsOnceWhenASourceIsLostAndBack) {
  Live live;
  for (std::int64_t t = 0; t <= 20'000; t += 500) live.take({t}, base + t), live.report_all(base + t);
  live.take({}, base + 30'000, 1);
  live.take({}, base + 40'000, 2);
  live.take({1'000}, base + 41'000, 2);
  EXPECT_EQ(live.detector.counts().beginnings, 1U);
  EXPECT_EQ(live.forgotten, 1);
}

}  // namespace
}  // namespace tactile::detect
