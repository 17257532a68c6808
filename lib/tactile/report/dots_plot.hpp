#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "tactile/pictures/gnuplot.hpp"
#include "tactile/results/figure.hpp"

namespace tactile::report {

/// A setting in a figure.
struct Dot {
  double x = NAN;
  results::Figure y{};
  bool on_front = false, usual = false;
  bool is_single_change = false;  ///< one value alone differs from the usual setting
  std::string text;               ///< its name
};

struct DotAxes {
  std::string front;  ///< what is on it, in words
  std::string bars;   ///< what they are intervals of
  std::string x_label, y_label;
  bool x_from_zero = false;              ///< linear near 0, logarithmic beyond; else logarithmic throughout
  bool y_from_zero = false;              ///< the same, and what is below 0 is drawn at 0; else linear
  double least_y_span = 1;               ///< a shorter linear axis would show differences that mean nothing
  double y_begin = 0, y_end = INFINITY;  ///< of the axis: no value lies outside
};

/// Settings as dots. Those on the front are filled, with their interval, and numbered; the first 24 have their names below. The
/// others are hollow; 42 of them have a number and a name, those with a single change first. Where circles overlap one label has
/// all their numbers. The usual setting has a diamond and a word. Dots without a value are counted.
pictures::Plot dots_plot(const std::string& title, const DotAxes& axes, const std::vector<Dot>& dots);

}  // namespace tactile::report
