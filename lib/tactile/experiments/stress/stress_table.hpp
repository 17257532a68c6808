#pragma once

#include <string>

#include "tactile/results/stress.hpp"

namespace tactile::stress {

/// One row a model, series and severity, quiet recordings after the runs; docs/format/ lists the columns.
std::string stress_csv(const results::Stress& stress);

}  // namespace tactile::stress
