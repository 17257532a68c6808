#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/events/evt3.hpp"

namespace tactile::events {

/// Decodes a stream of EVT2, as older cameras of Prophesee send it: little-endian words of 32 bits, with their type in the upper
/// four. A word has the upper 28 bits of the time, or an event or trigger with the lower 6. The decoder keeps its state between
/// calls, so a stream may be divided after any word.
///
/// - The 34 bits of the time count microseconds and roll over every 4.8 hours. The decoder carries them on. A step back by at
/// most
///   65.5 ms is disorder, and not a roll-over.
/// - Events before the first upper half of the time are counted and dropped.
/// - Words of the types OTHERS and CONTINUED carry no event; they are skipped.
///
/// Source: Prophesee, EVT 2.0 Format, docs.prophesee.ai.
class Evt2Decoder {
 public:
  static constexpr std::size_t word_bytes = 4;

  struct State {
    std::int64_t high_us = 0;  ///< the time without its lower 6 bits, with the roll-overs
    bool has_high = false;
  };

  /// @param size  of the sensor, 1 to 2048 pixels in each direction
  explicit Evt2Decoder(SensorSize size) : size_(size) {}

  /// Appends the events and triggers of `data`, which has whole words.
  void decode(std::span<const std::byte> data, std::vector<Event>& events, std::vector<Evt3Trigger>& triggers);

  const State& state() const { return state_; }
  void resume(const State& state) { state_ = state; }         ///< continues where a decoder had this state
  const Evt3Problems& problems() const { return problems_; }  ///< so far

 private:
  SensorSize size_;
  State state_;
  Evt3Problems problems_;
};

}  // namespace tactile::events
