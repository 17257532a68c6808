#include "tactile/pictures/frames_picture.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>

#include "tactile/core/error.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/core/ticks.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/pictures/moments.hpp"
#include "tactile/pictures/plot_script.hpp"

namespace tactile::pictures {
namespace {

constexpr int widest_raw = 320;  // [cells] of a raw frame, which is drawn half as wide

/// Sums over blocks, so that a frame is not larger than it can be shown.
cv::Mat raw_frame(const cv::Mat& counts) {
  const int step = (std::max(counts.cols, counts.rows) + widest_raw - 1) / widest_raw;
  cv::Mat frame = cv::Mat::zeros((counts.rows + step - 1) / step, (counts.cols + step - 1) / step, CV_32F);
  for (int y = 0; y < counts.rows; ++y) {
    for (int x = 0; x < counts.cols; ++x)
      frame.at<float>(y / step, x / step) += static_cast<float>(counts.at<std::uint16_t>(y, x));
  }
  return frame;
}

/// What 995 of 1000 cells with a value stay below in all frames, so that a few hot pixels do not darken the rest.
template <class T>
double bright_value(const std::vector<TouchFrame>& frames, cv::Mat TouchFrame::*picture) {
  std::vector<T> values;
  for (const TouchFrame& frame : frames) {
    const cv::Mat& cells = frame.*picture;
    std::copy_if(cells.begin<T>(), cells.end<T>(), std::back_inserter(values), [](T value) { return value > 0; });
  }
  if (values.empty()) return 1;
  return static_cast<double>(value_of_rank<T>(values, (values.size() - 1) * 995 / 1000));
}

/// As gnuplot reads a matrix: rows from the bottom to the top.
template <class T>
std::vector<double> matrix(const cv::Mat& picture) {
  std::vector<double> values;
  values.reserve(picture.total());
  for (int y = picture.rows; y-- > 0;) {
    for (int x = 0; x < picture.cols; ++x) values.push_back(static_cast<double>(picture.at<T>(y, x)));
  }
  return values;
}

}  // namespace

std::vector<TouchFrame> frames_of(const RunFolder& run, const heatmaps::HeatmapOptions& options) {
  check(options);
  std::vector<TouchFrame> frames;
  if (!std::filesystem::exists(run.labels())) return frames;
  const labels::Labels labels = labels::read_labels(run.labels());
  events::RecordingReader recording(run.events());
  const events::Stream& stream = events::event_stream(recording);
  for (const Touch touch : {Touch::press, Touch::slip}) {
    const auto found = std::find_if(labels.intervals.begin(), labels.intervals.end(),
                                    [touch](const labels::LabelledInterval& interval) { return interval.touch == touch; });
    if (found == labels.intervals.end()) continue;
    std::vector<CameraTime> times;
    for (const std::chrono::milliseconds offset : {-10ms, 30ms, 100ms})
      times.push_back(first_tick_from(after(found->interval().start, offset), options.tick));
    for_moments(recording, stream.id, options, times, MomentDetail::heatmap, [&](const Moment& moment) {
      const double ms = static_cast<double>(between(found->interval().start, moment.t).count()) / 1000;
      frames.push_back({.caption = fmt::format("{:.0f} ms {} {}", std::abs(ms), ms < 0 ? "before" : "into", name_of(touch)),
                        .touch = ms < 0 ? Touch::none : touch,
                        .events = moment.events,
                        .raw = raw_frame(moment.counts),
                        .heatmap = moment.heatmap.clone()});
    });
  }
  return frames;
}

Plot frames_plot(const std::string& title, const std::vector<TouchFrame>& frames) {
  constexpr int width = 600, left = 84, right = 16, gap = 8, caption_height = 24, between = 30, below = 18, columns = 3;
  constexpr std::size_t most = 6;
  if (frames.empty()) throw Error("frames: none to draw; expected one at least");
  for (const TouchFrame& frame : frames) {
    if (frame.raw.empty() || frame.raw.type() != CV_32FC1 || frame.heatmap.empty() || frame.heatmap.type() != CV_8UC1)
      throw Error("frames: one is no pair of pictures; expected counts as float32 and a heatmap as bytes");
  }
  const int shown = static_cast<int>(std::min(frames.size(), most));
  const int tile_width = (width - left - right - (columns - 1) * gap) / columns;
  const auto height_of = [&](const cv::Mat& picture) { return std::clamp(tile_width * picture.rows / picture.cols, 30, 400); };
  const int raw_height = height_of(frames[0].raw), heatmap_height = height_of(frames[0].heatmap);
  const int row_height = caption_height + raw_height + between + heatmap_height + below;
  const PlotHead head(title, width);
  PlotScript script(head, head.bottom() + (shown + columns - 1) / columns * row_height + below);
  const double brightest_raw = bright_value<float>(frames, &TouchFrame::raw);
  const double brightest = bright_value<std::uint8_t>(frames, &TouchFrame::heatmap);
  // From black to light yellow, ever brighter: readable without colours too.
  script.add("set palette defined (0 '#000004', 0.25 '#420A68', 0.45 '#932667', 0.65 '#DD513A', 0.85 '#FCA50A', 1 '#FCFFA4')");
  script.add("unset colorbox");
  for (int i = 0; i < shown; ++i) {
    const TouchFrame& frame = frames[static_cast<std::size_t>(i)];
    const int begin = left + i % columns * (tile_width + gap);
    const int raw_top = head.bottom() + i / columns * row_height + caption_height + 10;
    const int heatmap_top = raw_top + raw_height + between;
    for (const bool is_raw : {true, false}) {
      const cv::Mat& picture = is_raw ? frame.raw : frame.heatmap;
      const int tile_top = is_raw ? raw_top : heatmap_top;
      script.begin_panel({.left = begin,
                          .top = tile_top,
                          .right = begin + tile_width,
                          .bottom = tile_top + (is_raw ? raw_height : heatmap_height)});
      if (i % columns == 0) {
        const double middle = tile_top + (is_raw ? raw_height : heatmap_height) / 2.0;
        script.text(is_raw ? "counts" : "heatmap", left - 8, middle, "right font ',11'");
      }
      if (is_raw) {
        script.text(shortened(frame.caption, 26), begin + tile_width / 2.0, raw_top - 12, "center font ',11'",
                    figure_colours::of(frame.touch));
        script.text(fmt::format("{} events", frame.events), begin + tile_width / 2.0, raw_top + raw_height + 14,
                    "center font ',10'", figure_colours::faint_ink);
      }
      script.add("unset grid\nunset xtics\nunset ytics\nset border 15 lc rgb '{}' lw 0.8", figure_colours::faint_ink);
      script.add("set xrange [-0.5:{}.5]\nset yrange [-0.5:{}.5]\nset cbrange [0:1]", picture.cols - 1, picture.rows - 1);
      const std::string table =
          script.table(static_cast<std::size_t>(picture.cols), is_raw ? matrix<float>(picture) : matrix<std::uint8_t>(picture));
      // By the square root, or a slip's many events would leave a press dark.
      script.add("plot {} matrix using 1:2:(sqrt($3 / {:.9g})) with image notitle", table, is_raw ? brightest_raw : brightest);
    }
  }
  return std::move(script).finished();
}

}  // namespace tactile::pictures
