#include "tactile/pictures/word_places.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tactile::pictures {
namespace {

constexpr double half_height = 8;  // [px] of a line of words

double overlap(double begin, double end, double other_begin, double other_end) {
  return std::max(0.0, std::min(end, other_end) - std::max(begin, other_begin));
}

}  // namespace

double WordPlaces::covered_by(const Box& box) const {
  constexpr double of_words = 2000;  // words on words are unreadable, words on a bar are not
  double covered = 0;
  for (const Box& other : taken_) {
    covered += (other.is_words ? of_words : 1) * overlap(box.left, box.right, other.left, other.right) *
               overlap(box.top, box.bottom, other.top, other.bottom);
  }
  return covered;
}

bool WordPlaces::meets_words(const Box& box) const {
  return std::any_of(taken_.begin(), taken_.end(), [&box](const Box& other) {
    return other.is_words && overlap(box.left, box.right, other.left, other.right) > 0 &&
           overlap(box.top, box.bottom, other.top, other.bottom) > 0;
  });
}

bool WordPlaces::line_meets_words(double x, double y, const Box& box) const {
  const double end_x = std::clamp(x, box.left, box.right), end_y = std::clamp(y, box.top, box.bottom);
  constexpr int steps = 32;
  for (int i = 1; i < steps; ++i) {
    const double at_x = x + (end_x - x) * i / steps, at_y = y + (end_y - y) * i / steps;
    if (meets_words({at_x - 1, at_y - 1, at_x + 1, at_y + 1})) return true;
  }
  return false;
}

WordPlaces::Place WordPlaces::near(double x, double y, double width) const {
  constexpr double a_line_through_words = 1500;  // [px^2] that it counts as
  double least = INFINITY;
  Box best;
  bool is_beside = false;
  for (const double away : {15.0, 22.0, 30.0, 40.0, 52.0, 66.0, 82.0, 100.0, 120.0}) {
    for (const auto& [right, down] : {std::pair(0.7, -0.7), std::pair(-0.7, -0.7), std::pair(0.7, 0.7), std::pair(-0.7, 0.7),
                                      std::pair(1.0, 0.0), std::pair(-1.0, 0.0), std::pair(0.0, -1.0), std::pair(0.0, 1.0)}) {
      // From the mark's side, the words begin there.
      const double middle = x + right * away + (right > 0 ? 0.5 : right < 0 ? -0.5 : 0) * std::max(0.0, width - 8);
      const Box box{middle - width / 2, y + down * away - half_height, middle + width / 2, y + down * away + half_height};
      const bool is_in =
          box.left >= panel_.left && box.right <= panel_.right && box.top >= panel_.top && box.bottom <= panel_.bottom;
      if (!is_in) continue;
      const bool beside = away < 25;
      double covered = covered_by(box);
      if (covered < least && !beside && line_meets_words(x, y, box)) covered += a_line_through_words;
      if (covered < least) least = covered, best = box, is_beside = beside;
    }
    if (least == 0) break;
  }
  if (!std::isfinite(least)) return {.x = x, .y = y, .width = width, .is_beside = false, .is_free = false};
  return {.x = (best.left + best.right) / 2,
          .y = (best.top + best.bottom) / 2,
          .width = width,
          .is_beside = is_beside,
          .is_free = least == 0,
          .covers_words = meets_words(best)};
}

void WordPlaces::take_line(double x, double y, double to_x, double to_y) {
  constexpr double half = 2;
  const int pieces = 1 + static_cast<int>(std::min(1e4, std::hypot(to_x - x, to_y - y) / (2 * half)));
  for (int i = 0; i <= pieces; ++i) {
    const double at_x = x + (to_x - x) * i / pieces, at_y = y + (to_y - y) * i / pieces;
    take(at_x - half, at_y - half, at_x + half, at_y + half);
  }
}

void WordPlaces::take(const Place& place) {
  taken_.push_back({place.x - place.width / 2, place.y - half_height, place.x + place.width / 2, place.y + half_height, true});
}

}  // namespace tactile::pictures
