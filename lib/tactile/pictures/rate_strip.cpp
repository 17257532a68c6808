#include "tactile/pictures/rate_strip.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "tactile/core/duration_units.hpp"
#include "tactile/pictures/drawing.hpp"

namespace tactile::pictures {
namespace {

constexpr int left_of_plot = 58, right_of_plot = 16, label_row = 24, axis_row = 32;
constexpr double tick_size = 0.42, name_size = 0.5;
const cv::Scalar curve_line{70, 70, 70}, curve_area{160, 160, 160}, grid{225, 225, 225};

/// 1, 2 or 5 times a power of ten, at least `least`.
double round_step(double least) {
  const double decade = std::pow(10.0, std::floor(std::log10(least)));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (step * decade >= least) return step * decade;
  }
  return 10 * decade;
}

/// Under the axis, pointing at it: what is named above the curve stays free.
void draw_triangle(cv::Mat& picture, cv::Point tip, int half, const cv::Scalar& colour) {
  const std::vector<cv::Point> corners{{tip.x, tip.y + 1}, {tip.x - half, tip.y + 2 * half}, {tip.x + half, tip.y + 2 * half}};
  cv::fillConvexPoly(picture, corners, colour, cv::LINE_AA);
}

}  // namespace

RateStrip::RateStrip(CameraTime begin, CameraTime end, CameraTime zero, const cv::Rect& place)
    : begin_(begin), end_(end), zero_(zero), place_(place) {}

cv::Rect RateStrip::area() const {
  return {place_.x + left_of_plot, place_.y + label_row, place_.width - left_of_plot - right_of_plot,
          place_.height - label_row - axis_row};
}

int RateStrip::column_of(CameraTime t) const {
  const cv::Rect curve = area();
  const double share = in_ms(between(begin_, t)) / in_ms(between(begin_, end_));
  return curve.x + static_cast<int>(std::lround(std::clamp(share, 0.0, 1.0) * (curve.width - 1)));
}

CameraTime RateStrip::time_of(int column) const {
  const cv::Rect curve = area();
  const double share = static_cast<double>(column - curve.x) / curve.width;
  return after(begin_, microseconds{static_cast<std::int64_t>(share * static_cast<double>(between(begin_, end_).count()))});
}

void RateStrip::draw(cv::Mat& picture, const EventCurve& curve, std::span<const TouchInterval> intervals) const {
  const cv::Rect plot = area();
  int free_from = plot.x;  // labels that are near each other do not cover each other
  for (const TouchInterval& interval : intervals) {
    if (interval.end < begin_ || interval.start > end_) continue;
    const int from = column_of(interval.start), to = std::max(from + 1, column_of(interval.end));
    cv::rectangle(picture, {from, plot.y, to - from, plot.height}, light_touch_colour(interval.touch), cv::FILLED);
    cv::rectangle(picture, {from, plot.y - 5, to - from, 5}, touch_colour(interval.touch), cv::FILLED);
    const std::string name(name_of(interval.touch));
    const int at = std::max(free_from, std::min(from, plot.br().x - text_width(name, name_size)));
    if (at > from + 40 || at + text_width(name, name_size) > place_.br().x) continue;
    free_from = at + 10 + draw_text(picture, name, {at, plot.y - 9}, name_size, plot.width, touch_colour(interval.touch));
  }

  std::vector<double> roots;
  for (int x = plot.x; x < plot.br().x; ++x) roots.push_back(std::sqrt(curve.most_per_ms(time_of(x), time_of(x + 1))));
  const double highest = 1.08 * std::max(1e-3, *std::max_element(roots.begin(), roots.end()));
  draw_rate_axis(picture, highest);
  draw_time_axis(picture);
  const auto row_of = [&](double root) { return plot.br().y - static_cast<int>(std::lround(root / highest * plot.height)); };
  int before = row_of(roots.front());
  for (std::size_t i = 0; i < roots.size(); ++i) {
    const int x = plot.x + static_cast<int>(i), top = row_of(roots[i]);
    cv::line(picture, {x, top}, {x, plot.br().y}, curve_area);
    cv::line(picture, {x, before}, {x, top}, curve_line);
    before = top;
  }
  cv::line(picture, {plot.x, plot.br().y}, {plot.br().x, plot.br().y}, ink);
}

void RateStrip::draw_rate_axis(cv::Mat& picture, double highest_root) const {
  const cv::Rect plot = area();
  draw_text(picture, "events/ms", {place_.x, plot.y - 9}, tick_size, left_of_plot + 30, faint_ink);
  const auto mark = [&](double rate, int y) {
    const std::string text = fmt::format("{:g}", rate);
    draw_text(picture, text, {plot.x - 6 - text_width(text, tick_size), y + 4}, tick_size, left_of_plot, faint_ink);
    cv::line(picture, {plot.x, y}, {plot.br().x - 1, y}, grid);
  };
  mark(0, plot.br().y);
  int above = plot.br().y;
  for (double decade = 1e-3; decade <= highest_root * highest_root; decade *= 10) {
    for (const double step : {1.0, 2.0, 5.0}) {
      const int y = plot.br().y - static_cast<int>(std::lround(std::sqrt(step * decade) / highest_root * plot.height));
      if (y < plot.y + 5 || above - y < 18) continue;
      mark(step * decade, y);
      above = y;
    }
  }
}

void RateStrip::draw_time_axis(cv::Mat& picture) const {
  const cv::Rect plot = area();
  const double from_ms = in_ms(between(zero_, begin_)), to_ms = in_ms(between(zero_, end_));
  const double step = round_step((to_ms - from_ms) * 90 / plot.width);
  const double first = std::ceil(from_ms / step) * step;
  for (int i = 0; first + i * step <= to_ms + 1e-9 && i < plot.width; ++i) {
    const double ms = first + i * step;
    const int x = plot.x + static_cast<int>(std::lround((ms - from_ms) / (to_ms - from_ms) * (plot.width - 1)));
    const std::string text = fmt::format("{:.10g} ms", std::abs(ms) < 1e-9 ? 0.0 : ms);
    const int width = text_width(text, tick_size);
    if (x - width / 2 < place_.x || x + width / 2 > place_.br().x) continue;
    cv::line(picture, {x, plot.br().y}, {x, plot.br().y + 4}, ink);
    draw_text(picture, text, {x - width / 2, plot.br().y + 25}, tick_size, width, faint_ink);
  }
}

void RateStrip::draw_cursor(cv::Mat& picture, CameraTime t, microseconds history) const {
  const cv::Rect plot = area();
  const int x = column_of(t), from = column_of(before(t, history));
  if (x > from) {
    cv::Mat window = picture(cv::Rect(from, plot.y, x - from, plot.height));
    cv::Mat(window * 0.8).copyTo(window);
  }
  cv::line(picture, {x, plot.y}, {x, plot.br().y}, cv::Scalar(0, 0, 0), 2);
  draw_triangle(picture, {x, plot.br().y}, 6, cv::Scalar(0, 0, 0));
}

void RateStrip::draw_marks(cv::Mat& picture, std::span<const CameraTime> times) const {
  const cv::Rect plot = area();
  for (const CameraTime t : times) draw_triangle(picture, {column_of(t), plot.br().y}, 4, ink);
}

}  // namespace tactile::pictures
