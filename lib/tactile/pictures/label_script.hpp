#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tactile/pictures/label_picture.hpp"
#include "tactile/pictures/plot_writer.hpp"

namespace tactile::pictures {

// What the panels of a label picture, its enlarged onsets and its words share.

namespace label_colours {
inline constexpr std::string_view robot = "#1B7F3B", height = "#8A6D00", video = "#8E24AA", imu = "#00838F", flag = "#B00000",
                                  release = "#E8E8E8";
}

/// "+1.5", "−0.3"
std::string signed_ms(double value);

double highest_of(const std::vector<PlotPoint>& points);  ///< 1 where none is above 0

/// A label picture in the making.
class LabelScript : public PlotWriter {
 public:
  explicit LabelScript(const LabelPicture& picture);

  const LabelPicture& picture() const { return picture_; }
  double seconds() const { return seconds_; }  ///< shown
  double seconds_from_begin(CameraTime t) const;
  double shown(CameraTime t) const;  ///< seconds from the start, clamped to what is shown

  /// Forgets the settings of the panel before. The picture's own words were drawn with the first.
  void begin_panel(const PlotBox& box, double x_low, double x_high);
  double pixel() const { return pixel_; }  ///< on the x axis of the panel

  /// The square root of the events per ms, since its noise is the same for low and high rates.
  /// @param bin             about, a multiple of the rate's own bin is used
  /// @param from_us, to_us  from the rate's start
  /// @param unit_us         of the x axis, whose 0 is at `zero_us`
  std::vector<PlotPoint> root_rate(microseconds bin, double from_us, double to_us, double unit_us, double zero_us) const;

  /// Labels the tics of a y axis of square roots with the squares.
  void square_tics(double highest);

 private:
  const LabelPicture& picture_;
  double seconds_;
  double pixel_ = 0;
  bool begun_ = false;
};

}  // namespace tactile::pictures
