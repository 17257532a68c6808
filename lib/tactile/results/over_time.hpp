#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/results/figure.hpp"

namespace tactile {

/// The shares of an interval's ticks that were said right: of each object over its runs, then the mean over objects.
struct ShareOverTime {
  Figure first{}, later{}, last{};
  Figure before_last{};        ///< ahead of the last ticks, of intervals that have such ticks
  Figure last_minus_before{};  ///< the last ticks of the same intervals less that: below 0 where verdicts are worse near the end
  Figure still_said{};         ///< share of the ticks behind intervals at which press or slip is said still
  std::uint64_t intervals = 0, short_ones = 0;  ///< with a tick, and of them those with none ahead of the last ones
};

struct OverTimeBin {
  microseconds from{0}, to{0};
  Figure accuracy{};
  std::uint64_t ticks = 0, intervals = 0;
};

struct AccuracyOverTime {
  ShareOverTime all{};
  std::map<std::string, ShareOverTime> objects{};
  std::vector<OverTimeBin> since_onset{}, before_end{};  ///< up to the last bin with a tick
};

/// {"first", "later", "last", "before_last", "last_minus_before", "still_said", "intervals", "short_ones"}
void to_json(nlohmann::json& json, const ShareOverTime& share);
void from_json(const JsonView& json, ShareOverTime& share);

/// The same, and "objects", "since_onset", "before_end" with "from_ms", "to_ms", "accuracy", "ticks", "intervals" in each bin.
void to_json(nlohmann::json& json, const AccuracyOverTime& accuracy);
void from_json(const JsonView& json, AccuracyOverTime& accuracy);

}  // namespace tactile
