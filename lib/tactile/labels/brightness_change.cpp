#include "tactile/labels/brightness_change.hpp"

#include <cmath>

#include "tactile/core/error.hpp"

namespace tactile {
namespace {

constexpr int block_px = 4;

}  // namespace

std::vector<BrightnessChange> brightness_changes(RecordingReader& recording, std::int32_t stream_id,
                                                 std::span<const CameraSpan> spans, std::span<const std::uint32_t> hot_pixels) {
  const Stream& stream = recording.stream(stream_id);
  if (!stream.size) throw Error(recording.file().string() + ": its event stream declares no size; expected sizeX and sizeY");
  const auto width = static_cast<std::size_t>(stream.size->width), height = static_cast<std::size_t>(stream.size->height);
  const std::size_t columns = (width + block_px - 1) / block_px, rows = (height + block_px - 1) / block_px;
  std::vector<bool> is_hot(width * height);
  for (const std::uint32_t pixel : hot_pixels) is_hot.at(pixel) = true;
  std::vector<BrightnessChange> changes;
  for (const CameraSpan& span : spans) {
    BrightnessChange& change = changes.emplace_back();
    change.blocks.resize(columns * rows);
    for_events_between(recording, stream_id, span.begin, span.end, [&](std::span<const Event> events) {
      for (const Event& event : events) {
        const auto x = static_cast<std::size_t>(event.x), y = static_cast<std::size_t>(event.y);
        if (is_hot[y * width + x]) continue;
        change.blocks[y / block_px * columns + x / block_px] += event.on != 0 ? 1.0F : -1.0F;
      }
    });
  }
  return changes;
}

double likeness(const BrightnessChange& a, const BrightnessChange& b) {
  double aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < a.blocks.size() && i < b.blocks.size(); ++i) {
    aa += static_cast<double>(a.blocks[i]) * a.blocks[i];
    bb += static_cast<double>(b.blocks[i]) * b.blocks[i];
    ab += static_cast<double>(a.blocks[i]) * b.blocks[i];
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0.0;
}

}  // namespace tactile
