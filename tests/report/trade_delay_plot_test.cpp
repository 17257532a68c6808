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

results::TradedSetting setting_with(double alarms_per_min, double delay_ms, double longest_ms) {
  results::TradedSetting setting;
  setting.reported.whole_runs.alarms_per_min.value = alarms_per_min;
  setting.reported.whole_runs.median_ms.ms = {delay_ms, delay_ms - 1, longest_ms, 10};
  setting.on_delay_front = true;
  return setting;
}

TEST(TradeDelayPlot, ShowsDelaysOfMillisecondsBesideAnIntervalOfSeconds) {
  results::Trade trade;
  trade.points = {setting_with(9, 9, 9'999), setting_with(0, 0.999, 99)};
  const pictures::Plot plot = trade_delay_plot(trade);
  EXPECT_TRUE(has_row(plot, {1, 1, std::log10(9), 4}));
  EXPECT_TRUE(has_row(plot, {0, std::log10(1.999), 0, 2})) << "a bound below 0 is drawn at 0";
  EXPECT_TRUE(contains(drawn(plot), ">3000<")) << "a tic";
}

}  // namespace
}  // namespace tactile::report
