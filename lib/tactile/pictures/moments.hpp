#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "tactile/events/recording_reader.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"

namespace tactile::pictures {

/// What a sensor saw in [t - t_h, t), from its events to the heatmap.
struct Moment {
  CameraTime t{};
  std::uint64_t events = 0;
  cv::Mat counts;    ///< [sensor height, width] uint16: events per pixel, 65535 where there are more
  cv::Mat denoised;  ///< [sensor height, width] uint8: 255 D / max D; empty where it was not asked for
  cv::Mat heatmap;   ///< [height, width] uint8: what the dataset holds and the network sees
};

enum class MomentDetail : std::uint8_t { heatmap, all };

/// Hands the moments at `times` to `use`, in order; its pictures are valid until it returns. Reads the packets that overlap their
/// windows, each once where windows overlap; memory follows the packet and the history.
///
/// @param times    ascending; need be no ticks
/// @throws Error   if the stream declares no size or its events go back in time, naming the file, or as `check` of the options
void for_moments(events::RecordingReader& recording, std::int32_t stream_id, const heatmaps::HeatmapOptions& options,
                 std::span<const CameraTime> times, MomentDetail detail, const std::function<void(const Moment&)>& use);

/// What the colours of pictures of several moments reach to, so that a few hot pixels do not darken the rest.
struct Brightness {
  int counts = 1;     ///< not exceeded by 99.5 of 100 pixels with events
  int heatmap = 255;  ///< not exceeded by 99 of 100 heatmap pixels that are not 0
};

/// Learns the brightness of moments one by one.
class BrightnessMeter {
 public:
  void add(const Moment& moment);
  Brightness result() const;

 private:
  std::vector<std::uint64_t> count_pixels_ = std::vector<std::uint64_t>(65536);  // by their value
  std::vector<std::uint64_t> heatmap_pixels_ = std::vector<std::uint64_t>(256);
};

}  // namespace tactile::pictures
