#include "tactile/pictures/label_script.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace tactile::pictures {

std::string signed_ms(double value) { return fmt::format("{}{:.1f}", value < 0 ? "−" : "+", std::abs(value)); }

double highest_of(const std::vector<PlotPoint>& points) {
  double highest = 0;
  for (const PlotPoint& point : points) highest = std::max(highest, point.y);
  return highest > 0 ? highest : 1;
}

LabelScript::LabelScript(const LabelPicture& picture)
    : picture_(picture), seconds_(std::max(1e-3, seconds_from_begin(picture.end))) {}

double LabelScript::seconds_from_begin(CameraTime t) const {
  return 1e-6 * static_cast<double>(between(picture_.begin, t).count());
}

double LabelScript::shown(CameraTime t) const { return std::clamp(seconds_from_begin(t), 0.0, seconds_); }

void LabelScript::begin_panel(const PlotBox& box, double x_low, double x_high) {
  if (begun_) add("unset label");
  begun_ = true;
  add("unset arrow\nunset object\nunset key\nunset ylabel\nunset y2label\nunset y2tics\nset ytics autofreq\nset xtics "
      "autofreq");
  add("set yrange [*:*]\nset border 3");
  place_panel(box);
  add("set xrange [{:.9g}:{:.9g}]", x_low, x_high);
  pixel_ = (x_high - x_low) / (box.right - box.left);
}

std::vector<PlotPoint> LabelScript::root_rate(microseconds bin, double from_us, double to_us, double unit_us,
                                              double zero_us) const {
  const alignment::EventRate& rate = picture_.rate;
  const auto own_bin = static_cast<double>(rate.bin.count());
  const auto together = static_cast<std::size_t>(std::max(1.0, std::round(static_cast<double>(bin.count()) / own_bin)));
  const auto index_of = [&](double us) {
    return static_cast<std::size_t>(std::clamp(us / own_bin, 0.0, static_cast<double>(rate.counts.size())));
  };
  std::vector<PlotPoint> points;
  const double length_ms = own_bin * static_cast<double>(together) / 1000;
  for (std::size_t i = index_of(from_us) / together * together; i < index_of(to_us); i += together) {
    const std::size_t end = std::min(i + together, rate.counts.size());
    double events = 0;
    for (std::size_t k = i; k < end; ++k) events += rate.counts[k];
    if (end < i + together) events *= static_cast<double>(together) / static_cast<double>(end - i);
    const double middle_us = own_bin * (static_cast<double>(i) + static_cast<double>(together) / 2);
    points.push_back({(middle_us - zero_us) / unit_us, std::sqrt(events / length_ms)});
  }
  return points;
}

void LabelScript::square_tics(double highest) {
  std::string tics = "'0' 0";
  double last = 0;
  for (double decade = 1e-3; decade <= highest * highest; decade *= 10) {
    for (const double step : {1.0, 2.0, 5.0}) {
      const double root = std::sqrt(step * decade);
      if (root > highest || root - last < 0.12 * highest) continue;
      tics += fmt::format(", '{:g}' {:.9g}", step * decade, root);
      last = root;
    }
  }
  add("set ytics ({})", tics);
}

}  // namespace tactile::pictures
