#include "tactile/detect/live_detector.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <thread>

#include "support/comes_true.hpp"
#include "support/error_of.hpp"
#include "tactile/core/host_clock.hpp"
#include "tactile/heatmaps/run_heatmaps.hpp"

namespace tactile {
namespace {

constexpr SensorSize sensor{50, 50}, input{10, 10};
constexpr std::int64_t base = 1'700'000'000'000'000;

HostTime host_time(std::int64_t us) { return HostTime{microseconds{us}}; }

/// A network that says slip of a heatmap with anything in it.
Logits slip_where_anything_is(std::span<const std::uint8_t> heatmap) {
  for (const std::uint8_t cell : heatmap) {
    if (cell != 0) return {0, 0, 1};
  }
  return {1, 0, 0};
}

/// What is put into a queue.
struct Queued final : PacketSupply {
  explicit Queued(PacketQueue& from) : queue(from) {}
  bool next(PacketQueue::Packet& packet, microseconds patience, microseconds rest) override {
    EXPECT_LE(rest, patience);
    return queue.pop(packet, patience);
  }
  void give_back(PacketQueue::Packet packet) override { queue.give_back(std::move(packet)); }
  std::uint64_t lost_events() const override { return 0; }
  PacketQueue& queue;
};

struct Live {
  std::vector<ToldTick> told;
  std::vector<DetectionFault> faults;
  int forgotten = 0;
  bool more_came = false;
  LiveDetector detector;

  explicit Live(bool plays = false, std::optional<std::uint64_t> gate = {}, Confirmation confirmation = {},
                microseconds play_for = microseconds::max())
      : detector(
            {sensor,
             input,
             slip_where_anything_is,
             {.rendering = {.history = 10ms, .tick = 2ms}, .confirmation = confirmation, .gate = gate}},
            {.clock = {.tick = 2ms, .history = 10ms, .slack = 2ms, .by_events_alone = plays}, .play_for = play_for},
            [this](const ToldTick& tick) { told.push_back(tick); },
            [this](const DetectionFault& fault) { faults.push_back(fault); }, [this] { ++forgotten; }) {}

  void take(std::vector<std::int64_t> times, std::int64_t arrived, std::size_t source_index = 0, bool is_exact = false) {
    QueuedPacket packet{.source_index = source_index, .arrived = host_time(arrived), .elements = {}};
    if (is_exact) packet.elements.arrived = packet.arrived;
    packet.elements.more_came = more_came;
    for (const std::int64_t t : times) {
      Event event;
      event.t = camera_time(t);
      event.x = static_cast<std::int16_t>((t / 100 % 50 + 50) % 50);
      packet.elements.events.push_back(event);
    }
    detector.take(packet);
  }
  /// Read from a connection on which more waits.
  void take_of_several(std::vector<std::int64_t> times, std::int64_t arrived) {
    more_came = true;
    take(std::move(times), arrived, 0, true);
    more_came = false;
  }
  /// 3 s of packets of 0.5 ms, told of as they come; each `often` another one comes that begins 5 ms late, behind its tick.
  void play_with_late_packets_each(std::int64_t often) {
    for (std::int64_t t = 0; t <= 3'000'000; t += 500) {
      take({t}, base + t);
      tell_all(base + t);
      if (t % often == 0 && t > 20'000) take({t - 5'000, t}, base + t), tell_all(base + t);
    }
  }
  void tell_all(std::int64_t now) {
    while (detector.tell_due(host_time(now))) {
    }
  }
};

TEST(LiveDetector, TellsEachTickOnceAnEventAtOrBehindItIsHere) {
  Live live;
  for (std::int64_t t = 0; t <= 14'000; t += 1'000) {
    live.take({t}, base + t + 300);
    live.tell_all(base + t + 300);
  }
  ASSERT_EQ(live.told.size(), 3U);
  EXPECT_EQ(live.told[0].verdict.t, camera_time(10'000));
  EXPECT_EQ(live.told[0].verdict.events, 10U);
  EXPECT_EQ(live.told[0].verdict.verdict, Touch::slip);
  EXPECT_TRUE(live.told[0].due.by_events);
  EXPECT_EQ(live.told[2].verdict.t, camera_time(14'000));
  EXPECT_EQ(live.detector.deadlines().counts().skipped, 0U);
}

TEST(LiveDetector, GoesOnInSilenceUntilNothingIsLeftInTheHistory) {
  Live live;
  for (std::int64_t t = 0; t <= 10'000; t += 500) live.take({t}, base + t);
  for (std::int64_t now = 10'000; now <= 40'000; now += 100) live.tell_all(base + now);
  ASSERT_GE(live.told.size(), 13U);
  for (std::size_t i = 0; i < live.told.size(); ++i)
    EXPECT_EQ(live.told[i].verdict.t, camera_time(10'000 + 2'000 * static_cast<std::int64_t>(i)));
  EXPECT_EQ(live.told[1].due.by_events, false);
  EXPECT_EQ(live.told.back().verdict.verdict, Touch::none);
  EXPECT_EQ(live.told.back().verdict.events, 0U);
  EXPECT_EQ(live.detector.deadlines().counts().skipped, 0U);
  live.detector.look_for_silence(host_time(base + 3'000'000));
  live.detector.look_for_silence(host_time(base + 3'100'000));
  ASSERT_EQ(live.faults.size(), 1U) << "said once";
  EXPECT_EQ(live.faults[0].kind, "silence");
}

TEST(LiveDetector, SaysWhereManyEventsComeTooLate) {
  Live live;
  live.play_with_late_packets_each(5'000);
  const auto count = std::count_if(live.faults.begin(), live.faults.end(),
                                   [](const DetectionFault& fault) { return fault.kind == "late events"; });
  ASSERT_EQ(count, 1) << "in three seconds";
  EXPECT_NE(live.faults.back().text.find("--slack-us"), std::string::npos) << live.faults.back().text;
  EXPECT_NE(live.faults.back().text.find("up to 5.0 ms before"), std::string::npos) << live.faults.back().text;
  EXPECT_TRUE(live.told.back().incomplete);
}

TEST(LiveDetector, SaysNothingOfAFewLateEvents) {
  Live live;
  live.play_with_late_packets_each(500'000);
  EXPECT_GT(live.detector.counts().late_events, 3U);
  for (const DetectionFault& fault : live.faults) EXPECT_EQ(fault.kind, "long packets") << fault.text;
  EXPECT_FALSE(live.told.at(5).incomplete) << "none was late yet";
}

TEST(LiveDetector, EndsWhereWhatIsPlayedHasLastedLongEnough) {
  Live live(true, {}, {}, 20ms);
  std::vector<std::int64_t> times;
  for (std::int64_t t = 0; t <= 100'000; t += 500) times.push_back(t);
  live.take(times, base);
  ASSERT_EQ(live.told.size(), 10U) << "at 10 to 28 ms";
  EXPECT_EQ(live.told.back().verdict.t, camera_time(28'000));
  EXPECT_EQ(live.detector.deadlines().counts().told, 10U) << "none is counted that is not told";
  live.take({200'000}, base);
  live.tell_all(base);
  EXPECT_EQ(live.told.size(), 10U);
}

constexpr std::int64_t a_year = 365LL * 24 * 3'600 * 1'000'000;

TEST(LiveDetector, RefusesWhatIsPlayedWhereATimeLiesAYearAhead) {
  Live live(true);
  std::vector<std::int64_t> times;
  for (std::int64_t t = 0; t <= 20'000; t += 500) times.push_back(t);
  live.take(times, base);
  EXPECT_EQ(live.told.size(), 6U) << "at 10 to 20 ms";
  const std::string refused = test::error_of([&] { live.take({a_year}, base); });
  EXPECT_NE(refused.find("ticks of 2000 us from the first event to the last; expected at most 100000000"), std::string::npos)
      << refused;
  EXPECT_EQ(live.told.size(), 6U);
  std::vector<Event> events(2);
  events[1].t = camera_time(a_year);
  EXPECT_NE(test::error_of([&] { for_every_tick(events, sensor, {.history = 10ms, .tick = 2ms}, {}); }).find("expected at most"),
            std::string::npos)
      << "as whoever looks at whole recordings does";
}

TEST(LiveDetector, PlaysAPieceOfWhatHasATimeAYearAhead) {
  Live live(true, {}, {}, 20ms);
  live.take({0, 500, a_year}, base);
  EXPECT_EQ(live.told.size(), 10U) << "at 10 to 28 ms";
  EXPECT_EQ(live.told.back().verdict.t, camera_time(28'000));
}

TEST(LiveDetector, StopsAmidTheTicksThatOneEventCloses) {
  Live live(true);
  PacketQueue queue(std::size_t{1} << 20);
  PacketQueue::Packet packet = queue.take();
  packet.front().arrived = host_time(base);
  packet.front().elements.events.resize(2);
  packet.front().elements.events[1].t = camera_time(100'000'000'000);  // 50 million ticks
  ASSERT_TRUE(queue.push(packet, true));
  Queued queued(queue);
  live.detector.run(queued, [&] { return live.told.size() >= 100; });
  EXPECT_GE(live.told.size(), 100U);
  EXPECT_LE(live.told.size(), 101U) << "one that is due may follow";
}

TEST(LiveDetector, CountsEventsThatComeTooLateAndLeavesThemOut) {
  Live live;
  for (std::int64_t t = 0; t <= 10'000; t += 500) live.take({t}, base + t);
  for (std::int64_t now = 10'000; now <= 20'000; now += 100) live.tell_all(base + now);
  const std::size_t before = live.told.size();
  ASSERT_EQ(before, 5U) << "10 ms by an event, 12 to 18 ms by the host's time";
  const CameraTime last = live.told.back().verdict.t;
  live.take({us_of(last) - 500, us_of(last) - 1, us_of(last), us_of(last) + 2'500}, base + 20'100);
  EXPECT_EQ(live.detector.counts().late_events, 2U);
  live.tell_all(base + 20'100);
  ASSERT_EQ(live.told.size(), before + 1);
  EXPECT_EQ(live.told.back().verdict.t, after(last, 2ms));
  EXPECT_EQ(live.told.back().verdict.events, 2U) << "those at 10 and 18 ms";
}

TEST(LiveDetector, SkipsToTheNewestTickWhenItIsLateAndCountsTheRest) {
  Live live;
  for (std::int64_t t = 0; t <= 50'000; t += 500) live.take({t}, base + t);
  live.tell_all(base + 50'100);  // far behind
  ASSERT_EQ(live.told.size(), 1U);
  EXPECT_EQ(live.told[0].verdict.t, camera_time(50'000));
  EXPECT_EQ(live.told[0].due.skipped, 20U);
  EXPECT_EQ(live.detector.deadlines().counts().skipped, 20U);
  EXPECT_EQ(live.told[0].verdict.events, 20U) << "all events of the history, those of skipped ticks too";
}

TEST(LiveDetector, BeginsAnewWhereTheCameraJumpsAhead) {
  Live live;
  for (std::int64_t t = 0; t <= 20'000; t += 500) live.take({t}, base + t), live.tell_all(base + t);
  const std::size_t before = live.told.size();
  for (std::int64_t t = 3'600'000'000; t <= 3'600'012'000; t += 500) {
    const std::int64_t now = base + 20'500 + t - 3'600'000'000;
    live.take({t}, now), live.tell_all(now);
  }
  ASSERT_EQ(live.faults.size(), 1U);
  EXPECT_EQ(live.faults[0].kind, "jump");
  EXPECT_NE(live.faults[0].text.find("3599.9"), std::string::npos) << live.faults[0].text;
  EXPECT_EQ(live.forgotten, 1);
  ASSERT_EQ(live.told.size(), before + 2);
  EXPECT_EQ(live.told[before].verdict.t, camera_time(3'600'010'000)) << "a whole history after it began anew";
  EXPECT_EQ(live.told[before].beginning, 1U);
  EXPECT_EQ(live.told[before].verdict.events, 20U);
}

TEST(LiveDetector, NeverMixesEventsOfTwoOpenings) {
  Live live;
  // A clock of 31 bits begins again, as another opening of the source.
  constexpr std::int64_t end = std::int64_t{1} << 31;
  for (std::int64_t t = end - 20'000; t < end; t += 500) live.take({t}, base + t), live.tell_all(base + t);
  const std::size_t before = live.told.size();
  ASSERT_GE(before, 3U);
  live.take({}, base + end, 1);
  live.tell_all(base + end + 100'000);
  EXPECT_EQ(live.told.size(), before) << "while the source is gone nothing is known";
  for (std::int64_t t = 0; t <= 12'000; t += 500)
    live.take({t}, base + end + 200'000 + t, 2), live.tell_all(base + end + 200'000 + t);
  ASSERT_EQ(live.told.size(), before + 2);
  EXPECT_EQ(live.told[before].verdict.t, camera_time(10'000));
  EXPECT_EQ(live.told[before].verdict.events, 20U) << "of the new clock alone";
  EXPECT_EQ(live.detector.counts().late_events, 0U);
}

TEST(LiveDetector, BeginsAnewWhereEverythingComesTooLateForLong) {
  Live live;
  for (std::int64_t t = 0; t <= 20'000; t += 500) live.take({t}, base + t), live.tell_all(base + t);
  // From here on the stream is 5 s late, for good.
  for (std::int64_t now = 20'000; now < 5'000'000; now += 10'000) live.tell_all(base + now);
  const std::size_t before = live.told.size();
  for (std::int64_t t = 20'500; t <= 700'000; t += 500) live.take({t}, base + t + 5'000'000), live.tell_all(base + t + 5'000'000);
  ASSERT_GE(live.faults.size(), 1U);
  EXPECT_EQ(live.faults.back().kind, "late");
  EXPECT_GT(live.detector.counts().late_events, 900U);
  ASSERT_GT(live.told.size(), before);
  EXPECT_TRUE(live.told.back().due.by_events) << "on time again";
  EXPECT_EQ(live.told.back().verdict.events, 20U);
}

TEST(LiveDetector, NamesAStreamThatRunsSlowerThanTheHost) {
  Live live;
  for (std::int64_t now = 0; now <= 30'000'000; now += 1'000) live.take({now / 2}, base + now), live.tell_all(base + now);
  std::vector<std::string> said;
  std::size_t times = 0;
  for (const DetectionFault& fault : live.faults) {
    if (fault.kind != "late") continue;
    ++times;
    if (!fault.text.empty()) said.push_back(fault.text);
  }
  EXPECT_GT(times, 20U) << "each is counted";
  ASSERT_EQ(said.size(), 3U) << "and one in ten seconds is said";
  EXPECT_NE(said[0].find("the stream's delay has grown"), std::string::npos) << said[0];
  EXPECT_NE(said[1].find("its time runs slower than ours"), std::string::npos) << said[1];
}

/// 4 s of packets of 0.5 ms that are read at 0.8 of the pace at which they were sent: another one always waits. Ticks are told
/// after each `several` of them.
void read_too_slowly(Live& live, std::int64_t several) {
  for (std::int64_t t = 0; t <= 4'000'000; t += 500) {
    const std::int64_t now = base + t * 5 / 4;
    live.take_of_several({t}, now);
    while (t / 500 % several == 0 && live.detector.tell_due(host_time(now), HostTime{})) {
    }
  }
}

TEST(LiveDetector, CountsTicksAsMissedWhoseEventsWereReadTooLate) {
  Live live;
  read_too_slowly(live, 8);
  const DeadlineMonitor::Counts& counts = live.detector.deadlines().counts();
  EXPECT_GT(counts.missed_share(), 0.9);
  EXPECT_GT(counts.skipped, 0U) << "the newest of those that are closed is told";
  EXPECT_GT(live.detector.deadlines().queued().max(), 400ms) << "they waited for us";
  EXPECT_LT(live.detector.deadlines().waiting().percentile(1), 2'200us) << "and not for the sender";
}

TEST(LiveDetector, DropsWhatWaitsWhereItCannotKeepUp) {
  Live live;
  read_too_slowly(live, 1);
  ASSERT_EQ(live.faults.size(), 1U);
  EXPECT_EQ(live.faults[0].kind, "behind");
  EXPECT_NE(live.faults[0].text.find("read 0.5 s late"), std::string::npos) << live.faults[0].text;
  EXPECT_EQ(live.forgotten, 1);
  const std::size_t before = live.told.size();
  ASSERT_GT(before, 10U);
  EXPECT_LT(live.told.back().verdict.t, camera_time(2'100'000)) << "0.5 s behind comes after 2.5 s";
  const std::uint64_t counted = live.detector.counts().events;
  EXPECT_EQ(live.detector.counts().lost_events, 8'001 - counted) << "dropped, and said how many";

  live.take({4'000'500}, base + 5'001'000);  // the last one that waited
  for (std::int64_t t = 4'001'000; t <= 4'030'000; t += 500)
    live.take({t}, base + 1'000'500 + t), live.tell_all(base + 1'000'500 + t);
  ASSERT_GT(live.told.size(), before);
  EXPECT_EQ(live.told[before].verdict.t, camera_time(4'012'000)) << "a whole history of what was not dropped";
  EXPECT_EQ(live.told[before].verdict.events, 20U);
  EXPECT_EQ(live.told[before].beginning, 1U);
  EXPECT_EQ(live.detector.counts().lost_events, 8'002 - counted);
}

TEST(LiveDetector, SaysAgainThatThereIsNoCatchingUp) {
  Live live;
  for (std::int64_t t = 0; t <= 30'000'000; t += 10'000) {
    live.take_of_several({t / 2}, base + t);
    live.detector.tell_due(host_time(base + t), HostTime{});
  }
  ASSERT_EQ(live.faults.size(), 3U) << "at 1 s, 11 s and 21 s";
  EXPECT_EQ(live.faults[2].kind, "behind");
  EXPECT_NE(live.faults[2].text.find("no catching up"), std::string::npos) << live.faults[2].text;
}

TEST(LiveDetector, NeverMixesEventsOfAClockOf31BitsThatBeganAgain) {
  // A source that reconnects says so; where one hands such events over all the same, they are late, until they are a new stream.
  constexpr std::int64_t end = std::int64_t{1} << 31;
  Live live;
  std::int64_t now = base;
  const auto play = [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t t = from; t < to; t += 500, now += 500) live.take({t}, now), live.tell_all(now);
  };
  play(end - 50'000, end);
  const std::size_t before = live.told.size();
  ASSERT_GT(before, 10U);
  play(0, 700'000);
  ASSERT_EQ(live.faults.size(), 1U);
  EXPECT_EQ(live.faults[0].kind, "late");
  EXPECT_EQ(live.forgotten, 1);
  ASSERT_GT(live.told.size(), before);
  for (std::size_t i = before; i < live.told.size(); ++i) {
    const TickVerdict& verdict = live.told[i].verdict;
    const bool is_old = live.told[i].beginning == 0;
    EXPECT_EQ(is_old, verdict.t > camera_time(end - 50'000)) << i;
    EXPECT_LE(verdict.events, 20U) << "of one history alone";
    if (!is_old) {
      EXPECT_EQ(verdict.events, 20U) << us_of(verdict.t);
    }
  }
  EXPECT_EQ(live.told.back().beginning, 1U);
}

TEST(LiveDetector, WarnsOfPacketsLongerThanATickOnce) {
  Live live;
  live.take({0, 1'999}, base + 2'000);
  EXPECT_TRUE(live.faults.empty());
  live.take({2'000, 9'000}, base + 9'000);
  live.take({9'500, 19'000}, base + 19'000);
  ASSERT_EQ(live.faults.size(), 1U);
  EXPECT_EQ(live.faults[0].kind, "long packets");
}

TEST(LiveDetector, MarksVerdictsWhoseHistoryLacksEvents) {
  Live live;
  for (std::int64_t t = 0; t <= 10'000; t += 500) live.take({t}, base + t), live.tell_all(base + t);
  EXPECT_FALSE(live.told.back().incomplete);
  live.detector.note_lost(7);
  for (std::int64_t t = 11'000; t <= 30'000; t += 500) live.take({t}, base + t), live.tell_all(base + t);
  EXPECT_EQ(live.detector.counts().lost_events, 7U);
  for (const ToldTick& tick : live.told)
    EXPECT_EQ(tick.incomplete, tick.verdict.t > camera_time(11'000) && tick.verdict.t < camera_time(21'000))
        << us_of(tick.verdict.t);
}

TEST(LiveDetector, GatesQuietTicksWithoutAskingTheNetwork) {
  Live live(false, 5);
  for (std::int64_t t = 0; t <= 20'000; t += t < 10'000 ? 2'500 : 500) live.take({t}, base + t), live.tell_all(base + t);
  ASSERT_GE(live.told.size(), 3U);
  EXPECT_EQ(live.told[0].verdict.events, 4U);
  EXPECT_TRUE(live.told[0].verdict.gated);
  EXPECT_EQ(live.told[0].verdict.verdict, Touch::none);
  EXPECT_EQ(live.told[0].verdict.probabilities, (Probabilities{1, 0, 0}));
  EXPECT_FALSE(live.told[1].verdict.gated) << live.told[1].verdict.events;
  EXPECT_EQ(live.told[1].verdict.verdict, Touch::slip);
  EXPECT_EQ(live.detector.counts().gated, 1U);
}

TEST(LiveDetector, CountsSkippedTicksAsNoneWhereVerdictsAreConfirmed) {
  Live live(false, {}, {2, 3});
  for (std::int64_t t = 0; t <= 12'000; t += 500) live.take({t}, base + t), live.tell_all(base + t);
  ASSERT_EQ(live.told.size(), 2U);
  EXPECT_EQ(live.told[0].verdict.verdict, Touch::none);
  EXPECT_EQ(live.told[1].verdict.verdict, Touch::slip);
  for (std::int64_t t = 12'500; t <= 40'000; t += 500) live.take({t}, base + t);
  live.tell_all(base + 40'000);
  EXPECT_EQ(live.told.back().verdict.said, Touch::slip);
  EXPECT_EQ(live.told.back().verdict.verdict, Touch::none);
}

TEST(LiveDetector, TellsEveryTickOfWhatIsPlayedAsARecordingHasThem) {
  // At both ends of int64, and with a second of silence in between.
  for (const std::int64_t begin : {std::numeric_limits<std::int64_t>::min(), std::int64_t{-5'000}, std::int64_t{1} << 31,
                                   std::numeric_limits<std::int64_t>::max() - 1'200'000}) {
    std::vector<std::int64_t> times;
    for (std::int64_t t = 0; t <= 30'000; t += 70) times.push_back(begin + t);
    for (std::int64_t t = 1'100'000; t <= 1'130'000; t += 70) times.push_back(begin + t);
    std::vector<Event> events;
    for (const std::int64_t t : times) {
      Event event;
      event.t = camera_time(t);
      events.push_back(event);
    }
    std::vector<std::pair<CameraTime, std::uint64_t>> offline;
    for_every_tick(events, sensor, {.history = 10ms, .tick = 2ms},
                   [&](CameraTime t, std::span<const std::uint8_t>, std::uint64_t count) { offline.emplace_back(t, count); });
    Live live(true);
    for (std::size_t i = 0; i < times.size(); i += 37)
      live.take({times.begin() + static_cast<std::ptrdiff_t>(i),
                 times.begin() + static_cast<std::ptrdiff_t>(std::min(times.size(), i + 37))},
                base);
    ASSERT_EQ(live.told.size(), offline.size()) << begin;
    for (std::size_t i = 0; i < offline.size(); ++i) {
      EXPECT_EQ(live.told[i].verdict.t, offline[i].first);
      EXPECT_EQ(live.told[i].verdict.events, offline[i].second);
    }
    EXPECT_EQ(live.detector.deadlines().counts().skipped, 0U);
  }
}

TEST(LiveDetector, IsWokenOnlyByWhatClosesATickOrIsMuchToCount) {
  // Ticks of 1000 s, so that none closes by the host's time meanwhile, however busy it is.
  constexpr std::int64_t tick = 1'000'000'000;
  std::vector<ToldTick> told;
  LiveDetector detector(
      {sensor, input, slip_where_anything_is, {.rendering = {.history = 1000s, .tick = 1000s}}},
      {.clock = {.tick = 1000s, .history = 1000s, .slack = 2ms}, .jump = 10'000s, .stopped_for = 10'000s},
      [&told](const ToldTick& each) { told.push_back(each); }, [](const DetectionFault&) {});
  const auto events_at = [](std::int64_t t, std::size_t count) {
    Event event;
    event.t = camera_time(t);
    return std::vector<Event>(count, event);
  };
  PacketQueue queue(1U << 20U);
  const auto push = [&](std::int64_t t, bool wakes) {
    PacketQueue::Packet packet = queue.take();
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
  EXPECT_TRUE(detector.awaits({})) << "the stream may begin anew";
  EXPECT_TRUE(push(tick - 1, false)) << "it lies there until the next one";
  EXPECT_TRUE(push(tick, true));
  EXPECT_TRUE(test::comes_true([&] { return !detector.awaits(events_at(2 * tick - 1, 1)); }));
  queue.close();
  running.join();
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].verdict.t, camera_time(tick));
  EXPECT_EQ(told[0].verdict.events, 2U);
}

/// Packets of 1 ms whose last event comes 0.1 to 0.2 ms after it happened; those that close a tick bring `events` of them.
void play_quietly(Live& live, std::int64_t from_ms, std::int64_t to_ms, bool is_exact, std::size_t events = 2) {
  for (std::int64_t ms = from_ms; ms < to_ms; ++ms) {
    const std::int64_t last = 1'000 * ms + 900, at = base + last + 100 + 10 * (ms / 2 % 11);
    std::vector<std::int64_t> times(ms % 2 == 0 ? events : 2, 1'000 * ms);
    times.back() = last;
    live.take(times, at, 0, is_exact);
    live.tell_all(at);
  }
}

TEST(LiveDetector, LetsPacketsOfAQuietStreamLieUntilTheNextTickCanClose) {
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

TEST(LiveDetector, LetsNothingLieWhoseArrivalIsNotKnown) {
  Live live;
  play_quietly(live, 0, 1'000, false);
  const HostTime now = host_time(base + 1'000'050);
  EXPECT_EQ(live.detector.rests_until(now), now) << "what is read late would seem to come late, and be read later still";
}

TEST(LiveDetector, TakesNoWaitingFromPacketsThatCameWithLaterOnes) {
  Live live;
  for (std::int64_t ms = 0; ms < 1'000; ++ms) {
    QueuedPacket packet{.source_index = 0, .arrived = host_time(base + 1'000 * ms + 1'000), .elements = {}};
    packet.elements.events.resize(1);
    packet.elements.events[0].t = camera_time(1'000 * ms);
    packet.elements.arrived = packet.arrived;
    packet.elements.more_came = true;
    live.detector.take(packet);
    live.tell_all(base + 1'000 * ms + 1'000);
  }
  const HostTime now = host_time(base + 1'000'050);
  EXPECT_EQ(live.detector.rests_until(now), now) << "how early they came is not known";
}

TEST(LiveDetector, DoesNotCloseByTheHostsTimeWhatMayStillWait) {
  Live live;
  for (std::int64_t t = 0; t <= 10'000; t += 500) live.take({t}, base + t);
  live.tell_all(base + 10'000);
  ASSERT_EQ(live.told.size(), 1U);
  // Held up for 20 ms, of which 5 have been read.
  live.take({10'500, 11'500}, base + 11'500);
  EXPECT_FALSE(live.detector.tell_due(host_time(base + 30'000), host_time(base + 11'500))) << "the tick at 12 ms";
  live.take({11'900, 15'000}, base + 15'000);
  EXPECT_TRUE(live.detector.tell_due(host_time(base + 30'000), host_time(base + 15'000)));
  EXPECT_EQ(live.told.back().verdict.t, camera_time(14'000)) << "the newest whose events are known to be here";
  EXPECT_TRUE(live.told.back().due.by_events);
  EXPECT_FALSE(live.detector.tell_due(host_time(base + 30'000), host_time(base + 15'000)));
  EXPECT_EQ(live.detector.counts().late_events, 0U);
  EXPECT_TRUE(live.detector.tell_due(host_time(base + 30'000))) << "by the host's time, once nothing waits";
  EXPECT_FALSE(live.told.back().due.by_events);
}

/// What a stopped process finds when it resumes: packets that came long ago, one at a look. One came each second, so that what a
/// busy machine takes to read them all is nothing beside it.
struct Backlog final : PacketSupply {
  bool next(PacketQueue::Packet& packet, microseconds /*patience*/, microseconds /*rest*/) override {
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
  void give_back(PacketQueue::Packet /*packet*/) override {}
  std::uint64_t lost_events() const override { return 0; }
  bool more_came = false;
  HostTime begun = host_now();
  std::int64_t given = 0;
};

TEST(LiveDetector, HearsNoSilenceInABacklog) {
  for (const bool more_came : {false, true}) {
    std::uint64_t told = 0;
    std::string faults;
    LiveDetector detector(
        {sensor, input, slip_where_anything_is, {.rendering = {.history = 10s, .tick = 2s}}},
        {.clock = {.tick = 2s, .history = 10s, .slack = 2s},
         .silence = 2'000s,
         .jump = 1'000s,
         .late_for = 500s,
         .behind_for = 500s,
         .stopped_for = 500s},
        [&](const ToldTick&) { ++told; }, [&](const DetectionFault& fault) { faults += fault.text + "\n"; });
    Backlog backlog;
    backlog.more_came = more_came;
    detector.run(backlog, [] { return false; });
    EXPECT_EQ(backlog.given, 3'000);
    EXPECT_EQ(faults, "");
    EXPECT_EQ(detector.counts().late_events, 0U);
    EXPECT_GT(told, 0U);
  }
}

TEST(LiveDetector, TakesTheBacklogOfAStallForLateAndNotForAJump) {
  Live live;
  for (std::int64_t t = 0; t <= 20'000; t += 500) live.take({t}, base + t), live.tell_all(base + t);
  for (std::int64_t now = 20'500; now <= 3'020'000; now += 500) live.tell_all(base + now);  // 3 s of nothing
  const CameraTime told = live.told.back().verdict.t;
  EXPECT_GE(told, camera_time(3'010'000));
  for (std::int64_t t = 20'500; t <= 3'000'000; t += 500) live.take({t}, base + 3'020'000), live.tell_all(base + 3'020'000);
  for (std::int64_t t = 3'020'500; t <= 3'100'000; t += 500) live.take({t}, base + t), live.tell_all(base + t);
  for (const DetectionFault& fault : live.faults) EXPECT_TRUE(fault.kind == "late events") << fault.text;
  EXPECT_EQ(live.detector.counts().beginnings, 0U);
  for (std::size_t i = 1; i < live.told.size(); ++i) EXPECT_GT(live.told[i].verdict.t, live.told[i - 1].verdict.t);
  EXPECT_GE(live.told.back().verdict.t, camera_time(3'098'000)) << "verdicts go on with what comes in time";
}

TEST(LiveDetector, SaysThatItWasStoppedAndBeginsAnew) {
  Live live;
  for (std::int64_t t = 0; t <= 20'000; t += 500) live.take({t}, base + t), live.tell_all(base + t);
  live.detector.look_for_stop(host_time(base + 22'000), host_time(base + 500'000));
  EXPECT_EQ(live.faults.size(), 0U);
  live.detector.look_for_stop(host_time(base + 22'000), host_time(base + 3'022'000));
  ASSERT_EQ(live.faults.size(), 1U);
  EXPECT_EQ(live.faults[0].kind, "stopped");
  EXPECT_NE(live.faults[0].text.find("3.0 s"), std::string::npos) << live.faults[0].text;
  EXPECT_EQ(live.detector.counts().beginnings, 1U);
  live.detector.look_for_stop(host_time(base + 22'000), host_time(base + 3'022'000));
  EXPECT_EQ(live.faults.size(), 1U) << "nothing is known that could be forgotten";
  for (std::int64_t t = 20'500; t <= 40'000; t += 500) live.take({t}, base + 3'000'000 + t), live.tell_all(base + 3'000'000 + t);
  EXPECT_EQ(live.told.back().verdict.t, camera_time(40'000));
  EXPECT_EQ(live.faults.size(), 1U);
}

TEST(LiveDetector, BeginsAnewOnceWhereASourceIsGoneAndBack) {
  Live live;
  for (std::int64_t t = 0; t <= 20'000; t += 500) live.take({t}, base + t), live.tell_all(base + t);
  live.take({}, base + 30'000, 1);
  live.take({}, base + 40'000, 2);
  live.take({1'000}, base + 41'000, 2);
  EXPECT_EQ(live.detector.counts().beginnings, 1U);
  EXPECT_EQ(live.forgotten, 1);
}

/// A detector whose network takes some ms and is seen at its work. Its times are counted in 0.1 ms: a tick is 1'000'000 of them,
/// 100 s, beside which the network takes next to nothing even where the machine is busy.
struct Rehearsing {
  std::vector<std::vector<std::uint8_t>> asked;
  std::vector<ToldTick> told;
  LiveDetector detector;

  static HostTime host_at(std::int64_t t) { return host_time(base + 100 * t); }

  explicit Rehearsing(bool rehearses, std::optional<std::uint64_t> gate = {})
      : detector(
            {sensor,
             input,
             [this](std::span<const std::uint8_t> heatmap) {
               asked.emplace_back(heatmap.begin(), heatmap.end());
               std::this_thread::sleep_for(2ms);
               return slip_where_anything_is(heatmap);
             },
             {.rendering = {.history = 100s, .tick = 100s}, .confirmation = {2, 3}, .gate = gate}},
            {.clock = {.tick = 100s, .history = 100s, .slack = 2ms}, .rehearses = rehearses},
            [this](const ToldTick& tick) { told.push_back(tick); }, [](const DetectionFault&) {}) {}

  /// Told of at once, where it closes a tick.
  void take(std::int64_t t, std::size_t count = 1) {
    QueuedPacket packet{.arrived = host_at(t), .elements = {}};
    Event event;
    event.t = camera_time(100 * t);
    event.x = static_cast<std::int16_t>(t / 100'000 % 50);
    packet.elements.events.assign(count, event);
    detector.take(packet);
    while (detector.tell_due(host_at(t))) {
    }
  }
  /// As `run` does: it looks when it said that it would. @return  whether it ever did
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

TEST(LiveDetector, RunsTheNetworkAheadOfEachTickAndSaysTheSame) {
  Rehearsing with(true), without(false);
  for (Rehearsing* each : {&with, &without}) {
    for (std::int64_t t = 0; t <= 10'000'000; t += 100'000) {
      const std::size_t told = each->told.size();
      each->take(t);
      if (each->told.size() > told) each->asked_without_rehearsals.push_back(each->asked.back());
      each->rehearse_within(t, t + 100'000);
    }
    ASSERT_EQ(each->told.size(), 10U) << "at 100 to 1000 s";
  }
  EXPECT_EQ(with.detector.counts().rehearsals, 9U) << "once between two";
  EXPECT_EQ(with.asked.size(), 19U);
  EXPECT_EQ(without.detector.counts().rehearsals, 0U);
  EXPECT_EQ(without.asked.size(), 10U);
  EXPECT_EQ(with.asked_without_rehearsals, without.asked) << "of the same heatmaps";
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(with.told[i].verdict.t, without.told[i].verdict.t);
    EXPECT_EQ(with.told[i].verdict.events, without.told[i].verdict.events);
    EXPECT_EQ(with.told[i].verdict.verdict, i == 0 ? Touch::none : Touch::slip) << "confirmed by two of three ticks told";
    EXPECT_EQ(without.told[i].verdict.verdict, with.told[i].verdict.verdict);
  }
}

TEST(LiveDetector, RehearsesNeitherTooEarlyNorWhenTheNextTickIsNear) {
  // Ahead of the next tick, in what the last one took.
  for (const auto& [ahead, times] : {std::pair{5, 0U}, {3, 1U}, {2, 0U}, {0, 0U}, {-1, 0U}}) {
    Rehearsing live(true);
    live.take(0);
    live.take(1'000'000);
    ASSERT_EQ(live.told.size(), 1U);
    const DeadlineMonitor& deadlines = live.detector.deadlines();
    const auto taken = std::chrono::duration_cast<microseconds>(deadlines.rendering().max() + deadlines.network().max());
    live.detector.rehearse(Rehearsing::host_at(2'000'000) - ahead * taken);
    EXPECT_EQ(live.detector.counts().rehearsals, times) << ahead;
    EXPECT_EQ(live.asked.size(), 1U + times) << ahead;
  }
}

TEST(LiveDetector, DoesNotRehearseWhatTheGateWouldSpare) {
  Rehearsing live(true, 5);
  live.take(0, 5);
  live.take(1'000'000, 2);
  ASSERT_EQ(live.told.size(), 1U);
  EXPECT_FALSE(live.told[0].verdict.gated);
  live.take(1'500'000);
  EXPECT_FALSE(live.rehearse_within(1'500'000, 2'000'000)) << "three events are left";
  live.take(2'000'000);
  EXPECT_TRUE(live.told.at(1).verdict.gated);
  live.take(2'500'000, 9);
  EXPECT_FALSE(live.rehearse_within(2'500'000, 3'000'000)) << "nor after a tick that it spared";
  EXPECT_EQ(live.asked.size(), 1U);
  live.take(3'000'000);
  EXPECT_FALSE(live.told.at(2).verdict.gated);
  live.take(3'500'000, 9);
  EXPECT_TRUE(live.rehearse_within(3'500'000, 4'000'000));
}

TEST(TickDetector, SaysTheSameWhatEverWasCountedAhead) {
  const TickDetectorOptions options{.rendering = {.history = 10ms, .tick = 2ms}};
  std::vector<std::vector<std::uint8_t>> heatmaps[2];
  for (const int ahead : {0, 1}) {
    auto& seen = heatmaps[ahead];
    TickDetector detector(
        sensor, input,
        [&seen](std::span<const std::uint8_t> heatmap) {
          seen.emplace_back(heatmap.begin(), heatmap.end());
          return Logits{};
        },
        options);
    std::uint32_t random = 1;
    for (std::int64_t tick = 2'000; tick <= 100'000; tick += 2'000) {
      for (std::int64_t packet = tick - 2'000; packet < tick; packet += 250) {
        std::vector<Event> events(7);
        for (std::size_t i = 0; i < events.size(); ++i) {
          random = random * 1'664'525 + 1'013'904'223;
          events[i].t = camera_time(packet + (i > 4 ? 300 : 0));  // the last ones may lie behind the tick
          events[i].x = static_cast<std::int16_t>(random >> 16U & 15U);
          events[i].y = static_cast<std::int16_t>(random >> 24U & 15U);
        }
        if (packet % 2'000 > 0) std::fill(events.begin(), events.end() - 2, events.front());
        for (Event& event : events) event.t = std::max(event.t, camera_time(packet + 50));
        detector.add(events);
        if (ahead == 1 && random % 3 != 0) detector.count_ahead(camera_time(tick));
      }
      if (tick % 6'000 == 0) continue;  // skipped: a later one is told in its place
      TickCost cost;
      detector.verdict_at(camera_time(tick), tick % 6'000 == 2'000 && tick > 2'000 ? 1 : 0, cost);
    }
  }
  ASSERT_EQ(heatmaps[0].size(), 34U);
  EXPECT_EQ(heatmaps[0], heatmaps[1]);
}

TEST(LiveDetector, RefusesAModelOfAnotherSize) {
  EXPECT_THROW(TickDetector(sensor, {12, 10}, slip_where_anything_is, {.rendering = {.history = 10ms, .tick = 2ms}}),
               std::exception);
}

}  // namespace
}  // namespace tactile
