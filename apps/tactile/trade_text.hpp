#pragma once

#include <string>

#include "tactile/experiments/trade/trade.hpp"

namespace tactile::cli {

/// The settings that matter most with their figures, and what is recommended: at most 13 lines.
std::string short_trade_text(const trade::TradeSummary& summary);

/// Every setting, how the cost grows, what was left out, and the recommendation with all its figures.
std::string full_trade_text(const trade::TradeSummary& summary);

}  // namespace tactile::cli
