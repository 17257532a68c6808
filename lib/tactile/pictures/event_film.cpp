#include "tactile/pictures/event_film.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>
#include <string>
#include <tuple>
#include <utility>

#include "tactile/core/duration_units.hpp"
#include "tactile/pictures/drawing.hpp"

namespace tactile::pictures {
namespace {

constexpr int margin = 20, gap = 24, border = 6;
constexpr int title_line = 34, time_line = 44, caption_line = 30;
constexpr int shown_side = 512, narrowest = 840, bar_width = 120;
constexpr double title_size = 0.65, time_size = 0.85, label_size = 0.75, caption_size = 0.5;

cv::Size heatmap_shown(const EventFilmOptions& options) {
  const events::SensorSize size = heatmaps::heatmap_size(options.sensor, options.rendering.factor);
  return shown_size({size.width, size.height}, shown_side);
}

int even(int side) { return side + side % 2; }

int width_of(cv::Size shown) { return even(std::max(narrowest, 2 * margin + 4 * border + 2 * shown.width + gap)); }
int strip_top(cv::Size shown) { return margin + title_line + time_line + shown.height + 2 * border + caption_line; }

}  // namespace

EventFilm::EventFilm(EventFilmOptions options, const EventCurve& curve)
    : options_(std::move(options)),
      shown_(heatmap_shown(options_)),
      strip_(options_.begin, options_.end, options_.zero,
             {margin, strip_top(shown_), width_of(shown_) - 2 * margin, RateStrip::height}) {
  background_.create(even(strip_top(shown_) + RateStrip::height + margin), width_of(shown_), CV_8UC3);
  background_.setTo(paper);
  const cv::Size framed = shown_ + cv::Size(2 * border, 2 * border);
  const int top = margin + title_line + time_line, left = (background_.cols - 2 * framed.width - gap) / 2;
  counts_place_ = {{left, top}, framed};
  heatmap_place_ = {{left + framed.width + gap, top}, framed};

  const int remark_width = text_width(options_.remark, caption_size);
  const int room = background_.cols - 2 * margin;
  draw_text(background_, options_.title, {margin, margin + 16}, title_size, std::max(room / 2, room - remark_width - 20), ink);
  draw_text(background_, options_.remark,
            {std::max(margin + room / 2 + 10, background_.cols - margin - remark_width), margin + 16}, caption_size,
            room / 2 - 10, faint_ink);
  const events::SensorSize size = heatmaps::heatmap_size(options_.sensor, options_.rendering.factor);
  const std::array<std::tuple<cv::Rect, std::string, int>, 2> captions{
      {{counts_place_, "events per pixel", options_.brightness.counts},
       {heatmap_place_, fmt::format("heatmap {}x{}", size.width, size.height), options_.brightness.heatmap}}};
  for (const auto& [place, caption, brightest] : captions) {
    const int base = place.br().y + 20;
    const std::string most = std::to_string(brightest);
    const int scale_width = bar_width + text_width(most, caption_size) + 8;
    const int written = draw_text(background_, caption + ", 0", {place.x, base}, caption_size,
                                  std::max(60, place.width - scale_width), faint_ink);
    const cv::Rect bar(place.x + written + 8, base - 11, bar_width - 24, 12);
    draw_colour_bar(background_, bar);
    draw_text(background_, most, {bar.br().x + 8, base}, caption_size, 60, faint_ink);
  }
  strip_.draw(background_, curve, options_.intervals);
}

std::optional<Touch> EventFilm::touch_at(CameraTime t) const {
  if (!options_.is_labelled) return std::nullopt;
  for (const TouchInterval& interval : options_.intervals) {
    if (interval.contains(t)) return interval.touch;
  }
  return Touch::none;
}

cv::Mat EventFilm::picture_of(const Moment& moment) const {
  cv::Mat picture = background_.clone();
  const std::optional<Touch> touch = touch_at(moment.t);
  const int base = margin + title_line + 28;
  // Fixed widths, so that changing digits do not move the words after them.
  draw_text(picture, fmt::format("{:.1f} ms", in_ms(between(options_.zero, moment.t))), {margin, base}, time_size, 240, ink);
  int x = margin + 240;
  if (touch) {
    const cv::Rect box(x, base - 25, 110, 34);
    cv::rectangle(picture, box, touch_colour(touch), cv::FILLED);
    const std::string name(name_of(*touch));
    draw_text(picture, name, {box.x + (box.width - text_width(name, label_size)) / 2, base - 1}, label_size, box.width,
              touch == Touch::none ? ink : paper, 2);
    x = box.br().x + 16;
    const auto current = std::find_if(options_.intervals.begin(), options_.intervals.end(),
                                      [&](const TouchInterval& interval) { return interval.contains(moment.t); });
    if (current != options_.intervals.end())
      draw_text(picture, fmt::format("{:.1f} ms after its onset", in_ms(between(current->start, moment.t))), {x, base - 2},
                caption_size, 210, ink);
  }
  const std::string events =
      fmt::format("{} events in {:g} ms", moment.events, static_cast<double>(options_.rendering.history.count()) / 1000);
  const int width = text_width(events, caption_size);
  draw_text(picture, events, {picture.cols - margin - width, base - 2}, caption_size, width, ink);

  const std::array<std::pair<cv::Rect, cv::Mat>, 2> panes{
      {{counts_place_, false_colours(fitted_picture(moment.counts, shown_), options_.brightness.counts, ColourScale::root)},
       {heatmap_place_, false_colours(fitted_picture(moment.heatmap, shown_), options_.brightness.heatmap)}}};
  for (const auto& [place, pane] : panes) {
    picture(place).setTo(touch_colour(touch));
    pane.copyTo(picture(cv::Rect(place.tl() + cv::Point(border, border), shown_)));
  }
  strip_.draw_cursor(picture, moment.t, options_.rendering.history);
  return picture;
}

}  // namespace tactile::pictures
