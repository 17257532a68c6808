#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tactile/labels/event_rate.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/report/gnuplot.hpp"

namespace tactile {

/// What a trace shows, and so in which panel it is drawn; panels follow each other in this order under that of the events.
enum class TraceKind : std::uint8_t {
  tcp_speed,     ///< [mm/s]
  tcp_height,    ///< [mm], in the panel of the speed
  stage_output,  ///< an output's value, which holds until the next; several are drawn over each other
  acceleration,  ///< of the camera, by its IMU [g]
  video_energy,  ///< how much moves in the film [any unit]
};

/// A signal in camera time.
struct Trace {
  TraceKind kind = TraceKind::tcp_speed;
  std::string name;              ///< told where a panel has several: "x", "digital output 0"
  std::vector<CameraTime> t{};   ///< ascending
  std::vector<double> values{};  ///< one for each time; NaN is a gap
};

/// What a person needs to judge the labels of a run.
struct LabelPicture {
  std::string title;
  EventRate rate;
  std::vector<Trace> traces;  ///< a panel without any is left out, and named
  Labels labels;
  CameraTime begin{}, end{};         ///< what is shown; times count from `begin`
  std::vector<std::string> remarks;  ///< told in words under the panels
};

/// The picture as a figure 1600 pixels wide: panels one under the other on one axis of camera time, presses blue and slips
/// orange, darker where their onset and their end may lie (95 %); beside them up to four onsets, slips first, then flagged ones,
/// with 60 ms before and behind; clocks, remarks and flags in words.
Plot label_plot(const LabelPicture& picture);

/// Draws it as PNG or SVG. @throws Error as `draw` does
void draw_label_picture(const LabelPicture& picture, const std::filesystem::path& file);

}  // namespace tactile
