#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tactile/events/recording_reader.hpp"
#include "tactile/labels/activity.hpp"
#include "tactile/labels/event_rate.hpp"

namespace tactile {

/// A part of what a burst lights that hangs together: a marker or two. Each is touched at a time of its own.
struct LitPlace {
  std::vector<std::uint32_t> counts;   ///< by the bins of `LitRate::rate`
  std::vector<std::uint32_t> repeats;  ///< likewise of `LitRate::repeats`
  double quiet_per_bin = 0;
  double dispersion = 1;
};

/// How often the part of the image that one burst lights fires, around that burst. A touch moves some markers and leaves the
/// others alone: without the rest of the image a tenth or less of the noise is left, and onsets and ends stand out.
struct LitRate {
  EventRate
      rate;  ///< of the lit cells, from `margin` ahead of the burst until `margin` behind it, where recorded and no other is
  /// How many of them repeat their pixel's last event: the same polarity, not more than `repeat_within` later.
  std::vector<std::uint32_t> repeats;
  double quiet_per_bin = 0;     ///< of the lit cells while no burst is on anywhere
  double dispersion = 1;        ///< of that, variance per mean, >= 1
  std::size_t burst_begin = 0;  ///< in bins of `rate`
  std::size_t burst_end = 0;
  double lit_share = 0;  ///< of the image
  /// Share of the lit pixels that noise has set anew since the burst before, or the recording's begin, 0 to 1: they need a whole
  /// threshold of change until they fire, the others less.
  double set_anew = 0;
  std::vector<LitPlace> places;  ///< those that stand out by themselves, `most_places` at most; may be none
  /// How far the burst undoes what all bursts before it did, -1 to 1: the correlation of the brightening of pixels. A release
  /// gives back what its press took, so that it is near 1; the first burst has 0.
  double undoes = 0;
};

struct LitRateOptions {
  int cell_px = 8;                     ///< side of a cell; small against a marker, large enough to hold some events
  double stands_out = 5.0;             ///< [standard deviations] a lit cell has so many events above its noise, and 4 more
  int joined_cells = 2;                ///< lit cells not farther apart than this hang together
  std::size_t most_places = 24;        ///< in one burst, those with the most events
  microseconds margin{500'000};        ///< kept ahead of a burst and behind it
  microseconds repeat_within{40'000};  ///< see LitRate::repeats
  microseconds quiet_margin{20'000};   ///< so near to a burst nothing counts as quiet
};

/// Of each burst in turn. Which cells a burst lights is learned from the burst itself, so that nothing is assumed of where the
/// markers are. Reads the recording twice; memory follows the bursts.
/// @param rate  of the same stream of this recording
/// @throws Error  as reading events does
std::vector<LitRate> lit_rates(RecordingReader& recording, std::int32_t stream_id, const EventRate& rate,
                               std::span<const Burst> bursts, const LitRateOptions& options = {});

}  // namespace tactile
