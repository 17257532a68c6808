#pragma once

#include <span>

namespace tactile {

struct WeightedPoint {
  double x = 0, y = 0, weight = 0;
};

/// A straight line through points, with weights.
struct StraightLine {
  double mean_x = 0, mean_y = 0, gradient = 0;
  double weights = 0;      ///< sum of w
  double weighted_xx = 0;  ///< sum of w (x - mean_x)^2

  double at(double x) const { return mean_y + gradient * (x - mean_x); }
};

/// The line with the least sum of w (y - line)^2. Its gradient is 0 where all x are equal, all of it where the weights sum to 0.
inline StraightLine line_through(std::span<const WeightedPoint> points) {
  StraightLine line;
  double xy = 0;
  for (const WeightedPoint& p : points) {
    line.weights += p.weight;
    line.mean_x += p.weight * p.x;
    line.mean_y += p.weight * p.y;
  }
  if (!(line.weights > 0)) return line;
  line.mean_x /= line.weights;
  line.mean_y /= line.weights;
  for (const WeightedPoint& p : points) {
    line.weighted_xx += p.weight * (p.x - line.mean_x) * (p.x - line.mean_x);
    xy += p.weight * (p.x - line.mean_x) * (p.y - line.mean_y);
  }
  line.gradient = line.weighted_xx > 0 ? xy / line.weighted_xx : 0;
  return line;
}

}  // namespace tactile
