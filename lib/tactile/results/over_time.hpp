#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/results/figure.hpp"

namespace tactile::results {

struct OverTimeOptions {
  microseconds bin{50'000};         ///< of the curves, > 0
  microseconds longest{3'000'000};  ///< how far from onset and end the curves go, >= bin
  microseconds first{500'000};      ///< what counts as the beginning of an interval, > 0
  microseconds last{200'000};       ///< what counts as its end, > 0
  microseconds after{100'000};      ///< how long after an interval remaining predictions of press and slip count, >= 0
};

/// The shares of an interval's ticks that were predicted correctly: of each object over its runs, then the mean over objects.
struct ShareOverTime {
  Figure first{}, later{}, last{};
  Figure before_last{};        ///< before the last ticks, of intervals that have such ticks
  Figure last_minus_before{};  ///< last ticks minus that, of the same intervals: below 0 where predictions get worse near the end
  Figure still_predicted{};    ///< share of the ticks after intervals that still predict press or slip
  std::uint64_t intervals = 0, short_ones = 0;  ///< with a tick, and of them those with none before the last ones
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

/// Of press, of slip and of both together.
struct OverTime {
  OverTimeOptions options;
  AccuracyOverTime press, slip, both;
};

/// {"first", "later", "last", "before_last", "last_minus_before", "still_predicted", "intervals", "short_ones"}
void to_json(nlohmann::json& json, const ShareOverTime& share);
void from_json(const JsonView& json, ShareOverTime& share);

/// The same, and "objects", "since_onset", "before_end" with "from_ms", "to_ms", "accuracy", "ticks", "intervals" in each bin.
void to_json(nlohmann::json& json, const AccuracyOverTime& accuracy);
void from_json(const JsonView& json, AccuracyOverTime& accuracy);

/// {"bin_ms", "first_ms", "last_ms", "after_ms", "press", "slip", "both"}
void to_json(nlohmann::json& json, const OverTime& over_time);
void from_json(const JsonView& json, OverTime& over_time);

}  // namespace tactile::results
