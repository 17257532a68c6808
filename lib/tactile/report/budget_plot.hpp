#pragma once

#include <array>
#include <string>
#include <vector>

#include "tactile/pictures/gnuplot.hpp"
#include "tactile/results/trade.hpp"

namespace tactile::report {

/// The limits of the time per tick that models are compared at [us].
inline constexpr std::array<double, 5> tick_budgets{1, 10, 50, 100, 200};

/// The best settings of one kind of model.
struct BestOfKind {
  std::string kind;                                                         ///< "lenet"
  std::array<const results::TradedSetting*, tick_budgets.size()> within{};  ///< of each limit; null where none keeps it
};

/// For each kind and limit, the most accurate setting of which 99 % of the ticks take at most this long, both on the choice runs;
/// the faster of equals. Kinds in the order in which they appear.
std::vector<BestOfKind> best_within_budgets(const results::Trade& trade);

/// Of these settings accuracy, median delay and false alarms against the limit, on the reported runs, with their 95 % intervals;
/// below, the settings by name.
pictures::Plot trade_budget_plot(const results::Trade& trade);

}  // namespace tactile::report
