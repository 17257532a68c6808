#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tactile/events/pixel_mask.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::alignment {

/// Events per bin of time in a recording, without its hot pixels.
struct EventRate {
  CameraTime begin{};     ///< the first event's time, where bin 0 begins
  microseconds bin{200};  ///< half-open: [begin + i * bin, begin + (i + 1) * bin); a whole number of read-outs
  std::vector<std::uint32_t> counts = {};
  std::size_t hot_pixels = 0;           ///< left out
  CameraTime last{};                    ///< the last event's time
  std::vector<std::uint32_t> hot = {};  ///< their places, y * width + x, ascending
  /// Bins with as many events as the path to the host allows: more events were lost, and the rate is cut off there. Fewer than 20
  /// cannot be distinguished from chance and count as 0.
  std::size_t saturated_bins = 0;
  /// The frequency at which the light swings throughout the recording, as that of lamps without a filter. Its events hide touches
  /// where they are most of the rate's variation.
  std::optional<double> flicker_hz = {};
  bool is_part = false;  ///< of a recording

  CameraTime begin_of(std::size_t bin_index) const { return after(begin, bin * static_cast<std::int64_t>(bin_index)); }
};

struct EventRateOptions {
  microseconds bin{200};                        ///< > 0; brought to the nearest whole number of read-outs, one at least
  double hot_pixel_hz = 8.0;                    ///< a pixel that fires less often is not hot
  events::MaskPixels mask{};                    ///< pixels that are left out like hot ones
  double flickers = 0.3;                        ///< the rate flickers if one frequency has at least this share of the variance
  microseconds longest{std::chrono::hours(1)};  ///< of a recording, > 0; memory follows length / bin
};

/// Reads the recording three times: for its span and its read-outs (no table in the file is trusted for them), to find the hot
/// pixels, and to count.
///
/// Of eight equal parts of the recording, a pixel that a moving marker lights fires in a few, a hot one in most. A pixel is hot
/// if in at least seven parts it fires as often as `hot_pixel_hz` and ten standard deviations above the mean of all pixels in the
/// quietest part. Hot pixels appear and heal: a pixel is also hot if it fires so often in the last two or the first two parts,
/// evenly, and in the outer one, where no touch is expected, five times as often as any but one of the 24 pixels around it.
/// @throws Error  if the stream has no event or no sane size, or spans more than `longest` (a run takes seconds)
EventRate event_rate(events::RecordingReader& recording, std::int32_t stream_id, const EventRateOptions& options = {});

/// The bins [begin, end) of a rate. @param begin, end  begin < end <= their number
EventRate part_of(const EventRate& rate, std::size_t begin, std::size_t end);

/// Hands every event that `rate` counts, and its bin, to `use`, in file order. For a part, packets that lie outside by the list
/// of packets are not read.
/// @param rate  of this stream of this recording, or a part of it
void for_counted_events(events::RecordingReader& recording, std::int32_t stream_id, const EventRate& rate,
                        const std::function<void(const events::Event&, std::size_t)>& use);

}  // namespace tactile::alignment
