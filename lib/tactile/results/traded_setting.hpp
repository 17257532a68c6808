#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/infinite.hpp"
#include "tactile/results/figure.hpp"
#include "tactile/results/members.hpp"
#include "tactile/results/whole_runs.hpp"

namespace tactile::results {

/// What a setting gives on some runs, and what its ticks take.
struct TradeResult {
  Figure accuracy{};                     ///< of balanced samples, in [0, 1]
  OperatingPoint whole_runs{};           ///< its delays include the median time to compute a tick
  Figure us_p50{}, us_p99{}, us_p999{};  ///< time per tick that half, 99 % and 99.9 % of all ticks do not exceed
  std::uint64_t ticks = 0;               ///< timed
  double interrupted = 0;                ///< share of them in which another program had the processor
  double tick_us = infinite;             ///< from one tick to the next; not in JSON

  /// Whether `us_p99` is not the setting's own: more ticks were interrupted than the one of 100 that it leaves out.
  bool is_disturbed() const { return interrupted > 0.01; }
};

template <class Members>
void list_members(Members& members, TradeResult& result) {
  members("accuracy", result.accuracy);
  members("whole_runs", result.whole_runs);
  members("us_p50", result.us_p50);
  members("us_p99", result.us_p99);
  members("us_p999", result.us_p999);
  members("ticks", result.ticks);
  members("interrupted", result.interrupted);
}

/// How probable it is that a setting is on each front; nothing with fewer than three objects to draw from.
struct FrontProbability {
  std::optional<double> accuracy{}, delay{};
};

template <class Members>
void list_members(Members& members, FrontProbability& probability) {
  members("accuracy", probability.accuracy);
  members("delay", probability.delay);
}

/// All parameters of a detector that trade speed for accuracy, as the options of `tactile trade` name them.
struct SettingValues {
  std::string kind = "lenet";  ///< of its model
  double th_ms = std::numeric_limits<double>::quiet_NaN(), tick_ms = std::numeric_limits<double>::quiet_NaN();
  double factor = std::numeric_limits<double>::quiet_NaN();  ///< size of the heatmap, divided by that of the sensor
  std::string resize{}, denoise{};
  std::string engine{}, precision{};
  std::string augment = "none";  ///< in its training, joined by +
};

template <class Members>
void list_members(Members& members, SettingValues& values) {
  members("kind", values.kind);
  members("th_ms", values.th_ms);
  members("tick_ms", values.tick_ms);
  members("factor", values.factor);
  members("resize", values.resize);
  members("denoise", values.denoise);
  members("engine", values.engine);
  members("precision", values.precision);
  members("augment", values.augment);
}

/// A setting that `tactile trade` measured.
struct TradedSetting {
  std::string id{};                   ///< unique
  std::string text{};                 ///< in what it differs from the usual one
  std::string design{};               ///< "usual", "one", "corner", "all"
  SettingValues values{};             ///< "setting" in JSON
  std::vector<std::string> models{};  ///< names, one for each training
  std::uint64_t trainings = 0;
  TradeResult choice{}, reported{};                        ///< on the runs to choose on, and on the reported ones
  bool on_accuracy_front = false, on_delay_front = false;  ///< on the runs to choose on
  FrontProbability front_probability{};
};

template <class Members>
void list_members(Members& members, TradedSetting& setting) {
  members("id", setting.id);
  members("text", setting.text);
  members("design", setting.design);
  members("setting", setting.values);
  members("models", setting.models);
  members("trainings", setting.trainings);
  members("choice", setting.choice);
  members("reported", setting.reported);
  members("on_accuracy_front", setting.on_accuracy_front);
  members("on_delay_front", setting.on_delay_front);
  members("front_probability", setting.front_probability);
}

}  // namespace tactile::results
