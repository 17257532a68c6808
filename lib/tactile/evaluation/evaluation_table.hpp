#pragma once

#include <string>

#include "tactile/evaluation/evaluation.hpp"

namespace tactile::evaluation {

/// Everything that an evaluation measured as one tidy table, CSV with the columns group, object, class, metric, value, low, high,
/// n: a figure or a count a row. `object` is "all" where it is of all objects, `class` is empty where it is of no one class; what
/// is not known is empty. docs/format/ lists groups and metrics.
std::string table_of(const results::Evaluation& evaluation);

}  // namespace tactile::evaluation
