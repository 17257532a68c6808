#include <gtest/gtest.h>

#include <cmath>

#include "report/plot_rows.hpp"
#include "support/drawn_plot.hpp"
#include "tactile/report/trade_plots.hpp"

namespace tactile::report {
namespace {

using test::contains;
using test::drawn;
using test::has_row;

results::TradedSetting setting_with(double episodes_per_min, double delay_us, double longest_us) {
  results::TradedSetting setting;
  setting.reported.figures.episodes_per_min.value = episodes_per_min;
  setting.reported.figures.delay_median_us = {delay_us, delay_us - 1000, longest_us, 10};
  setting.on_delay_front = true;
  return setting;
}

TEST(TradeDelayPlot, CutsAnIntervalFarAboveAllDelays) {
  results::Trade trade;
  trade.points = {setting_with(9, 8000, 10'000)};
  EXPECT_FALSE(contains(drawn(trade_delay_plot(trade)), " cut at "));
  trade.points.push_back(setting_with(0, 6000, 48e6));
  const pictures::Plot plot = trade_delay_plot(trade);
  EXPECT_TRUE(has_row(plot, {1, 8, 7, 10}));
  EXPECT_TRUE(has_row(plot, {0, 6, 5, 12})) << "1.5 times the longest delay";
  EXPECT_TRUE(contains(drawn(plot), "12 ms"));
}

}  // namespace
}  // namespace tactile::report
