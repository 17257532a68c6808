#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/alignment/camera_span.hpp"
#include "tactile/alignment/event_rate.hpp"

namespace tactile::labels {

/// The events of a recording without its hot pixels, by bin of time and place of the image.
struct PlaceCounts {
  static constexpr std::size_t across = 16, down = 12, places = across * down;

  /// An event as the pattern of a motion needs it: a cell of the image, and whether it became brighter.
  struct Sign {
    std::uint16_t cell;
    std::int8_t sign;  ///< 1 brighter, -1 darker
  };
  static constexpr std::size_t cells_across = 160, cells_down = 120, cells = cells_across * cells_down;

  CameraTime begin{};
  microseconds bin{};
  std::vector<std::uint16_t> counts = {};      ///< [bin, place], at most 65535
  std::vector<bool> recorded = {};             ///< of each bin: false in gaps of the recording; empty: all are
  bool several_runs = false;                   ///< else the recording has one: few seconds, with one press and one slip
  std::vector<Sign> signs = {};                ///< by bin
  std::vector<std::uint64_t> first_sign = {};  ///< [bin + 1], of `signs`

  std::size_t bins() const { return counts.size() / places; }
  std::span<const std::uint16_t> at(std::size_t b) const { return std::span(counts).subspan(b * places, places); }
  std::span<const Sign> signs_in(std::size_t first, std::size_t end) const {
    return std::span(signs).subspan(first_sign[first], first_sign[end] - first_sign[first]);
  }
  bool is_recorded(std::size_t b) const { return recorded.empty() || recorded[b]; }
  CameraTime begin_of(std::size_t b) const { return after(begin, bin * static_cast<std::int64_t>(b)); }
};

/// @param rate     of this stream, or a part of it
/// @param gaps     in which nothing was recorded
/// @param longest  of a bin, which is a whole number of the rate's, one at least
/// @throws Error   if the recording cannot be read
PlaceCounts place_counts(events::RecordingReader& recording, std::int32_t stream, const alignment::EventRate& rate,
                         std::span<const alignment::CameraSpan> gaps, microseconds longest);

}  // namespace tactile::labels
