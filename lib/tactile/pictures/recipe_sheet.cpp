#include "tactile/pictures/recipe_sheet.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <vector>

#include "tactile/pictures/drawing.hpp"
#include "tactile/recipes/recipe_stream.hpp"

namespace tactile::pictures {
namespace {

constexpr microseconds shown{40'000};
constexpr microseconds warm_up{1'000'000};  ///< what recipes need to begin
constexpr int header = 44, gap = 8;         ///< [px]

/// Events of [t - 40 ms, t): ON blue, OFF red, the last one of a pixel counts.
void draw_events(cv::Mat picture, std::span<const events::Event> events, CameraTime t, std::size_t& count) {
  const cv::Vec3b on{180, 80, 0}, off{0, 40, 210};
  count = 0;
  for (const events::Event& event : events) {
    if (event.t < before(t, shown) || event.t >= t) continue;
    picture.at<cv::Vec3b>(event.y, event.x) = event.on != 0 ? on : off;
    ++count;
  }
}

}  // namespace

cv::Mat recipe_sheet(std::span<const events::Event> events, events::SensorSize size, const recipes::Recipe& recipe,
                     CameraTime t) {
  const auto first = std::partition_point(events.begin(), events.end(),
                                          [&](const events::Event& event) { return event.t < before(t, warm_up); });
  const auto end =
      std::partition_point(first, events.end(), [&](const events::Event& event) { return event.t < after(t, shown); });
  const std::vector<events::Event> before_it(first, end), after_it = recipes::worsened(before_it, {&recipe, 1}, size);
  cv::Mat sheet(header + size.height, 2 * size.width + gap, CV_8UC3, paper);
  const recipes::RecipeInfo& info = recipes::recipe_named(recipe.name);
  std::size_t count_before = 0, count_after = 0;
  cv::Mat left = sheet(cv::Rect(0, header, size.width, size.height)),
          right = sheet(cv::Rect(size.width + gap, header, size.width, size.height));
  left.setTo(cv::Scalar(245, 245, 245));
  right.setTo(cv::Scalar(245, 245, 245));
  draw_events(left, before_it, t, count_before);
  draw_events(right, after_it, t, count_after);
  draw_text(sheet, fmt::format("{}: {}{}{}", info.title, recipe.severity, info.unit.empty() ? "" : " ", info.unit), {4, 18}, 0.6,
            sheet.cols - 8, ink);
  draw_text(sheet, fmt::format("before: {} events in 40 ms", count_before), {4, 38}, 0.45, size.width - 8, faint_ink);
  draw_text(sheet, fmt::format("after: {} events in 40 ms", count_after), {size.width + gap + 4, 38}, 0.45, size.width - 8,
            faint_ink);
  return sheet;
}

}  // namespace tactile::pictures
