#include "tactile/pictures/moments.hpp"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <numeric>
#include <optional>
#include <span>
#include <string>

#include "tactile/core/error.hpp"

namespace tactile::pictures {
namespace {

constexpr std::size_t chunk = 8192;       // events that wait for their moment at the most
constexpr microseconds close_by = 100ms;  // windows nearer to each other are read in one go

std::span<std::uint8_t> pixels_of(cv::Mat& picture) { return {picture.data, picture.total()}; }

/// The renderers of one recording, and the pictures that they fill.
class MomentRenderer {
 public:
  MomentRenderer(events::SensorSize sensor, const heatmaps::HeatmapOptions& options, MomentDetail detail)
      : sensor_(sensor), renderer_(sensor, options) {
    moment_.counts.create(sensor.height, sensor.width, CV_16UC1);
    moment_.heatmap.create(renderer_.size().height, renderer_.size().width, CV_8UC1);
    if (detail == MomentDetail::heatmap) return;
    // A heatmap as large as the sensor is the denoised picture itself.
    heatmaps::HeatmapOptions unresized = options;
    unresized.factor = 1;
    unresized.resize = heatmaps::Resize::area;
    denoising_.emplace(sensor, unresized);
    moment_.denoised.create(sensor.height, sensor.width, CV_8UC1);
  }

  void add(std::span<const events::Event> events) {
    renderer_.add(events);
    if (denoising_) denoising_->add(events);
  }

  const Moment& at(CameraTime t) {
    renderer_.move_to(t);
    renderer_.render(pixels_of(moment_.heatmap));
    if (denoising_) {
      denoising_->move_to(t);
      denoising_->render(pixels_of(moment_.denoised));
    }
    moment_.t = t;
    moment_.events = renderer_.events();
    for (int y = 0; y < sensor_.height; ++y) {
      auto* const row = moment_.counts.ptr<std::uint16_t>(y);
      for (int x = 0; x < sensor_.width; ++x)
        row[x] = static_cast<std::uint16_t>(std::min<std::uint32_t>(renderer_.counts().at(x, y), 65535));
    }
    return moment_;
  }

 private:
  events::SensorSize sensor_;
  heatmaps::HeatmapRenderer renderer_;
  std::optional<heatmaps::HeatmapRenderer> denoising_;
  Moment moment_;
};

int bright_value(std::span<const std::uint64_t> pixels, double share, int otherwise) {
  const std::uint64_t all = std::accumulate(pixels.begin() + 1, pixels.end(), std::uint64_t{0});
  std::uint64_t below = 0;
  for (std::size_t value = 1; value < pixels.size(); ++value) {
    below += pixels[value];
    if (all > 0 && static_cast<double>(below) >= share * static_cast<double>(all)) return static_cast<int>(value);
  }
  return otherwise;
}

}  // namespace

void for_moments(events::RecordingReader& recording, std::int32_t stream_id, const heatmaps::HeatmapOptions& options,
                 std::span<const CameraTime> times, MomentDetail detail, const std::function<void(const Moment&)>& use) {
  const std::optional<events::SensorSize> sensor = recording.stream(stream_id).size;
  if (!sensor)
    throw Error(recording.file().string() + ": stream " + std::to_string(stream_id) + " declares no size; expected its sensor's");
  MomentRenderer renderer(*sensor, options, detail);
  std::size_t next = 0;
  for (std::size_t first = 0; first < times.size();) {
    std::size_t past_end = first + 1;
    while (past_end < times.size() && before(times[past_end], options.history) <= after(times[past_end - 1], close_by))
      ++past_end;
    const auto take = [&](std::span<const events::Event> events) {
      for (; !events.empty(); events = events.subspan(std::min(chunk, events.size()))) {
        const std::span<const events::Event> part = events.first(std::min(chunk, events.size()));
        try {
          renderer.add(part);
        } catch (const Error& e) {
          throw Error(recording.file().string() + ": " + e.what());
        }
        while (next < past_end && times[next] <= part.back().t) use(renderer.at(times[next++]));
      }
    };
    events::for_events_between(recording, stream_id, before(times[first], options.history), times[past_end - 1], take);
    while (next < past_end) use(renderer.at(times[next++]));
    first = past_end;
  }
}

void BrightnessMeter::add(const Moment& moment) {
  // By rows: OpenCV's iterators take ten times as long.
  for (int y = 0; y < moment.counts.rows; ++y)
    for (const std::uint16_t value : std::span(moment.counts.ptr<std::uint16_t>(y), static_cast<std::size_t>(moment.counts.cols)))
      ++count_pixels_[value];
  for (int y = 0; y < moment.heatmap.rows; ++y)
    for (const std::uint8_t value : std::span(moment.heatmap.ptr<std::uint8_t>(y), static_cast<std::size_t>(moment.heatmap.cols)))
      ++heatmap_pixels_[value];
}

Brightness BrightnessMeter::result() const {
  return {.counts = bright_value(count_pixels_, 0.995, 1), .heatmap = bright_value(heatmap_pixels_, 0.99, 255)};
}

}  // namespace tactile::pictures
