#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "tactile/experiments/step_runner.hpp"
#include "tactile/experiments/trade/plan_trade.hpp"
#include "tactile/results/trade.hpp"

namespace tactile::trade {

/// The outcome of `run_trade`.
struct TradeSummary {
  results::Trade trade;
  std::filesystem::path file;                      ///< trade.json
  std::optional<nlohmann::json> detect_options{};  ///< of `tactile detect --config`, for the chosen setting, confirmed or not
  std::size_t done = 0, kept = 0;                  ///< number of steps done now, and found done
};

/// Measures accuracy, detection delay, false alarms and time per tick over all values of `options.levels`: one change of the
/// usual setting at a time, then the combinations that look promising; or all combinations. Trains the networks that a setting
/// needs, and those that may be on a front several times, each time on other runs and with another seed. Chooses settings on some
/// runs and reports them on others. Keeps all that
/// is done and unchanged. An interrupted call resumes.
/// @throws Error  if an option is out of its range, there are no runs to choose on besides those to report on, another process
///                works in the same folder, or a step fails
TradeSummary run_trade(const TradeOptions& options, const experiments::NewProgress& new_progress = {},
                       const experiments::StepCallback& on_step = {});

}  // namespace tactile::trade
