#include "tactile/alignment/frame_differences.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "tactile/core/robust_statistics.hpp"

namespace tactile::alignment {

cv::Mat1f smoothed(const cv::Mat& grey) {
  const cv::Mat1f kernel = (cv::Mat1f(1, 5) << 1, 4, 6, 4, 1);
  cv::Mat1f picture;
  cv::sepFilter2D(grey, picture, CV_32F, kernel, kernel, {-1, -1}, 0, cv::BORDER_REPLICATE | cv::BORDER_ISOLATED);
  return picture;
}

/// From about a thousand pixels on a grid. The gradient of the line is the ratio of the standard deviations: noise, which both
/// frames have alike, does not lower it as it does in a line of least squares.
FrameComparison::Brightness FrameComparison::fit_brightness(const cv::Mat1f& before, const cv::Mat1f& now) {
  constexpr int rounds = 3;
  constexpr double pixels_wanted = 1200, changed_by = 0.01;
  constexpr float outlier = 3 * static_cast<float>(sigma_per_median), least_outlier = 128;
  const int grid = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(now.cols) * now.rows / pixels_wanted)));
  pairs_.clear();
  for (int y = grid / 2; y < now.rows; y += grid) {
    for (int x = grid / 2; x < now.cols; x += grid) pairs_.push_back({before(y, x), now(y, x)});
  }
  Brightness found;
  float limit = std::numeric_limits<float>::infinity();
  double mean_before = 0, mean_now = 0;
  for (int round = 0; round < rounds; ++round) {
    double n = 0, x = 0, y = 0, xx = 0, yy = 0;
    for (const auto& [p, q] : pairs_) {
      if (std::abs(q - found.gain * p - found.offset) > limit) continue;
      n += 1;
      x += p;
      y += q;
      xx += double{p} * p;
      yy += double{q} * q;
    }
    if (n < 3) break;
    const double x_spread = xx - x * x / n, y_spread = yy - y * y / n;
    const double gain = x_spread > n && y_spread > 0 ? std::clamp(std::sqrt(y_spread / x_spread), 0.5, 2.0) : 1.0;
    found.gain = static_cast<float>(gain);
    found.offset = static_cast<float>((y - gain * x) / n);
    mean_before = x / n;
    mean_now = y / n;
    if (round + 1 == rounds) break;
    residuals_.clear();
    for (const auto& [p, q] : pairs_) residuals_.push_back(std::abs(q - found.gain * p - found.offset));
    limit = outlier * median<float>(residuals_) + least_outlier;
  }
  found.changed = std::abs(mean_now - mean_before) > changed_by * std::max(mean_before, 256.0);
  return found;
}

FrameDifference FrameComparison::compare(const cv::Mat1f& before, const cv::Mat1f& now, const cv::Rect& region) {
  FrameDifference result;
  result.same = cv::norm(before, now, cv::NORM_INF) == 0;
  if (result.same) return result;
  const Brightness line = fit_brightness(before, now);
  result.brightness = line.changed;
  count(before, now, region, line);
  result.noise = static_cast<float>(median<std::uint16_t>(largest_)) / 256;

  // From the greatest change down. Changes below half a grey level, which most pixels have, are not counted.
  constexpr std::size_t least_bin = bins_per_grey / 2;
  const double pixels = static_cast<double>(region.width) * region.height;
  double sum_above = 0;
  std::size_t level = threshold_count;
  for (std::size_t bin = bins; bin-- > least_bin;) {
    double counted = 0;
    for (const auto& table : tables_) counted += table[bin];
    sum_above += counted * (static_cast<double>(bin) + 0.5) / bins_per_grey;
    while (level > 0 && threshold_at(level - 1) * bins_per_grey >= static_cast<double>(bin))
      result.above[--level] = static_cast<float>(sum_above / pixels);
  }
  return result;
}

/// Fills the tables with the changes of all pixels, and sets the largest change of each part.
void FrameComparison::count(const cv::Mat1f& before, const cv::Mat1f& now, const cv::Rect& region, const Brightness& line) {
  constexpr float saturated = 230 * 256;
  constexpr int most_parts = 8, least_part = 16;  // [px] in each direction; motion is in less than half of the parts
  for (auto& table : tables_) table.fill(0);
  const auto parts_of = [&](int side) { return static_cast<std::size_t>(std::clamp(side / least_part, 1, most_parts)); };
  const std::size_t columns = parts_of(region.width), rows = parts_of(region.height);
  largest_.assign(columns * rows, 0);
  const auto width = static_cast<std::size_t>(region.width);
  changes_.assign((width + table_count - 1) / table_count * table_count, 0);
  for (int y = region.y; y < region.y + region.height; ++y) {
    const float *p = before.ptr<float>(y) + region.x, *q = now.ptr<float>(y) + region.x;
    for (std::size_t x = 0; x < width; ++x)
      changes_[x] = static_cast<std::uint16_t>(std::min(std::abs(q[x] - line.gain * p[x] - line.offset), 65535.0F));
    if (line.changed) {  // what was white cannot become whiter
      for (std::size_t x = 0; x < width; ++x)
        if (std::max(p[x], q[x]) >= saturated) changes_[x] = 0;
    }
    const std::size_t row = static_cast<std::size_t>(y - region.y) * rows / static_cast<std::size_t>(region.height);
    for (std::size_t column = 0; column < columns; ++column) {
      std::uint16_t& largest = largest_[row * columns + column];
      for (std::size_t x = column * width / columns; x < (column + 1) * width / columns; ++x)
        largest = std::max(largest, changes_[x]);
    }
    count_row();
  }
}

void FrameComparison::count_row() {
  constexpr std::uint64_t any_counted = 0xff80'ff80'ff80'ff80;  // of four changes, half a grey level or more
  constexpr unsigned shift = 5;                                 // 256 / bins_per_grey
  for (std::size_t x = 0; x < changes_.size(); x += table_count) {
    std::uint64_t four = 0;
    std::memcpy(&four, changes_.data() + x, sizeof(four));
    if ((four & any_counted) == 0) continue;
    for (std::size_t i = 0; i < table_count; ++i) ++tables_[i][changes_[x + i] >> shift];
  }
}

}  // namespace tactile::alignment
