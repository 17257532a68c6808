#pragma once

#include <filesystem>

#include "tactile/results/stress.hpp"

namespace tactile::report {

/// What a folder of `tactile stress` holds. @throws Error  if stress.json is missing or not of its format
results::Stress read_stress(const std::filesystem::path& folder);

}  // namespace tactile::report
