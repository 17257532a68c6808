#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile {

/// By how much a stretch of time left each part of the picture brighter or darker: events that say brighter minus those that say
/// darker, in blocks of 4x4 pixels, row by row. What flickers or moves to and fro cancels out, and so does noise.
struct BrightnessChange {
  std::vector<float> blocks;
};

/// A stretch of camera time, half-open.
struct CameraSpan {
  CameraTime begin{}, end{};
};

/// One for each span; they may overlap.
/// @param hot_pixels  y * width + x of those to be left out
std::vector<BrightnessChange> brightness_changes(RecordingReader& recording, std::int32_t stream_id,
                                                 std::span<const CameraSpan> spans, std::span<const std::uint32_t> hot_pixels);

/// The cosine of the angle between the two, -1 to 1: 1 for the same motion once more, -1 for one that was taken back, about 0 for
/// another. 0 where one of them is nothing.
double likeness(const BrightnessChange& a, const BrightnessChange& b);

}  // namespace tactile
