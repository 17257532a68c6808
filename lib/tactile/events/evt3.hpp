#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/events/other_streams.hpp"

namespace tactile::events {

/// An edge at one of the camera's trigger channels.
struct Evt3Trigger {
  CameraTime t;
  std::uint8_t channel = 0;  ///< 0 to 15; 0 is the plug of most cameras
  bool is_rising = false;

  friend bool operator==(const Evt3Trigger&, const Evt3Trigger&) = default;
};

/// The trigger as AEDAT4 stores it, which has no channel.
Trigger trigger_of(const Evt3Trigger& trigger);

/// What an EVT3 stream contains that gives no event.
struct Evt3Problems {
  std::uint64_t unknown_words = 0;  ///< of a type that the format does not define
  std::uint64_t unplaced = 0;       ///< events and triggers before the first time and row are known
  std::uint64_t outside = 0;        ///< events outside the sensor

  friend bool operator==(const Evt3Problems&, const Evt3Problems&) = default;
};

/// Decodes a stream of EVT3, as cameras of Prophesee send it: little-endian words of 16 bits, with their type in the upper four.
/// A word sets the row, the upper or lower 12 bits of the time, or the start of a vector; or it has one event, or 8 or 12 pixels
/// of a row as a mask. The decoder keeps its state between calls, so a stream may be divided anywhere.
///
/// - The 24 bits of the time count microseconds and roll over every 16.8 s. The decoder carries them on: its times rise as far as
///   the camera's do. A step back by at most 65.5 ms is disorder, as cameras produce it, and not a roll-over.
/// - A new upper half of the time sets the lower half to 0 until that is sent.
/// - Events before the first upper and then lower half of the time, or before the first row, are counted and dropped.
/// - Words of the types OTHERS and CONTINUED carry no event; they are skipped.
///
/// Source: Prophesee, EVT 3.0 Format, docs.prophesee.ai.
class Evt3Decoder {
 public:
  static constexpr std::size_t word_bytes = 2;

  /// What the words so far say of those that follow.
  struct State {
    std::int64_t high_us = 0;  ///< the time without its lower half, with the roll-overs
    std::int64_t t_us = 0;
    unsigned y = 0, base_x = 0;
    bool base_on = false;
    bool has_clock = false;  ///< a time was seen: a later one is a step, not the start
    bool has_high = false, has_low = false, has_row = false;
  };

  /// @param size  of the sensor, 1 to 2048 pixels in each direction; a larger one has no pixel that the format can address
  explicit Evt3Decoder(SensorSize size);

  /// Appends the events and triggers of `data`. An odd byte at its end is the first half of the next call's first word.
  /// @param most  of all in `events`, and in `triggers`; decoding ends within 6144 above it
  /// @return  the bytes that were decoded: all, unless `most` was reached
  std::size_t decode(std::span<const std::byte> data, std::vector<Event>& events, std::vector<Evt3Trigger>& triggers,
                     std::size_t most = std::numeric_limits<std::size_t>::max());

  /// Continues after lost data: nothing is decoded until time and row are sent again. The count of roll-overs is kept.
  void skip_gap();

  const State& state() const { return state_; }
  void resume(const State& state);  ///< continues where a decoder had this state, after whole words

  const Evt3Problems& problems() const { return problems_; }  ///< so far

 private:
  void decode_words(const std::byte* words, std::size_t count, std::vector<Event>& events, std::vector<Evt3Trigger>& triggers);
  /// Any word, with all checks. @return  where the next event is written
  Event* decode_word(unsigned word, Event* next, std::vector<Evt3Trigger>& triggers);

  SensorSize size_;
  std::vector<Event> block_;  ///< room for the events of one block of words, and for one more
  Evt3Problems problems_;
  std::optional<std::byte> half_word_;
  State state_;
};

}  // namespace tactile::events
