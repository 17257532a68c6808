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

}  // namespace

Trigger trigger_of(const Evt3Trigger& trigger) {
  constexpr std::int8_t rising_edge = 1, falling_edge = 2;
  return {.t = trigger.t, .type = trigger.is_rising ? rising_edge : falling_edge};
}

Evt3Decoder::Evt3Decoder(SensorSize size) : size_(size), block_(block_words * most_of_word) {}

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

Evt3Decoder::State Evt3Decoder::after_rare_word(unsigned word, State state, std::vector<Evt3Trigger>& triggers) {
  switch (word >> 12) {
    case Evt3Word::time_high: {
      const unsigned high = word & 0xFFF;
      const std::int64_t before_us = state.high_us;
      state.high_us = state.has_clock ? next_high_us(before_us, high) : std::int64_t{high} << 12;
      if (state.high_us != before_us) state.t_us = state.high_us;
      state.has_clock = state.has_high = true;
      break;
    }
    case Evt3Word::external_trigger:
      if (state.has_low) {
        triggers.push_back(
            {.t = camera_time(state.t_us), .channel = static_cast<std::uint8_t>(word >> 8 & 0xF), .is_rising = (word & 1) != 0});
      } else {
        ++problems_.unplaced;
      }
      break;
    case Evt3Word::continued_4:
    case Evt3Word::others:
    case Evt3Word::continued_12:
      break;
    default:
      ++problems_.unknown_words;
      break;
  }
  return state;
}

void Evt3Decoder::decode_words(const std::byte* words, std::size_t count, std::vector<Event>& events,
                               std::vector<Evt3Trigger>& triggers) {
  // What changes often is in local variables, which the compiler keeps in registers: the loop runs several 10^8 times a second.
  const auto width = static_cast<unsigned>(size_.width), height = static_cast<unsigned>(size_.height);
  State state = state_;
  bool is_known = state.has_low && state.has_row;
  Event* next = block_.data();
  const auto drop = [&](int dropped) { (is_known ? problems_.outside : problems_.unplaced) += static_cast<unsigned>(dropped); };
  const auto put = [&](unsigned x, unsigned on) {
    *next++ = Event{.t = camera_time(state.t_us),
                    .x = static_cast<std::int16_t>(x),
                    .y = static_cast<std::int16_t>(state.y),
                    .on = static_cast<std::uint8_t>(on)};
  };
  const auto put_vector = [&](unsigned mask, unsigned pixels) {
    const unsigned inside = state.base_x >= width ? 0 : width - state.base_x;
    unsigned usable = mask & (inside >= pixels ? ~0U : (1U << inside) - 1);
    if (!is_known || state.y >= height) usable = 0;
    if (usable != mask) drop(std::popcount(mask ^ usable));
    for (; usable != 0; usable &= usable - 1) put(state.base_x + static_cast<unsigned>(std::countr_zero(usable)), state.base_on);
    state.base_x += pixels;
  };
  for (std::size_t i = 0; i < count; ++i) {
    std::uint16_t stored = 0;
    std::memcpy(&stored, words + 2 * i, sizeof stored);
    const unsigned word = stored, value = word & 0x7FF, upper_bit = word >> 11 & 1;
    switch (word >> 12) {
      case Evt3Word::address_y:
        state.y = value;
        state.has_row = true;
        is_known = state.has_low;
        break;
      case Evt3Word::address_x:
        (is_known && value < width && state.y < height) ? put(value, upper_bit) : drop(1);
        break;
      case Evt3Word::vector_base_x:
        state.base_x = value;
        state.base_on = upper_bit != 0;
        break;
      case Evt3Word::vector_12:
        put_vector(word & 0xFFF, 12);
        break;
      case Evt3Word::vector_8:
        put_vector(word & 0xFF, 8);
        break;
      case Evt3Word::time_low:
        state.t_us = state.high_us + (word & 0xFFF);
        state.has_low = state.has_high;
        is_known = state.has_low && state.has_row;
        break;
      default:
        state = after_rare_word(word, state, triggers);
        break;
    }
  }
  events.insert(events.end(), block_.data(), next);
  state_ = state;
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
