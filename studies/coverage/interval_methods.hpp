#pragma once

#include <string_view>

#include "made_up_results.hpp"

namespace tactile::study {

using Bounds = std::optional<std::pair<double, double>>;

/// A method to make an interval, and those that it was compared with.
struct IntervalMethod {
  std::string_view name;
  Bounds (*bounds)(const Trial&, const results::BootstrapOptions&);
};

/// The first is that of evaluation/crossed_figure.hpp.
const std::vector<IntervalMethod>& interval_methods();

Bounds bounds_of(const results::Figure& figure);

/// An interval for each object whose variances borrow from those of all: the variance of its runs, and that of its trainings,
/// with d degrees of freedom each, are replaced by (d0 s0^2 + d s^2) / (d0 + d) with d0 + d degrees. d0 and s0^2 come from the
/// spread of the logarithms of the objects' variances. An object whose value is at a limit keeps its own interval. Source: G. K.
/// Smyth, Linear models and empirical Bayes methods, Statistical Applications in Genetics and Molecular Biology 3 (2004),
/// section 6.
std::vector<Bounds> moderated_bounds(const Trial& trial, const results::BootstrapOptions& options);

}  // namespace tactile::study
