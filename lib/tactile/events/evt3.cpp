#include "tactile/events/evt3.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "tactile/events/evt3_words.hpp"

namespace tactile::events {
namespace {

constexpr std::size_t block_words = 512;
constexpr std::size_t most_of_word = 12;
constexpr unsigned most_step_back = 16;  // upper halves of the time, each 4.096 ms

/// The upper half of the time, after the one before it.
std::int64_t next_high_us(std::int64_t before_us, unsigned high) {
  const auto before = static_cast<unsigned>(before_us >> 12);
  const unsigned forward = (high - before) & 0xFFF;
  const std::int64_t step = forward > 0x1000 - most_step_back - 1 ? std::int64_t{forward} - 0x1000 : std::int64_t{forward};
  return before_us + step * 4096;
}

unsigned upper_half(std::int64_t high_us) { return static_cast<unsigned>(high_us >> 12) & 0xFFF; }

/// What a usual word of a type does, as numbers to calculate with. A word is usual if
///
///   (word & mask) - usual < range,   unsigned:   one that repeats the upper half of the time, an event inside the sensor, ...
struct WordType {
  std::uint32_t mask = 0, usual = 0, range = 0;
  std::uint32_t events = 0;
  std::uint64_t sets_y = 0;   ///< mask
  std::int64_t sets_low = 0;  ///< mask
};

/// Whether the next event has a time and a row of the sensor.
bool is_placing(const Evt3Decoder::State& state, SensorSize size) {
  return state.has_low && state.has_row && state.y < static_cast<unsigned>(size.height);
}

/// No word is usual before an event can be placed.
std::array<WordType, 16> word_types(const Evt3Decoder::State& state, SensorSize size) {
  std::array<WordType, 16> types{};
  if (!is_placing(state, size)) return types;
  types[Evt3Word::address_y] = {.mask = 0x7FF, .range = static_cast<std::uint32_t>(size.height), .sets_y = ~std::uint64_t{}};
  types[Evt3Word::address_x] = {.mask = 0x7FF, .range = static_cast<std::uint32_t>(size.width), .events = 1};
  types[Evt3Word::time_low] = {.range = 1, .sets_low = -1};
  types[Evt3Word::time_high] = {.mask = 0xFFF, .usual = upper_half(state.high_us), .range = 1};
  for (const unsigned without_event : {Evt3Word::continued_4, Evt3Word::others, Evt3Word::continued_12})
    types[without_event].range = 1;
  return types;
}

/// Two writes of 8 bytes: the compiler would first collect the fields in memory, which takes longer than all the rest.
void write_event(Event* event, std::int64_t t_us, std::uint64_t x, std::uint64_t y, std::uint64_t on) {
  const std::array<std::uint64_t, 2> stored{static_cast<std::uint64_t>(t_us), x | y << 16 | on << 32};
  static_assert(sizeof stored == sizeof *event);
  std::memcpy(static_cast<void*>(event), stored.data(), sizeof stored);
}

Evt3Trigger trigger_in(unsigned word, std::int64_t t_us) {
  return {.t = camera_time(t_us), .channel = static_cast<std::uint8_t>(word >> 8 & 0xF), .is_rising = (word & 1) != 0};
}

}  // namespace

Trigger trigger_of(const Evt3Trigger& trigger) {
  constexpr std::int8_t rising_edge = 1, falling_edge = 2;
  return {.t = trigger.t, .type = trigger.is_rising ? rising_edge : falling_edge};
}

Evt3Decoder::Evt3Decoder(SensorSize size) : size_(size), block_(block_words * most_of_word + 1) {}

std::size_t Evt3Decoder::decode(std::span<const std::byte> data, std::vector<Event>& events, std::vector<Evt3Trigger>& triggers,
                                std::size_t most) {
  std::size_t used = 0;
  if (half_word_ && !data.empty()) {
    const std::array<std::byte, 2> word{*half_word_, data.front()};
    half_word_.reset();
    decode_words(word.data(), 1, events, triggers);
    used = 1;
  }
  while (data.size() - used >= 2 && events.size() < most && triggers.size() < most) {
    const std::size_t count = std::min((data.size() - used) / 2, block_words);
    decode_words(data.data() + used, count, events, triggers);
    used += 2 * count;
  }
  if (data.size() - used == 1) half_word_ = data[used++];
  return used;
}

Event* Evt3Decoder::decode_word(unsigned word, Event* next, std::vector<Evt3Trigger>& triggers) {
  State& s = state_;
  const auto width = static_cast<unsigned>(size_.width), height = static_cast<unsigned>(size_.height);
  const bool is_known = s.has_low && s.has_row;
  const unsigned value = word & 0x7FF, upper_bit = word >> 11 & 1;
  const auto put_all = [&](unsigned x, unsigned mask, unsigned pixels, unsigned on) {
    const unsigned inside = x >= width ? 0 : width - x;
    unsigned usable = mask & (inside >= pixels ? ~0U : (1U << inside) - 1);
    if (!is_known || s.y >= height) usable = 0;
    if (usable != mask)
      (is_known ? problems_.outside : problems_.unplaced) += static_cast<unsigned>(std::popcount(mask ^ usable));
    for (; usable != 0; usable &= usable - 1)
      write_event(next++, s.t_us, x + static_cast<unsigned>(std::countr_zero(usable)), s.y, on);
  };
  switch (word >> 12) {
    case Evt3Word::address_y:
      s.y = value;
      s.has_row = true;
      break;
    case Evt3Word::address_x:
      put_all(value, 1, 1, upper_bit);
      break;
    case Evt3Word::vector_base_x:
      s.base_x = value;
      s.base_on = upper_bit != 0;
      break;
    case Evt3Word::vector_12:
    case Evt3Word::vector_8: {
      const unsigned pixels = word >> 12 == Evt3Word::vector_12 ? 12 : 8;
      put_all(s.base_x, word & ((1U << pixels) - 1), pixels, s.base_on);
      s.base_x += pixels;
      break;
    }
    case Evt3Word::time_low:
      s.t_us = s.high_us + (word & 0xFFF);
      s.has_low = s.has_high;
      break;
    case Evt3Word::time_high: {
      const std::int64_t before_us = s.high_us;
      s.high_us = s.has_clock ? next_high_us(before_us, word & 0xFFF) : std::int64_t{word & 0xFFF} << 12;
      if (s.high_us != before_us) s.t_us = s.high_us;
      s.has_clock = s.has_high = true;
      break;
    }
    case Evt3Word::external_trigger:
      if (s.has_low)
        triggers.push_back(trigger_in(word, s.t_us));
      else
        ++problems_.unplaced;
      break;
    case Evt3Word::continued_4:
    case Evt3Word::others:
    case Evt3Word::continued_12:
      break;
    default:
      ++problems_.unknown_words;
      break;
  }
  return next;
}

/// Most words are usual ones: they are decoded without a branch for their type, which would often be predicted wrong.
void Evt3Decoder::decode_words(const std::byte* words, std::size_t count, std::vector<Event>& events,
                               std::vector<Evt3Trigger>& triggers) {
  bool places_events = is_placing(state_, size_);
  std::array<WordType, 16> types = word_types(state_, size_);
  std::uint64_t y = state_.y;
  std::int64_t high_us = state_.high_us, t_us = state_.t_us;
  Event* next = block_.data();
  for (const std::byte* const end = words + word_bytes * count; words != end; words += word_bytes) {
    std::uint16_t stored = 0;
    std::memcpy(&stored, words, sizeof stored);
    const std::uint64_t word = stored, x = word & 0x7FF;
    const WordType& type = types[word >> 12];
    if ((stored & type.mask) - type.usual >= type.range) {
      state_.y = static_cast<unsigned>(y);
      state_.t_us = t_us;
      next = decode_word(stored, next, triggers);
      y = state_.y;
      t_us = state_.t_us;
      high_us = state_.high_us;
      if (is_placing(state_, size_) != places_events) {
        places_events = !places_events;
        types = word_types(state_, size_);
      }
      types[Evt3Word::time_high].usual = upper_half(high_us);
      continue;
    }
    y ^= (y ^ x) & type.sets_y;
    t_us ^= (t_us ^ (high_us + static_cast<std::int64_t>(word & 0xFFF))) & type.sets_low;
    write_event(next, t_us, x, y, word >> 11 & 1);
    next += type.events;
  }
  events.insert(events.end(), block_.data(), next);
  state_.y = static_cast<unsigned>(y);
  state_.t_us = t_us;
}

void Evt3Decoder::resume(const State& state) {
  half_word_.reset();
  state_ = state;
}

void Evt3Decoder::skip_gap() {
  half_word_.reset();
  state_.has_high = state_.has_low = state_.has_row = false;
}

}  // namespace tactile::events
