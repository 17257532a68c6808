#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tactile/experiments/trade/trade_setting.hpp"

namespace tactile::trade {

/// The values to try of each parameter.
struct TradeLevels {
  std::vector<model::ModelKind> kinds{model::ModelKind::lenet, model::ModelKind::stream};
  std::vector<microseconds> histories{2ms, 10ms, 20ms, 30ms, 40ms, 50ms};
  std::vector<microseconds> ticks{1ms, 2ms, 4ms, 5ms, 10ms};
  std::vector<double> factors{0.1, 0.2, 0.25};
  std::vector<heatmaps::Resize> resizes{heatmaps::Resize::area, heatmaps::Resize::linear};
  std::vector<heatmaps::Denoise> denoises{heatmaps::Denoise::mean, heatmaps::Denoise::literal, heatmaps::Denoise::none};
  std::vector<model::Augmentation> augmentations{{}, {.flip = true}};
  std::vector<model::EngineKind> engines{model::EngineKind::fast, model::EngineKind::libtorch};
  std::vector<model::Precision> precisions{model::Precision::fp32, model::Precision::int8};
};

/// One value of one parameter.
struct TradeLevel {
  std::string text;  ///< "20", "0.1", "int8"
  std::function<void(TradeSetting&)> set;
};
struct TradeFactor {
  std::string name;  ///< "th_ms"; as in `to_json` of a setting
  std::vector<TradeLevel> levels;
};

/// The parameters in the order in which they are tried.
std::vector<TradeFactor> factors_of(const TradeLevels& levels);

/// A pair that is left out, because the history is no multiple of the tick.
struct LeftOutPair {
  microseconds history{0}, tick{0};
};
std::vector<LeftOutPair> left_out_pairs(const TradeLevels& levels);

/// The usual setting first, then every other value of each parameter with all others as usual, without impossible settings. A
/// kind that reads no heatmaps has `without_idle_values`.
std::vector<TradeSetting> one_at_a_time(const TradeSetting& usual, const TradeLevels& levels);

/// Every possible combination.
std::vector<TradeSetting> all_combinations(const TradeSetting& usual, const TradeLevels& levels);

/// Figures of one setting on the runs to choose on; NaN if unknown.
struct TradeOutcome {
  double accuracy = 0;        ///< in [0, 1]
  double us = 0;              ///< time per tick
  double delay_ms = 0;        ///< median detection delay, misses later than all others
  double alarms_per_min = 0;  ///< false alarms: episodes that begin outside of touches
  double missed = 0;          ///< share of presses and slips missed or early, in [0, 1]
};

/// Combinations of two or more changes that look promising: those expected on the front of accuracy against time, or on the front
/// of false alarms, delay and misses, if each change has the effect that it has alone.
///
///   accuracy, delay, misses = usual + sum of differences
///   time = usual * product of ratios
///   false alarms + 3 = (usual + 3) * product of ratios of (measured + 3)
///
/// @param measured  outcomes of `one_at_a_time`, by `id_of`. Values that it lacks are in no combination
/// @param most      of each front, spread along it
std::vector<TradeSetting> promising_corners(const TradeSetting& usual, const TradeLevels& levels,
                                            const std::map<std::string, TradeOutcome>& measured, std::size_t most);

}  // namespace tactile::trade
