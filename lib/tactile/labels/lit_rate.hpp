#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tactile/alignment/activity.hpp"
#include "tactile/alignment/event_rate.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::labels {

/// Connected cells that a burst lights: a marker or two. Each place is touched at a time of its own.
struct LitPlace {
  std::vector<std::uint32_t> counts;   ///< by the bins of `LitRate::rate`
  std::vector<std::uint32_t> repeats;  ///< by the bins of `LitRate::repeats`
  double quiet_per_bin = 0;
  double dispersion = 1;
};

/// The event rate of the part of the image that one burst lights, around that burst. A touch moves some markers and leaves the
/// others: without the rest of the image a tenth or less of the noise is left, and onsets and ends stand out.
struct LitRate {
  /// Of the lit cells, from `margin` before the burst until `margin` after it, where recorded and without other bursts.
  alignment::EventRate rate;
  /// How many of them repeat their pixel's last event: the same polarity, not more than `repeat_within` later.
  std::vector<std::uint32_t> repeats;
  double quiet_per_bin = 0;     ///< of the lit cells while there is no burst
  double dispersion = 1;        ///< of that, variance per mean, >= 1
  std::size_t burst_begin = 0;  ///< in bins of `rate`
  std::size_t burst_end = 0;
  double lit_share = 0;  ///< of the image
  /// Share of the lit pixels that noise has reset since the burst before, or the recording's start, 0 to 1: they need a whole
  /// threshold of change until they fire, the others less.
  double reset_share = 0;
  std::vector<LitPlace> places;  ///< those that stand out by themselves, at most `most_places`; may be none
  /// How far the burst reverses all bursts before it, -1 to 1: minus the correlation of the brightening of cells. It is near 1
  /// for a release, which reverses its press; the first burst has 0.
  double undoes = 0;
};

struct LitRateOptions {
  int cell_px = 8;                     ///< side of a cell; small against a marker, large enough to hold some events
  double stands_out = 5.0;             ///< [standard deviations] a lit cell has this many events above its noise, and 4 more
  int joined_cells = 2;                ///< lit cells not farther apart than this are connected
  std::size_t most_places = 24;        ///< in one burst, those with the most events
  microseconds margin{500'000};        ///< kept before a burst and after it
  microseconds repeat_within{40'000};  ///< see LitRate::repeats
  microseconds quiet_margin{20'000};   ///< nothing counts as quiet so near to a burst
  /// Indices of bursts before which another object was touched: `undoes` compares only with the bursts since then.
  std::vector<std::size_t> fresh_at = {};
};

/// Of each burst. The burst itself shows which cells it lights, so that no position of markers is assumed. Reads the recording
/// twice; memory follows the bursts.
/// @param rate  of the same stream of this recording
/// @throws Error  as reading events does
std::vector<LitRate> lit_rates(events::RecordingReader& recording, std::int32_t stream_id, const alignment::EventRate& rate,
                               std::span<const alignment::Burst> bursts, const LitRateOptions& options = {});

}  // namespace tactile::labels
