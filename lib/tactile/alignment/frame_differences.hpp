#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace tactile::alignment {

// Thresholds of a pixel's change: a fourth of an octave apart, from half a grey level on.
constexpr std::size_t threshold_count = 28;
inline double threshold_at(std::size_t i) { return 0.5 * std::exp2(0.25 * static_cast<double>(i)); }  ///< [grey levels]

/// A grey picture, smoothed with the kernel 1 4 6 4 1 in both directions, in 1/256 grey levels.
cv::Mat1f smoothed(const cv::Mat& grey);

/// How a frame differs from the one before it.
struct FrameDifference {
  bool same = false;                           ///< in every bit
  bool brightness = false;                     ///< the brightness changed by more than a hundredth
  float noise = 0;                             ///< median over parts of the picture of the largest change in each [grey levels]
  std::array<float, threshold_count> above{};  ///< mean of the changes above each threshold [grey levels]
};

/// Compares smoothed frames. The brightness a I + b that fits best from frame to frame is taken off first.
class FrameComparison {
 public:
  /// @param region  of the pictures: only changes inside count
  FrameDifference compare(const cv::Mat1f& before, const cv::Mat1f& now, const cv::Rect& region);

 private:
  static constexpr std::size_t bins_per_grey = 8, bins = 256 * bins_per_grey, table_count = 4;

  struct Brightness {
    float gain = 1, offset = 0;
    bool changed = false;
  };

  Brightness fit_brightness(const cv::Mat1f& before, const cv::Mat1f& now);
  void count(const cv::Mat1f& before, const cv::Mat1f& now, const cv::Rect& region, const Brightness& line);
  void count_row();

  std::vector<std::array<float, 2>> pairs_;
  std::vector<float> residuals_;
  std::vector<std::uint16_t> changes_;  ///< of one row
  std::vector<std::uint16_t> largest_;  ///< change in each part
  /// Several, so that equal neighbours do not wait for each other.
  std::array<std::array<std::uint32_t, bins>, table_count> tables_{};
};

}  // namespace tactile::alignment
