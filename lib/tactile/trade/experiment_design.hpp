#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tactile/trade/trade_setting.hpp"

namespace tactile {

/// The values that each knob is tried at.
struct TradeLevels {
  std::vector<microseconds> histories{2ms, 10ms, 20ms, 30ms, 40ms, 50ms};
  std::vector<microseconds> ticks{1ms, 2ms, 4ms, 5ms, 10ms};
  std::vector<double> factors{0.1, 0.2, 0.25};
  std::vector<Resize> resizes{Resize::area, Resize::linear};
  std::vector<Denoise> denoises{Denoise::mean, Denoise::literal, Denoise::none};
  std::vector<EngineKind> engines{EngineKind::fast, EngineKind::libtorch};
  std::vector<Precision> precisions{Precision::fp32, Precision::int8};
  std::vector<bool> sparse{true, false};
  std::vector<Confirmation> confirmations{{1, 1}, {2, 3}, {3, 5}, {5, 9}};
  std::vector<bool> gate{false, true};
};

/// One value of one knob.
struct TradeLevel {
  std::string text;  ///< "20", "2/3", "int8"
  std::function<void(TradeSetting&)> set;
};
struct TradeFactor {
  std::string name;  ///< "th_ms"; as `to_json` of a setting has it
  std::vector<TradeLevel> levels;
};

/// The knobs in the order in which they are tried.
std::vector<TradeFactor> factors_of(const TradeLevels& levels);

/// A pair of history and tick that is left out, since the one is no whole number of the other.
struct LeftOutPair {
  microseconds history{0}, tick{0};
};
std::vector<LeftOutPair> left_out_pairs(const TradeLevels& levels);

/// The default first, then every other value of each knob with all others at the default. Impossible ones are not in it.
std::vector<TradeSetting> one_at_a_time(const TradeSetting& usual, const TradeLevels& levels);

/// Every combination that is possible.
std::vector<TradeSetting> all_combinations(const TradeSetting& usual, const TradeLevels& levels);

/// What one setting costs and gives, on the runs to choose on; NaN where it is not known.
struct TradeOutcome {
  double accuracy = 0;  ///< in [0, 1]
  double us = 0;        ///< time per tick
  double delay_us = 0;  ///< mean detection delay
  double false_alarms_per_min = 0;
  double missed = 0;  ///< share of presses and slips missed or early, in [0, 1]
};

/// Combinations of two and more values off the default that look promising: were each to change things as it does alone, they
/// would lie on the front of accuracy against time, or on that of false alarms, delay and misses.
///
///   accuracy, delay, misses: default + sum of differences;   time: default * product of ratios;   false alarms: (default + 3)
///   * product of ratios of what is measured + 3, less 3
///
/// @param measured  what `one_at_a_time` gave, by `id_of`; values that it lacks are in no combination, nor is the other pass,
/// sparse
///                  or dense: the two differ in what they cost alone
/// @param most      of each front, spread along it
std::vector<TradeSetting> promising_corners(const TradeSetting& usual, const TradeLevels& levels,
                                            const std::map<std::string, TradeOutcome>& measured, std::size_t most);

}  // namespace tactile
