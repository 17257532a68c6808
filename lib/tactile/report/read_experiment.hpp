#pragma once

#include <filesystem>

#include "tactile/results/stress.hpp"
#include "tactile/results/trade.hpp"

namespace tactile::report {

// What a folder of `tactile trade` or `tactile stress` holds. @throws Error  if its JSON file is missing or not of its format

results::Trade read_trade(const std::filesystem::path& folder);
results::Stress read_stress(const std::filesystem::path& folder);

}  // namespace tactile::report
