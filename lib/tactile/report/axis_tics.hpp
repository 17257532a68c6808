#pragma once

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace tactile::report {

/// The position of a value on a logarithmic axis: log10(value); NaN unless value > 0.
double log_position(double value);

/// The position on an axis that is linear near 0 and logarithmic beyond: log10(value + 1); NaN unless value >= 0.
double log_position_from_zero(double value);

/// The same of a value or a bound that may be below 0, and is then drawn at 0.
double drawn_from_zero(double value);

/// The positions [begin, end] of an axis, and its length in pixels.
struct AxisRange {
  double begin = 0, end = 1;
  double pixels = 1;
  double pixel_at(double position) const { return pixels * (position - begin) / (end - begin); }
  bool holds(double position) const { return position >= begin && position <= end; }
};

/// Holds [least, most] with a margin on both sides, and is at least `shortest` long without its margins.
AxisRange range_around(double least, double most, double shortest, double pixels);

/// Tics whose labels do not meet.
class AxisTics {
 public:
  static constexpr double character = 9.4, gap = 8;  // [px], of a digit and between labels
  static constexpr double line = 20;                 // [px], of labels one above the other

  /// @param is_upright  labels stand above each other
  explicit AxisTics(const AxisRange& range, bool is_upright = false) : range_(range), is_upright_(is_upright) {}

  /// Adds all of them, or none where their labels would meet each other or those of earlier tics. Positions outside the range are
  /// left out.
  /// @param tics  positions with labels
  /// @return      whether they were added
  bool add(const std::vector<std::pair<double, std::string>>& tics);

  /// A tic without a label.
  void add_bare(double position);

  std::size_t size() const { return tics_.size(); }

  /// As gnuplot takes them.
  std::string text(bool with_labels = true) const;

 private:
  struct Tic {
    double position, pixel, room;
    std::string label;
  };
  AxisRange range_;
  bool is_upright_;
  std::vector<Tic> tics_;
  std::string bare_;
};

/// Round values of a logarithmic axis, as many as fit: 1, 2 and 5 of each decade, and finer ones where these are few.
/// @param from_zero  the axis is that of `log_position_from_zero`: 0, then 1 and 3 of each decade
AxisTics decade_tics(const AxisRange& range, bool from_zero, bool is_upright = false);

}  // namespace tactile::report
