#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "tactile/results/cost_growth.hpp"
#include "tactile/results/figure.hpp"

namespace tactile::report {

/// A setting that `tactile trade` measured.
struct ReportedSetting {
  std::string text;                                ///< in what it differs from the usual one
  std::string design;                              ///< "usual", "one", "corner", "all"
  std::string kind = "lenet";                      ///< of its model
  results::Figure choice_accuracy, choice_us_p99;  ///< on the runs to choose on
  std::uint64_t trainings = 0;
  results::Figure accuracy;                        ///< in [0, 1], on the reported runs as all that follow
  results::Figure us_p50, us_p99, us_p999;         ///< time per tick
  results::Figure delay_us, delay_p90_us, missed;  ///< median and 90 % quantile, misses at their limit; share missed or early
  results::Figure episodes_per_min;                ///< false alarms: episodes that begin outside labels
  results::Figure accuracy_difference, delay_difference_us, episodes_difference;  ///< to the usual setting, paired over runs
  bool on_accuracy_front = false, on_delay_front = false;                         ///< on the runs to choose on
  double accuracy_front_probability = std::numeric_limits<double>::quiet_NaN();   ///< in [0, 1]; NaN if it is unknown
  double delay_front_probability = std::numeric_limits<double>::quiet_NaN();
};

/// What a folder of `tactile trade` holds.
struct ReportedTrade {
  std::string title, times_are, judged_by, usual_is, machine;
  bool simulated = false;
  std::vector<ReportedSetting> settings;  ///< the usual one first
  std::vector<std::string> left_out;      ///< in sentences: pairs that do not divide, and what was not measured
  results::CostGrowth growth;
  std::string sentence;  ///< the recommendation
};

/// @throws Error  if trade.json is missing or not of its format
ReportedTrade read_trade(const std::filesystem::path& folder);

}  // namespace tactile::report
