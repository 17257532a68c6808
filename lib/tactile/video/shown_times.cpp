#include "tactile/video/shown_times.hpp"

#include <algorithm>
#include <numeric>

namespace tactile::video {

std::vector<std::size_t> frame_indices(std::span<const std::optional<std::int64_t>> by_container,
                                       std::span<const std::int64_t> in_file) {
  std::vector<std::size_t> indices(by_container.size());
  std::iota(indices.begin(), indices.end(), std::size_t{0});
  if (in_file.empty()) return indices;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (!by_container[i]) continue;
    indices[i] = static_cast<std::size_t>(std::lower_bound(in_file.begin(), in_file.end(), *by_container[i]) - in_file.begin());
  }
  return indices;
}

std::vector<std::optional<VideoTime>> shown_times(std::span<const std::optional<std::int64_t>> by_container,
                                                  std::span<const std::int64_t> in_file, std::span<const VideoTime> rows) {
  const std::vector<std::size_t> indices = frame_indices(by_container, in_file);
  std::vector<std::optional<VideoTime>> times;
  times.reserve(by_container.size());
  for (std::size_t i = 0; i < by_container.size(); ++i) {
    const std::optional<std::int64_t>& us = by_container[i];
    std::optional<VideoTime> t;
    if (rows.empty()) {
      if (us && by_container.front()) t = VideoTime{microseconds{*us - *by_container.front()}};
    } else if (indices[i] < rows.size()) {
      t = rows[indices[i]];
    } else if (us && !in_file.empty()) {
      const std::int64_t after_last_row = *us - in_file[rows.size() - 1];
      t = VideoTime{microseconds{saturating_add(us_of(rows.back()), after_last_row)}};
    }
    times.push_back(t);
  }
  return times;
}

}  // namespace tactile::video
