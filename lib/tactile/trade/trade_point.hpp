#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/model/definition/model_settings.hpp"
#include "tactile/trade/tick_times.hpp"
#include "tactile/trade/trade_figures.hpp"
#include "tactile/trade/trade_setting.hpp"

namespace tactile {

/// A network that settings share, and one seed of it.
struct TradeNetwork {
  ModelSettings settings;
  ModelBundle bundle;

  std::string name() const { return bundle.name(); }
};

/// A setting, and what is measured of it.
struct TradePoint {
  TradeSetting setting;
  std::string design;                       ///< "usual", "one", "corner", "all"
  std::vector<TradeNetwork> networks = {};  ///< one for each seed
  TradeResult choice = {}, reported = {};
  std::optional<TradeDifference> difference = {};  ///< to the usual setting, on the reported runs
  bool on_accuracy_front = false, on_delay_front = false;
};

/// A setting that could not be measured, in words.
struct NotMeasured {
  std::string setting, why;
};

/// Runs to test on, in one order throughout.
struct TestedRuns {
  std::vector<std::uint32_t> indexes;             ///< in the dataset
  std::vector<JudgedRun> judged;                  ///< of each
  std::vector<std::filesystem::path> recordings;  ///< likewise

  TestedRuns from(std::size_t first) const;  ///< all from this one on
};

/// What is timed of a point: that of its first seed, which it must have.
TimedWay way_of(const TradePoint& point);

/// Fewer events than that in a history, and a network of this setting is not asked; nothing where the setting has no gate.
std::optional<std::uint64_t> gate_of(const TradeSetting& setting, const TradeNetwork& network);

}  // namespace tactile
