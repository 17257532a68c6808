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

}  // namespace tactile::study
