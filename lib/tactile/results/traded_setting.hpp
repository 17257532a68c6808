#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/results/figure.hpp"
#include "tactile/results/json_view.hpp"

namespace tactile::results {

/// The figures of a setting that constraints and fronts apply to.
struct TradeFigures {
  Figure accuracy;                                     ///< in [0, 1]
  Figure us_p50, us_p99, us_p999;                      ///< time per tick that half, 99 % and 99.9 % of all ticks do not exceed
  Figure delay_median_us, delay_p90_us;                ///< of all presses and slips; those not detected count with their limit
  bool median_is_bound = false, p90_is_bound = false;  ///< one not detected lies at or below it: the true value may be higher
  Figure missed;                                       ///< share of presses and slips missed or early, in [0, 1]
  Figure episodes_per_min;                             ///< false alarms, of the time outside of touches
  double interrupted = 0;                              ///< share of the timed ticks in which another program had the processor
  double tick_us = std::numeric_limits<double>::infinity();  ///< from one tick to the next; not in JSON

  /// Whether `us_p99` is not the setting's own: more ticks were interrupted than the one of 100 that it leaves out.
  bool is_disturbed() const { return interrupted > 0.01; }
};

/// All figures of one setting. Times are those of all ticks of the timed runs. A delay includes the median time to compute a
/// tick. The intervals of false alarms are wider if there are few alarms.
struct TradeResult {
  TradeFigures figures;
  Figure delay_mean_us;  ///< of the detected presses and slips
  std::uint64_t intervals = 0, misses = 0, early = 0;
  std::uint64_t episodes = 0;  ///< false alarms
  std::uint64_t ticks = 0;     ///< timed
};

void to_json(nlohmann::json& json, const TradeResult& result);
void from_json(const JsonView& json, TradeResult& result);

/// A setting minus the usual one, on the same trainings and runs.
struct TradeDifference {
  Figure accuracy, delay_us, missed, episodes_per_min, us_p50, us_p99;  ///< `delay_us` of the medians
};

void to_json(nlohmann::json& json, const TradeDifference& difference);
void from_json(const JsonView& json, TradeDifference& difference);

/// How probable it is that a setting is on each front; nothing with fewer than three objects to draw from.
struct FrontProbability {
  std::optional<double> accuracy, delay;
};

/// All parameters of a detector that trade speed for accuracy, as the options of `tactile trade` name them.
struct SettingValues {
  std::string kind = "lenet";  ///< of its model
  double th_ms = std::numeric_limits<double>::quiet_NaN(), tick_ms = std::numeric_limits<double>::quiet_NaN();
  double factor = std::numeric_limits<double>::quiet_NaN();  ///< size of the heatmap, divided by that of the sensor
  std::string resize, denoise;
  std::string engine, precision, pass, confirm;
  std::string augment = "none";  ///< in its training, joined by +
};

/// {"kind", "th_ms", "tick_ms", "factor", "resize", "denoise", "engine", "precision", "pass", "confirm", "augment"}
void to_json(nlohmann::json& json, const SettingValues& values);
void from_json(const JsonView& json, SettingValues& values);

/// A setting that `tactile trade` measured.
struct TradedSetting {
  std::string id{};                   ///< unique
  std::string text{};                 ///< in what it differs from the usual one
  std::string design{};               ///< "usual", "one", "corner", "all"
  SettingValues values{};             ///< "setting" in JSON
  std::vector<std::string> models{};  ///< names, one for each training
  std::uint64_t trainings = 0;
  TradeResult choice{}, reported{};                        ///< on the runs to choose on, and on the reported ones
  std::optional<TradeDifference> difference{};             ///< to the usual setting, on the reported runs
  bool on_accuracy_front = false, on_delay_front = false;  ///< on the runs to choose on
  FrontProbability front_probability{};
};

/// {"id", "text", "design", "setting", "models", "trainings", "choice", "reported", "difference", "front"}
void to_json(nlohmann::json& json, const TradedSetting& setting);
void from_json(const JsonView& json, TradedSetting& setting);

}  // namespace tactile::results
