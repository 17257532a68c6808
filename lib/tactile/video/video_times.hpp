#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "tactile/core/time.hpp"

namespace tactile::video {

/// The times of a video's frames, in the order of the frames: column `pts_us` of `video.csv`, whose `index` counts from 0.
/// Further columns are ignored, and so is a last row without its newline, which a kill has cut.
/// @throws Error  naming the row if a value is no whole number, an index is skipped, a time does not ascend or a row is
///                longer than 4095 bytes
std::vector<VideoTime> read_video_times(const std::filesystem::path& file);

/// Writes `index,pts_us`, whole or not at all.
void write_video_times(const std::filesystem::path& file, std::span<const VideoTime> times);

}  // namespace tactile::video
