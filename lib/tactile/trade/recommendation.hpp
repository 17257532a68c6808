#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>

#include "tactile/evaluation/confidence_interval.hpp"

namespace tactile {

/// What somebody wants of a detector; what is not said may be anything.
struct TradeWish {
  std::optional<double> at_most_us{};  ///< of time, for 99 of 100 ticks
  std::optional<double> at_least_accuracy{};
  std::optional<double> at_most_false_alarms_per_min{};

  bool any() const { return at_most_us || at_least_accuracy || at_most_false_alarms_per_min; }
};

void to_json(nlohmann::json& json, const TradeWish& wish);  ///< {"at_most_us", …}, null where nothing was wished
std::string text_of(const TradeWish& wish);                 ///< "at most 200 us a tick and an accuracy of at least 95 %"

/// What is measured of a setting, as wishes ask for it.
struct TradeFigures {
  Figure accuracy;  ///< in [0, 1]
  Figure us_p99;    ///< time per tick that 99 of 100 ticks do not exceed
  Figure us_p50;
  Figure delay_us;  ///< mean detection delay
  Figure false_alarms_per_min;
  double tick_us = std::numeric_limits<double>::infinity();  ///< from one tick to the next
};

/// Whether 99 of 100 ticks are done before the next one is due; one that does not keep up can meet no wish.
bool keeps_up(const TradeFigures& figures);

/// Whether every wish is met, by a setting that keeps up: by the value itself, and by all of its 95 % interval, which is never so
/// where there is none.
bool meets(const TradeWish& wish, const TradeFigures& figures);
bool meets_in_interval(const TradeWish& wish, const TradeFigures& figures);

/// How a setting was found for a wish.
struct TradeChoice {
  std::size_t index = 0;
  bool in_interval = false;  ///< all of its intervals meet the wish; else its values alone, and no other's intervals do
};

/// The setting for a wish: of those whose intervals meet it the most accurate one; where an accuracy is wished for and no time,
/// the fastest. Of alike ones that with the shorter delay. Where no interval meets it, the surest of those whose values do: that
/// whose
///
///   min over what is wished   |value - limit| / |value - the bound on the limit's side|
///
/// is the largest, for one on the verge would hardly meet it on other runs; where that is alike too, as above.
/// @return  nothing if there is none
std::optional<TradeChoice> choose(const TradeWish& wish, std::span<const TradeFigures> settings);

/// What is said to a wish.
struct Recommendation {
  std::optional<std::string> setting;  ///< in words; nothing if none met the wish where it is chosen
  bool met = false;                    ///< measured again, its intervals meet the wish
  std::string sentence;
};

/// @param setting  in words, of the chosen one; nothing if there was none
/// @param again    its figures, measured again on the runs that it was not chosen on
Recommendation recommend(const TradeWish& wish, const std::optional<std::string>& setting, const TradeFigures& again,
                         bool simulated);

}  // namespace tactile
