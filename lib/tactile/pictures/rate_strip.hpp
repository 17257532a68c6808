#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "tactile/core/touch.hpp"
#include "tactile/pictures/event_curve.hpp"

namespace tactile::pictures {

/// The event rate over a stretch of camera time as a strip of a picture, with the labels above it: presses blue, slips orange,
/// each named where there is room. The square root of the rate is drawn, so that quiet and motion are both seen; a column of
/// pixels shows the highest value in it.
class RateStrip {
 public:
  static constexpr int height = 160;  ///< [px]

  /// @param begin, end  what is shown, begin < end
  /// @param zero        where printed times begin
  /// @param place       where in the picture, `height` high, and wide enough for the axis: 200 px at least
  RateStrip(CameraTime begin, CameraTime end, CameraTime zero, const cv::Rect& place);

  void draw(cv::Mat& picture, const EventCurve& curve, std::span<const TouchInterval> intervals) const;

  /// A line at `t`, and before it as a grey area the history [t - t_h, t).
  void draw_cursor(cv::Mat& picture, CameraTime t, microseconds history) const;

  /// A small triangle on the axis for each time.
  void draw_marks(cv::Mat& picture, std::span<const CameraTime> times) const;

  int column_of(CameraTime t) const;  ///< held within the strip's axis

 private:
  cv::Rect area() const;  ///< that of the curve
  CameraTime time_of(int column) const;
  void draw_time_axis(cv::Mat& picture) const;
  void draw_rate_axis(cv::Mat& picture, double highest_root) const;

  CameraTime begin_, end_, zero_;
  cv::Rect place_;
};

}  // namespace tactile::pictures
