#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/pictures/event_curve.hpp"
#include "tactile/pictures/moments.hpp"
#include "tactile/pictures/rate_strip.hpp"

namespace tactile::pictures {

/// What the pictures of a film have in common.
struct EventFilmOptions {
  std::string title;
  std::string remark;  ///< at the right of the title
  events::SensorSize sensor;
  heatmaps::HeatmapOptions rendering;
  Brightness brightness;
  CameraTime begin{}, end{};  ///< shown in the strip, begin < end
  CameraTime zero{};          ///< where printed times begin
  std::vector<TouchInterval> intervals = {};
  bool is_labelled = false;  ///< then a moment outside all intervals is none, else it is unknown
};

/// The pictures of a film of events: side by side the events per pixel and the heatmap, framed in the colour of the label, over
/// them the time and the label in words, under them the event rate with the labels and a cursor.
class EventFilm {
 public:
  /// @throws Error  as `check` of the rendering
  EventFilm(EventFilmOptions options, const EventCurve& curve);

  cv::Size size() const { return background_.size(); }  ///< even, as video encoders need it

  cv::Mat picture_of(const Moment& moment) const;  ///< [height, width] BGR of 8 bits

  std::optional<Touch> touch_at(CameraTime t) const;  ///< nothing without labels

 private:
  EventFilmOptions options_;
  cv::Size shown_;
  cv::Rect counts_place_, heatmap_place_;
  RateStrip strip_;
  cv::Mat background_;
};

}  // namespace tactile::pictures
