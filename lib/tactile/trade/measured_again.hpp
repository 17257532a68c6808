#pragma once

#include <nlohmann/json.hpp>

#include "tactile/core/progress.hpp"
#include "tactile/trade/tick_times.hpp"
#include "tactile/trade/trade_point.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile {

/// A setting measured once more on runs that it was not chosen on, by its first seed's network: nothing of what was kept is used.
/// Times are taken beside those of the usual setting, in turns; accuracy and false alarms are by `evaluate` where the tick is the
/// network's own, the interval of false alarms ending no lower than few alarms allow.
/// @param usual  with a network too; may be the same point
/// @return  as `TradeResult` in JSON, with "by" ("eval" or "trade"), "model" and "runs"
/// @throws Error  if a recording, a model or the dataset cannot be read
nlohmann::json measure_again(const TradePoint& point, const TradePoint& usual, const Dataset& dataset, const TestedRuns& runs,
                             const TickTimesOptions& timing, unsigned threads, const ProgressCallback& progress = {});

}  // namespace tactile
