#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>

#include "tactile/results/traded_setting.hpp"

namespace tactile::trade {

/// A limit of the detection delay, misses later than all others.
struct DelayLimit {
  double ms = 0;
  bool p90 = false;  ///< of 90 % of all presses and slips; false: of half of them
};

/// Constraints on a detector; those not given are met by all.
struct TradeConstraints {
  std::optional<double> at_most_us{};  ///< time that 99 of 100 ticks do not exceed
  std::optional<double> at_least_accuracy{};
  std::optional<double> at_most_false_alarms_per_min{};  ///< episodes that begin outside of touches, as one sees them in a lab
  std::optional<DelayLimit> at_most_delay{};
  std::optional<double> at_most_missed{};  ///< share of presses and slips, in [0, 1]

  bool any() const { return at_most_us || at_least_accuracy || at_most_false_alarms_per_min || at_most_delay || at_most_missed; }
};

void to_json(nlohmann::json& json, const TradeConstraints& constraints);  ///< {"at_most_us", …}, null if not given
std::string text_of(const TradeConstraints& constraints);  ///< "at most 200 us a tick and an accuracy of at least 95 %"

/// Whether 99 of 100 ticks are done before the next one is due. A setting that does not keep up meets no constraint.
bool keeps_up(const results::TradeResult& figures);

/// Whether a setting keeps up and meets every constraint: with its values, and with its whole 95 % intervals. Without an interval
/// the latter is false.
bool meets(const TradeConstraints& constraints, const results::TradeResult& figures);
bool meets_in_interval(const TradeConstraints& constraints, const results::TradeResult& figures);

/// The setting chosen for constraints.
struct TradeChoice {
  std::size_t index = 0;
  bool in_interval = false;  ///< its whole intervals meet the constraints; false: only its values do, and no setting's intervals
};

/// Of the settings whose intervals meet the constraints: the most accurate one, or the fastest one if an accuracy is requested
/// and no time; of equals, the one with the shorter median delay. If no interval does: of the settings whose values meet them,
/// the one with the largest
///
///   min over constraints   |value - limit| / |value - the bound of its interval on the limit's side|
///
/// because a setting on the verge hardly meets them on other runs; of equals, as above.
/// @return  nothing if there is none
std::optional<TradeChoice> choose(const TradeConstraints& constraints, std::span<const results::TradeResult> settings);

/// A trial of the chosen setting in `tactile detect`, over loopback.
struct LiveTrial {
  std::uint64_t ticks = 0;
  double us_p50 = 0, us_p99 = 0, us_p999 = 0;  ///< of rendering, network and output
  double missed_share = 0;                     ///< of ticks: skipped, or more than a tick late
};

/// The answer to constraints.
struct Recommendation {
  bool met = false;  ///< its intervals meet the constraints on the reported runs too, and the trial meets the time
  std::string sentence;
};

/// @param setting   the chosen one, in words
/// @param reported  its figures on the runs to report on
/// @param trial     in `detect`, if there was one
Recommendation recommend(const TradeConstraints& constraints, const std::string& setting, const results::TradeResult& reported,
                         const std::optional<LiveTrial>& trial, bool simulated);

/// Why no setting was chosen: none meets the constraints, the machine was too busy to tell, or there is no constraint.
/// @param compared      on the runs to choose on
/// @param not_compared  number of settings with fewer trainings
std::string why_none(const TradeConstraints& constraints, std::span<const results::TradeResult> compared,
                     std::size_t not_compared, bool simulated);

}  // namespace tactile::trade
