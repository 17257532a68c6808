#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tactile/alignment/anchor_search.hpp"

namespace tactile::alignment {

/// Minutes of two signals would smear their match where a clock drifts: the first search uses so much of one [s].
constexpr double searched_s = 100.0;
constexpr double same_shift_s = 0.12;  ///< shifts that are closer are one

double energy_of(std::span<const double> values);  ///< the sum of their squares

/// Keeps the stretch of `length` points in which the axes together have the most energy, and sets the others to 0.
void keep_strongest(std::span<std::vector<double>* const> axes, std::size_t length);

/// The lags of a correlation.
struct Lags {
  double grid_s = 0;
  std::size_t zero = 0;  ///< index at which both signals begin together
  double begin_s = 0;    ///< the shift there

  double shift_of(double index) const { return begin_s + (index - static_cast<double>(zero)) * grid_s; }
};

/// Sets the scores of lags that contradict the coarse offset to 0.
void keep_within(std::vector<double>& scores, const Lags& lags, const AnchorSearch& search);

/// The best and the second-best lag.
struct Peak {
  std::size_t index = 0;
  double value = 0, second = 0;
  double offset = 0;  ///< of the vertex of the parabola through the peak and its neighbours, -0.5 to 0.5

  double ratio() const;  ///< infinite where there is no second
};

/// Of scores that are comparable. Everything that descends from the peak belongs to it. Nothing if no score is above 0.
std::optional<Peak> highest_peak(std::span<const double> scores);

/// The highest points that are at least `share` of the best, and apart from each other by `apart` indices.
std::vector<std::size_t> peaks_near_best(std::vector<double> scores, double share, std::size_t apart);

/// A match with its shift.
struct CoarseMatch {
  LagMatch match;
  double shift_s = 0;
  std::vector<double> as_good_s;  ///< shifts that are nearly as good, itself among them
};

/// The shift found at the nearest time, and that time's distance: a drift moves what is far from it.
struct KnownShifts {
  double first_s = 0;  ///< where none is known yet
  double first_at_s = 0;
  std::vector<std::pair<double, double>> found{};  ///< robot seconds and shift

  struct Nearest {
    double shift_s = 0, distance_s = 0;
  };
  Nearest nearest(double at_s) const;
};

}  // namespace tactile::alignment
