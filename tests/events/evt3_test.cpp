#include "tactile/events/evt3.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <ctime>
#include <limits>
#include <optional>
#include <vector>

#include "events/aedat4_bytes.hpp"
#include "events/made_raw.hpp"
#include "tactile/core/random.hpp"

namespace tactile::events {
namespace {

using test::event;

using Words = std::vector<std::uint16_t>;

struct Decoded {
  std::vector<Event> events;
  std::vector<Evt3Trigger> triggers;
  Evt3Problems problems;
};

Decoded decoded(const Words& words, SensorSize size = {1280, 720}) {
  Evt3Decoder decoder(size);
  Decoded made;
  EXPECT_EQ(decoder.decode(std::as_bytes(std::span(words)), made.events, made.triggers), 2 * words.size());
  made.problems = decoder.problems();
  return made;
}
std::vector<std::int64_t> times_of(const Decoded& made) {
  std::vector<std::int64_t> times;
  for (const Event& event : made.events) times.push_back(us_of(event.t));
  return times;
}

TEST(Evt3Decoder, ReadsSingleEventsAndVectorsOfARow) {
  // Time 2 * 4096 + 5; row 7: x 3 on, x 4 off; from x 100 on: pixels 0 and 11, then 112 and 119, then 120.
  const Decoded made = decoded({0x8002, 0x6005, 0x0007, 0x2803, 0x2004, 0x3864, 0x4801, 0x5081, 0x4001});
  EXPECT_EQ(made.events,
            (std::vector<Event>{event(8197, 3, 7, 1), event(8197, 4, 7, 0), event(8197, 100, 7, 1), event(8197, 111, 7, 1),
                                event(8197, 112, 7, 1), event(8197, 119, 7, 1), event(8197, 120, 7, 1)}));
  EXPECT_EQ(made.problems, Evt3Problems{});
}

TEST(Evt3Decoder, ReadsBothEdgesOfEveryTriggerChannel) {
  const Decoded made = decoded({0x8000, 0x6009, 0xA001, 0xA600});
  EXPECT_EQ(made.triggers, (std::vector<Evt3Trigger>{{camera_time(9), 0, true}, {camera_time(9), 6, false}}));
  EXPECT_EQ(trigger_of(made.triggers[0]).type, 1);
  EXPECT_EQ(trigger_of(made.triggers[1]).type, 2);
}

TEST(Evt3Decoder, CarriesTheTimeOverItsRollOver) {
  const Decoded made = decoded({0x8FFF, 0x6FFF, 0x0000, 0x2000, 0x8000, 0x6001, 0x2000, 0x8FFF, 0x6002, 0x2000, 0x8000, 0x6003,
                                0x2000, 0x8800, 0x6000, 0x2000, 0x8000, 0x6000, 0x2000});
  constexpr std::int64_t turn = 1 << 24;
  EXPECT_EQ(times_of(made), (std::vector<std::int64_t>{turn - 1, turn + 1, turn - 4096 + 2, turn + 3,  // a step back is no turn
                                                       turn + turn / 2, 2 * turn}));
}

TEST(Evt3Decoder, TakesAStepBackOf16UpperHalvesForDisorderAnd17ForARollOver) {
  EXPECT_EQ(times_of(decoded({0x8020, 0x6000, 0x0000, 0x2000, 0x8010, 0x6000, 0x2000})),
            (std::vector<std::int64_t>{0x20000, 0x10000}));
  EXPECT_EQ(times_of(decoded({0x8020, 0x6000, 0x0000, 0x2000, 0x800F, 0x6000, 0x2000})),
            (std::vector<std::int64_t>{0x20000, 0x100F000}));
}

TEST(Evt3Decoder, StartsANewUpperHalfAtItsStart) {
  EXPECT_EQ(times_of(decoded({0x8001, 0x6FF0, 0x0000, 0x2000, 0x8001, 0x2000, 0x8002, 0x2000})),
            (std::vector<std::int64_t>{0x1FF0, 0x1FF0, 0x2000}));
}

TEST(Evt3Decoder, CountsWhatComesBeforeTimeAndRow) {
  const Decoded made = decoded({0x6001, 0x0001, 0x2001, 0xA001, 0x8001, 0x2001, 0x6002, 0x2005});
  EXPECT_EQ(made.events, std::vector<Event>{event(4098, 5, 1, 0)});
  EXPECT_EQ(made.problems, (Evt3Problems{.unplaced = 3}));
  EXPECT_EQ(decoded({0x8001, 0x6002, 0x3000, 0x4003, 0x0001, 0x4001}).problems, (Evt3Problems{.unplaced = 2}));
}

TEST(Evt3Decoder, CountsEventsOutsideTheSensorAndUnknownWords) {
  // The sensor has 110 columns: of a vector from 100, ten pixels are inside. Then a row below the sensor.
  const Decoded made = decoded(
      {0x8000, 0x6000, 0x0000, 0x3064, 0x4FFF, 0x50FF, 0x206E, 0x206D, 0x000A, 0x2000, 0x1000, 0x9000, 0xE014, 0xF000, 0x7000},
      {110, 10});
  ASSERT_EQ(made.events.size(), 11U);
  EXPECT_EQ(made.events[9], event(0, 109, 0, 0));
  EXPECT_EQ(made.problems, (Evt3Problems{.unknown_words = 2, .outside = 2 + 8 + 1 + 1}));
}

/// Words of all types in no order.
Words any_words(std::size_t count) {
  Words words{0x8000, 0x6000, 0x0000, 0x3000};
  std::uint32_t state = 1;
  while (words.size() < count) {
    state = state * 1664525 + 1013904223;
    words.push_back(static_cast<std::uint16_t>(state >> 16));
  }
  return words;
}

/// The format's description, word by word.
Decoded plainly_decoded(const Words& words, SensorSize size) {
  Decoded made;
  std::optional<std::int64_t> high;
  std::optional<std::int64_t> t;
  std::optional<int> y;
  int base = 0;
  unsigned base_on = 0;
  const auto put = [&](int x, unsigned on) {
    if (!t || !y) {
      ++made.problems.unplaced;
    } else if (x >= size.width || *y >= size.height) {
      ++made.problems.outside;
    } else {
      made.events.push_back(event(*t, x, *y, static_cast<int>(on)));
    }
  };
  for (const std::uint16_t word : words) {
    const unsigned type = word >> 12U, value = word & 0x7FFU, upper_bit = word >> 11U & 1U;
    if (type == 0) y = static_cast<int>(value);
    if (type == 2) put(static_cast<int>(value), upper_bit);
    if (type == 3) {
      base = static_cast<int>(value);
      base_on = upper_bit;
    }
    if (type == 4 || type == 5) {
      const int pixels = type == 4 ? 12 : 8;
      for (int i = 0; i < pixels; ++i) {
        if ((word >> i & 1) != 0) put(base + i, base_on);
      }
      base += pixels;
    }
    if (type == 6 && high) t = *high + (word & 0xFFF);
    if (type == 8) {
      std::int64_t next = word & 0xFFF;
      if (high) {
        next += *high >> 12 & ~std::int64_t{0xFFF};
        if (next < (*high >> 12) - 16) next += 0x1000;
        if (next > (*high >> 12) + 0x1000 - 17) next -= 0x1000;
      }
      if (t && next << 12 != *high) t = next << 12;
      high = next << 12;
    }
    if (type == 10 && t) made.triggers.push_back({camera_time(*t), static_cast<std::uint8_t>(word >> 8 & 0xF), (word & 1) != 0});
    made.problems.unplaced += type == 10 && !t ? 1 : 0;
    made.problems.unknown_words += type == 1 || type == 9 || (type > 10 && type < 14) ? 1 : 0;
  }
  return made;
}

TEST(Evt3Decoder, GivesWhatAPlainDecoderMakesOfAnyWords) {
  Random random(7);
  for (int round = 0; round < 200; ++round) {
    // Most words of a real stream are usual ones, in some streams times. The first event has no time.
    const bool is_sparse = round % 2 == 0;
    Words words{test::evt3_event(1, 5), test::evt3_time_high(5), test::evt3_time_low(6), test::evt3_row(7)};
    unsigned high = 5;
    for (int i = 0; i < 3'000; ++i) {
      constexpr std::array<unsigned, 12> dense{0, 2, 2, 2, 2, 2, 2, 3, 4, 5, 2, 6}, sparse{0, 2, 6, 8, 8, 8, 7, 14, 15, 0, 2, 6};
      const auto place = static_cast<std::size_t>(12 * random.uniform());
      const bool is_any = random.uniform() < 0.02;
      const unsigned type = is_any      ? static_cast<unsigned>(16 * random.uniform())
                            : is_sparse ? sparse.at(place)
                                        : dense.at(place);
      if (type == 8 && (is_any || random.uniform() < 0.01)) high = static_cast<unsigned>(high + 40 * random.uniform()) & 0xFFF;
      words.push_back(test::evt3_word(
          type, type == 8 ? high : static_cast<unsigned>((type == 0 && !is_any ? 490 : 4096) * random.uniform())));
    }
    const SensorSize size = round % 3 == 0 ? SensorSize{640, 480} : SensorSize{2048, 2048};
    const Decoded made = decoded(words, size), plain = plainly_decoded(words, size);
    ASSERT_EQ(made.events, plain.events) << round;
    EXPECT_EQ(made.triggers, plain.triggers) << round;
    EXPECT_EQ(made.problems, plain.problems) << round;
  }
}

/// The shortest CPU time of a decoder for one word, with events in memory that it has used before.
double ns_per_word(const Words& words) {
  double shortest = std::numeric_limits<double>::infinity();
  Decoded made;
  for (int i = 0; i < 15; ++i) {
    Evt3Decoder decoder({1280, 720});
    const std::clock_t begin = std::clock();
    for (auto rest = std::as_bytes(std::span(words)); !rest.empty();) {
      made.events.clear();
      rest = rest.subspan(decoder.decode(rest, made.events, made.triggers, 4'000));
    }
    shortest = std::min(shortest, 1e9 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
  }
  return shortest / static_cast<double>(words.size());
}

TEST(Evt3Decoder, NeedsNoMoreTimeForWordsInAnyOrderThanForOneEventAfterAnother) {
  // A camera that sees little repeats the upper half of the time between its few events. The order cannot be predicted.
  Random random(3);
  Words sparse{test::evt3_time_high(5)}, steady{test::evt3_time_high(5), test::evt3_time_low(6), test::evt3_row(7)};
  while (sparse.size() < 500'000) {
    while (random.uniform() < 0.5) sparse.push_back(test::evt3_time_high(5));
    sparse.insert(sparse.end(), {test::evt3_time_low(static_cast<unsigned>(4096 * random.uniform())),
                                 test::evt3_row(static_cast<unsigned>(700 * random.uniform())),
                                 test::evt3_event(1, static_cast<unsigned>(1200 * random.uniform()))});
  }
  while (steady.size() < 500'000) steady.push_back(test::evt3_event(1, static_cast<unsigned>(1200 * random.uniform())));
  EXPECT_LT(ns_per_word(sparse), 1.5 * ns_per_word(steady));
}

TEST(Evt3Decoder, GivesTheSameWhereverItsInputIsDivided) {
  const Words words = any_words(5'000);
  const Decoded whole = decoded(words);
  const auto bytes = std::as_bytes(std::span(words));
  for (const std::size_t piece : {1U, 2U, 3U, 7U, 1023U, 1024U}) {
    Evt3Decoder decoder({1280, 720});
    Decoded made;
    for (std::size_t at = 0; at < bytes.size(); at += piece)
      decoder.decode(bytes.subspan(at, std::min<std::size_t>(piece, bytes.size() - at)), made.events, made.triggers);
    EXPECT_EQ(made.events, whole.events) << piece;
    EXPECT_EQ(made.triggers, whole.triggers) << piece;
    EXPECT_EQ(decoder.problems(), whole.problems) << piece;
  }
}

TEST(Evt3Decoder, StopsAtTheMostEventsOrTriggersAndContinuesThere) {
  const Words words = any_words(50'000);
  const Decoded whole = decoded(words);
  auto rest = std::as_bytes(std::span(words));
  Evt3Decoder decoder({1280, 720});
  Decoded made;
  while (!rest.empty()) {
    Decoded part;
    const std::size_t used = decoder.decode(rest, part.events, part.triggers, 100);
    ASSERT_GT(used, 0U);
    EXPECT_LT(part.events.size(), 100U + 6144U);
    EXPECT_LT(part.triggers.size(), 100U + 6144U);
    rest = rest.subspan(used);
    made.events.insert(made.events.end(), part.events.begin(), part.events.end());
    made.triggers.insert(made.triggers.end(), part.triggers.begin(), part.triggers.end());
  }
  EXPECT_EQ(made.events, whole.events);
  EXPECT_EQ(made.triggers, whole.triggers);
}

TEST(Evt3Decoder, WaitsForTimeAndRowAfterAGapAndKeepsTheRollOvers) {
  Evt3Decoder decoder({10, 10});
  Decoded made;
  const auto decode = [&](const Words& words) { decoder.decode(std::as_bytes(std::span(words)), made.events, made.triggers); };
  decode({0x8FFF, 0x6000, 0x0001, 0x2001});
  decoder.skip_gap();
  decode({0x2002, 0x8000, 0x6004, 0x2002, 0x0002, 0x2003});
  EXPECT_EQ(made.events, (std::vector<Event>{event(0xFFF000, 1, 1, 0), event(0x1000004, 3, 2, 0)}));
  EXPECT_EQ(decoder.problems().unplaced, 2U);
}

}  // namespace
}  // namespace tactile::events
