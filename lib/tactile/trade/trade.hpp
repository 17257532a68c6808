#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/study/step_runner.hpp"
#include "tactile/trade/cost_growth.hpp"
#include "tactile/trade/experiment_design.hpp"
#include "tactile/trade/recommendation.hpp"
#include "tactile/trade/tick_times.hpp"

namespace tactile {

/// What the trade of speed for accuracy is to be measured over.
struct TradeOptions {
  std::filesystem::path data = "data", models = "models", out = "trade";
  std::string train_run = "01";                   ///< of each object, that networks learn from
  std::vector<std::string> choice_runs = {"02"};  ///< settings are chosen on them; all others are reported on
  unsigned epochs = 10;                           ///< of each training, > 0
  unsigned seeds = 3;                             ///< trainings of each network on the front, and of the usual one, > 0
  std::uint64_t seed = 1;                         ///< of the first training; others follow on it
  TradeSetting usual{};                           ///< what one knob at a time is turned from
  TradeLevels levels{};
  bool full = false;                       ///< every combination
  std::size_t corners = 6;                 ///< promising combinations of each front
  std::optional<double> budget_minutes{};  ///< no training is begun that would end later
  bool growth = true;                      ///< measures how cost grows too
  TickTimesOptions timing{};
  GrowthOptions growth_options{};
  TradeWish wish{};
  std::filesystem::path program = "/proc/self/exe";  ///< that trains
  unsigned threads = 0;                              ///< 0: as many as the machine has cores
};

/// What came of it.
struct TradeSummary {
  nlohmann::json trade;  ///< as trade.json has it; docs/format.md lists its keys
  std::filesystem::path file;
  std::size_t done = 0, kept = 0;  ///< steps done now, and found done
};

/// Accuracy, detection delay, false alarms and time per tick over every knob that trades one for another: one knob at a time
/// from the usual setting, then the combinations that look promising, or all of them. Networks whose input or weights a knob
/// changes are trained anew; those of the front with several seeds. Settings are chosen on some runs and reported on the others.
/// Whatever is done and unchanged is kept; ended at any moment it goes on where it was.
/// @throws Error  if an option is out of its range, there is no run to choose on beside those to report on, another trade is at
///                work in the same folder, or a step fails
TradeSummary run_trade(const TradeOptions& options, const NewProgress& new_progress = {},
                       const std::function<void(const std::string& step, bool kept)>& tell = {});

/// What `tactile detect --config` takes for the setting recommended. @throws Error  if none was
nlohmann::json detect_config(const nlohmann::json& trade, const std::filesystem::path& trade_folder);

}  // namespace tactile
