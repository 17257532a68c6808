#include "tactile/events/evt2.hpp"

#include <cstring>

namespace tactile::events {
namespace {

struct Evt2Word {
  enum : unsigned { darker = 0x0, brighter = 0x1, time_high = 0x8, external_trigger = 0xA, others = 0xE, continued = 0xF };
};

constexpr std::uint32_t evt2_high_mask = 0xFFF'FFFF;
constexpr std::uint32_t most_evt2_step_back = 1024;  // upper parts of the time, each 64 us

/// The upper part of the time, after the one before it.
std::int64_t next_evt2_high_us(std::int64_t before_us, std::uint32_t high) {
  const auto before = static_cast<std::uint32_t>(before_us >> 6) & evt2_high_mask;
  const std::uint32_t forward = (high - before) & evt2_high_mask;
  const std::int64_t step =
      forward >= evt2_high_mask + 1 - most_evt2_step_back ? std::int64_t{forward} - evt2_high_mask - 1 : std::int64_t{forward};
  return us_of(after(camera_time(before_us), microseconds{step * 64}));
}

}  // namespace

void Evt2Decoder::decode(std::span<const std::byte> data, std::vector<Event>& events, std::vector<Evt3Trigger>& triggers) {
  const auto width = static_cast<unsigned>(size_.width), height = static_cast<unsigned>(size_.height);
  const std::size_t count = data.size() / word_bytes, before = events.size();
  events.resize(before + count);  // at most one a word
  Event* next = events.data() + before;
  State state = state_;
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t word = 0;
    std::memcpy(&word, data.data() + word_bytes * i, sizeof word);
    const unsigned type = word >> 28;
    const std::int64_t t_us = state.high_us + (word >> 22 & 0x3F);
    if (type <= Evt2Word::brighter) {
      const unsigned x = word >> 11 & 0x7FF, y = word & 0x7FF;
      if (!state.has_high || x >= width || y >= height) {
        ++(state.has_high ? problems_.outside : problems_.unplaced);
        continue;
      }
      *next++ = Event{.t = camera_time(t_us),
                      .x = static_cast<std::int16_t>(x),
                      .y = static_cast<std::int16_t>(y),
                      .on = static_cast<std::uint8_t>(type)};
    } else if (type == Evt2Word::time_high) {
      const std::uint32_t high = word & evt2_high_mask;
      state.high_us = state.has_high ? next_evt2_high_us(state.high_us, high) : std::int64_t{high} << 6;
      state.has_high = true;
    } else if (type == Evt2Word::external_trigger) {
      if (state.has_high) {
        triggers.push_back(
            {.t = camera_time(t_us), .channel = static_cast<std::uint8_t>(word >> 8 & 0x1F), .is_rising = (word & 1) != 0});
      } else {
        ++problems_.unplaced;
      }
    } else if (type != Evt2Word::others && type != Evt2Word::continued) {
      ++problems_.unknown_words;
    }
  }
  events.resize(static_cast<std::size_t>(next - events.data()));
  state_ = state;
}

}  // namespace tactile::events
