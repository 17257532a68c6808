#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tactile/events/recording_reader.hpp"

namespace tactile {

/// How many events a recording holds in each stretch of time, without its hot pixels.
struct EventRate {
  CameraTime begin{};     ///< the first event's time, where bin 0 begins
  microseconds bin{200};  ///< half-open: [begin + i * bin, begin + (i + 1) * bin); a whole number of read-outs
  std::vector<std::uint32_t> counts = {};
  std::size_t hot_pixels = 0;           ///< left out
  CameraTime last{};                    ///< the last event's time
  std::vector<std::uint32_t> hot = {};  ///< their places, y * width + x, ascending
  /// Bins that hold as many events as the way to the host takes: what they lack is unknown, and the rate is cut off there.
  /// Nothing below 20 of them is told from chance.
  std::size_t saturated_bins = 0;
  /// At which the rate swings throughout the recording, as it does under lamps without a filter: where that is most of what the
  /// rate does, touches drown in it.
  std::optional<double> flicker_hz = {};

  CameraTime begin_of(std::size_t bin_index) const { return after(begin, bin * static_cast<std::int64_t>(bin_index)); }
};

struct EventRateOptions {
  microseconds bin{200};      ///< > 0; brought to the nearest whole number of read-outs, one at least
  double hot_pixel_hz = 8.0;  ///< no pixel that fires less often is hot
  double flickers = 0.3;      ///< share of the variance, at one frequency, from which on the rate flickers
};

/// Reads the recording three times: for its span and its read-outs, which no table is trusted to tell, to find the hot pixels,
/// and to count.
///
/// Of eight equal parts of the recording a pixel that a moving marker lights fires in a few, a hot one in most. A pixel is hot if
/// in seven of them at least it fires as often as `hot_pixel_hz` and ten standard deviations above the mean of all pixels in the
/// quietest part; or, since hot pixels are born and heal, if it does so in the last two or the first two parts, evenly, and in
/// the outer one, where no touch is expected, five times as often as any but one of the 24 pixels around it.
/// @throws Error  if the stream has no event or no sane size, or spans more than an hour (a run takes seconds)
EventRate event_rate(RecordingReader& recording, std::int32_t stream_id, const EventRateOptions& options = {});

/// Hands every event that `rate` counts, and its bin, to `use`, in file order.
/// @param rate  of this stream of this recording
void for_counted_events(RecordingReader& recording, std::int32_t stream_id, const EventRate& rate,
                        const std::function<void(const Event&, std::size_t)>& use);

}  // namespace tactile
