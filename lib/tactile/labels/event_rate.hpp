#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tactile/events/recording_reader.hpp"

namespace tactile {

/// How many events a recording holds in each stretch of time, without its hot pixels.
struct EventRate {
  CameraTime begin{};     ///< the first event's time, where bin 0 begins
  microseconds bin{200};  ///< half-open: [begin + i * bin, begin + (i + 1) * bin)
  std::vector<std::uint32_t> counts;
  std::size_t hot_pixels = 0;      ///< left out
  CameraTime last{};               ///< the last event's time
  std::vector<std::uint32_t> hot;  ///< their places, y * width + x, ascending

  CameraTime begin_of(std::size_t bin_index) const { return after(begin, bin * static_cast<std::int64_t>(bin_index)); }
};

struct EventRateOptions {
  microseconds bin{200};       ///< a whole number of read-outs, > 0
  double hot_pixel_hz = 8.0;   ///< a pixel is hot if in at least seven of eight equal parts of the recording it fires at least so
                               ///< often, and ten standard deviations above the mean of all pixels in the quietest part
  double lone_pixel_hz = 200;  ///< so is one that starts or stops amid the recording: in two parts at least it fires so often,
                               ///< and eight times as often as the middle one of its eight neighbours
};

/// Reads the recording three times: for its span, which no table is trusted to tell, to find the hot pixels, and to count. A
/// pixel that a moving marker lights fires in a few of the eight parts only, a hot one in most; and blur lets no pixel fire
/// without its neighbours.
/// @throws Error  if the stream has no event or no sane size, or spans more than an hour (a run takes seconds)
EventRate event_rate(RecordingReader& recording, std::int32_t stream_id, const EventRateOptions& options = {});

/// Hands every event that `rate` counts, and its bin, to `use`, in file order.
/// @param rate  of this stream of this recording
void for_counted_events(RecordingReader& recording, std::int32_t stream_id, const EventRate& rate,
                        const std::function<void(const Event&, std::size_t)>& use);

}  // namespace tactile
