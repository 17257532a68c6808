#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tactile/results/cost_growth.hpp"
#include "tactile/results/figure.hpp"

namespace tactile::report {

/// A setting that `tactile trade` measured.
struct ReportedSetting {
  std::string text;    ///< in what it differs from the usual one
  std::string design;  ///< "usual", "one", "corner", "all"
  std::uint64_t seeds = 0;
  results::Figure accuracy;                        ///< in [0, 1], on the reported runs as all that follow
  results::Figure us_p50, us_p99;                  ///< time per tick
  results::Figure delay_us, delay_p95_us, missed;  ///< of detections; share of presses and slips missed or early
  results::Figure false_alarms_per_min;
  results::Figure accuracy_difference, delay_difference_us, false_alarms_difference;  ///< to the usual setting, paired over runs
  bool on_accuracy_front = false, on_delay_front = false;                             ///< on the runs to choose on
};

/// What a folder of `tactile trade` holds.
struct ReportedTrade {
  std::string title, times_are, machine;
  bool simulated = false;
  std::vector<std::string> choice_runs, reported_runs;
  std::vector<ReportedSetting> settings;  ///< the usual one first
  std::vector<std::string> left_out;      ///< in sentences: pairs that do not divide, and what was not measured
  results::CostGrowth growth;
  std::string sentence;  ///< the recommendation
};

/// @throws Error  if trade.json is missing or not of its format
ReportedTrade read_trade(const std::filesystem::path& folder);

}  // namespace tactile::report
