#include "tactile/events/evt3_survey.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "tactile/events/evt3_words.hpp"

namespace tactile::events {
namespace {

/// What a word of each type does, as numbers to calculate with: a branch for each type would often be predicted wrong.
struct WordType {
  unsigned vector_bits = 0;                    ///< of the word, each an event
  unsigned events = 0;                         ///< besides them
  unsigned pixels = 0;                         ///< that a vector, or an event, spans
  unsigned end_by_value = 0, end_by_base = 0;  ///< masks: where its pixels end follows from the value, or from the base
  unsigned sets_y = 0, sets_base = 0;          ///< masks
  unsigned checks_y = 0;                       ///< 1 if it has events
  unsigned is_rare = 1;
};

constexpr std::array<WordType, 16> word_types = [] {
  constexpr unsigned all = ~0U;
  std::array<WordType, 16> types{};
  for (const unsigned frequent :
       {Evt3Word::address_y, Evt3Word::address_x, Evt3Word::vector_base_x, Evt3Word::vector_12, Evt3Word::vector_8})
    types[frequent].is_rare = 0;
  types[Evt3Word::address_y].sets_y = types[Evt3Word::vector_base_x].sets_base = all;
  types[Evt3Word::address_x].events = types[Evt3Word::address_x].pixels = types[Evt3Word::address_x].checks_y = 1;
  types[Evt3Word::address_x].end_by_value = all;
  types[Evt3Word::vector_12].vector_bits = 0xFFF;
  types[Evt3Word::vector_12].pixels = 12;
  types[Evt3Word::vector_8].vector_bits = 0xFF;
  types[Evt3Word::vector_8].pixels = 8;
  for (const unsigned vector : {Evt3Word::vector_12, Evt3Word::vector_8}) {
    types[vector].end_by_base = all;
    types[vector].checks_y = 1;
  }
  return types;
}();

constexpr std::array<std::uint8_t, 4096> bits_of = [] {  // a processor's own instruction may be missing
  std::array<std::uint8_t, 4096> bits{};
  for (unsigned i = 0; i < bits.size(); ++i) bits[i] = static_cast<std::uint8_t>(std::popcount(i));
  return bits;
}();

/// Counts, and notes the times of events.
class Surveyor {
 public:
  Surveyor(Evt3Decoder& decoder, SensorSize size, std::vector<Evt3Trigger>& triggers)
      : decoder_(decoder),
        width_(static_cast<unsigned>(size.width)),
        height_(static_cast<unsigned>(size.height)),
        triggers_(triggers) {}

  /// By the decoder: words that are rare, or whose events may lie outside.
  void decode(std::span<const std::byte> data) {
    events_.clear();
    decoder_.decode(data, events_, triggers_);
    for (const Event& event : events_) note(1, event.t);
  }

  void count(std::span<const std::byte> data) {
    const unsigned width = width_, height = height_;
    Evt3Decoder::State state = decoder_.state();
    unsigned y = state.y, base = state.base_x, base_word = state.base_on ? 0x800 : 0;
    std::int64_t events = 0;  // since the time was set
    for (std::size_t at = 0; at < data.size(); at += Evt3Decoder::word_bytes) {
      std::uint16_t stored = 0;
      std::memcpy(&stored, data.data() + at, sizeof stored);
      const unsigned word = stored, value = word & 0x7FF;
      const WordType& type = word_types[word >> 12];
      const unsigned end = (value & type.end_by_value) + (base & type.end_by_base) + type.pixels;
      const unsigned is_outside = static_cast<unsigned>(end > width) | (type.checks_y & static_cast<unsigned>(y >= height));
      if ((type.is_rare | is_outside) != 0) {
        note(events, camera_time(state.t_us));
        events = 0;
        if (word >> 12 == Evt3Word::time_low) {
          state.t_us = state.high_us + (word & 0xFFF);
          continue;
        }
        state.y = y;
        state.base_x = base;
        state.base_on = (base_word & 0x800) != 0;
        decoder_.resume(state);
        decode(data.subspan(at, Evt3Decoder::word_bytes));
        state = decoder_.state();
        base = state.base_x;
        continue;
      }
      events += type.events + bits_of[word & type.vector_bits];
      y = (value & type.sets_y) | (y & ~type.sets_y);
      base_word = (word & type.sets_base) | (base_word & ~type.sets_base);
      base = (value & type.sets_base) | ((base + (type.pixels & type.end_by_base)) & ~type.sets_base);
    }
    note(events, camera_time(state.t_us));
    state.y = y;
    state.base_x = base;
    state.base_on = (base_word & 0x800) != 0;
    decoder_.resume(state);
  }

  const Evt3Survey& made() const { return made_; }

 private:
  void note(std::int64_t events, CameraTime t) {
    if (events == 0) return;
    made_.first = made_.events == 0 ? t : std::min(made_.first, t);
    made_.last = made_.events == 0 ? t : std::max(made_.last, t);
    made_.events += events;
  }

  Evt3Decoder& decoder_;
  unsigned width_, height_;
  std::vector<Evt3Trigger>& triggers_;
  std::vector<Event> events_;
  Evt3Survey made_;
};

}  // namespace

Evt3Survey survey(Evt3Decoder& decoder, SensorSize size, std::span<const std::byte> data, std::vector<Evt3Trigger>& triggers) {
  constexpr std::size_t block = 512 * Evt3Decoder::word_bytes;
  Surveyor surveyor(decoder, size, triggers);
  for (std::size_t at = 0; at < data.size(); at += block) {
    const std::span<const std::byte> part = data.subspan(at, std::min(block, data.size() - at));
    // Before the first time and row, events are dropped.
    const bool is_known = decoder.state().has_low && decoder.state().has_row;
    is_known ? surveyor.count(part) : surveyor.decode(part);
  }
  return surveyor.made();
}

}  // namespace tactile::events
