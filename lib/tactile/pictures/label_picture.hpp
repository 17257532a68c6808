#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tactile/alignment/event_rate.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/pictures/gnuplot.hpp"

namespace tactile::pictures {

/// The signal of a trace, which decides its panel. Panels follow in this order under the panel of the events.
enum class TraceKind : std::uint8_t {
  tcp_speed,     ///< [mm/s]
  tcp_height,    ///< [mm], in the panel of the speed
  stage_output,  ///< an output's value, which holds until the next; several are drawn over each other
  acceleration,  ///< of the camera, by its IMU [g]
  video_energy,  ///< motion in the video [any unit]
};

/// A signal in camera time.
struct Trace {
  TraceKind kind = TraceKind::tcp_speed;
  std::string name;              ///< shown where a panel has several traces: "x", "digital output 0"
  std::vector<CameraTime> t{};   ///< ascending
  std::vector<double> values{};  ///< one for each time; NaN is a gap
};

/// The signals and labels of a run, for a person who checks the labels.
struct LabelPicture {
  std::string title;
  alignment::EventRate rate;
  std::vector<Trace> traces;  ///< a panel without any is left out, and named
  labels::Labels labels;
  CameraTime begin{}, end{};         ///< what is shown; times count from `begin`
  std::vector<std::string> remarks;  ///< written under the panels
};

/// The picture as a figure 1600 pixels wide: panels one under the other on one axis of camera time, presses blue and slips
/// orange, darker in the 95 % interval of onset and end. On the right up to four onsets, slips first, then flagged ones, with 60
/// ms before and after. Below clocks, remarks and flags in words.
Plot label_plot(const LabelPicture& picture);

/// Draws it as PNG or SVG. @throws Error as `draw` does
void draw_label_picture(const LabelPicture& picture, const std::filesystem::path& file);

}  // namespace tactile::pictures
