#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tactile/core/time.hpp"

namespace tactile::video {

/// The place of each decoded frame among all frames of its file, in the order they are shown: by its time, since some frames may
/// not be decodable; in the order they were decoded where it or the file has no times.
/// @param by_container  of each decoded frame [us], as `FilmReader::Frame` has it
/// @param in_file       `FilmReader::frame_times`
std::vector<std::size_t> frame_indices(std::span<const std::optional<std::int64_t>> by_container,
                                       std::span<const std::int64_t> in_file);

/// Each decoded frame's time on the video's clock: by its row of video.csv where there is one. After the last row the container's
/// times follow, shifted. Without rows they are the container's own, the first decoded frame being at 0. Nothing where a frame
/// has no time.
/// @param rows  of video.csv; may be empty
std::vector<std::optional<VideoTime>> shown_times(std::span<const std::optional<std::int64_t>> by_container,
                                                  std::span<const std::int64_t> in_file, std::span<const VideoTime> rows);

}  // namespace tactile::video
