#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tactile/results/cost_growth.hpp"
#include "tactile/results/traded_setting.hpp"

namespace tactile::report {

/// What a folder of `tactile trade` holds.
struct ReportedTrade {
  std::string title, times_are, judged_by, usual_is, machine;
  bool simulated = false;
  std::vector<results::TradedSetting> settings;  ///< the usual one first
  std::vector<std::string> left_out;             ///< in sentences: pairs that do not divide, and what was not measured
  results::CostGrowth growth;
  std::string sentence;  ///< the recommendation
};

/// @throws Error  if trade.json is missing or not of its format
ReportedTrade read_trade(const std::filesystem::path& folder);

}  // namespace tactile::report
