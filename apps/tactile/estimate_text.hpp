#pragma once

#include <filesystem>
#include <string>

#include "command.hpp"
#include "tactile/experiments/estimate.hpp"

namespace tactile::cli {

/// "51 min on 2 cores": how long all of it takes.
std::string duration_text(const experiments::Estimate& estimate);

/// Prints the steps, hours and bytes of an experiment that is not run: `--dry-run`. Warns if `out` has less space.
/// @param on_cluster  also prints how long it takes with the jobs on many cores
void print_estimate(const experiments::Estimate& estimate, const std::filesystem::path& out, bool on_cluster,
                    const CommonArguments& common);

}  // namespace tactile::cli
