#include "tactile/detect/deadline_monitor.hpp"

#include <gtest/gtest.h>

namespace tactile::detect {
namespace {

using std::chrono::microseconds;
using std::chrono::nanoseconds;

TEST(DurationHistogram, GivesPercentilesWithinThreePerCent) {
  DurationHistogram histogram;
  for (int i = 1; i <= 100'000; ++i) histogram.add(nanoseconds{i * 10});
  EXPECT_EQ(histogram.count(), 100'000U);
  EXPECT_EQ(histogram.max(), nanoseconds{1'000'000});
  for (const double share : {0.001, 0.5, 0.99, 0.999}) {
    const double exact = share * 1e6;
    EXPECT_GE(static_cast<double>(histogram.percentile(share).count()), exact) << share;
    EXPECT_LE(static_cast<double>(histogram.percentile(share).count()), 1.04 * exact) << share;
  }
  EXPECT_EQ(histogram.percentile(1), histogram.max());
  EXPECT_NEAR(histogram.mean_us(), 500.005, 1e-6);
}

TEST(DurationHistogram, HoldsWhatIsShortLongOrBelowNothing) {
  DurationHistogram histogram;
  histogram.add(nanoseconds{-5});
  EXPECT_EQ(histogram.percentile(1), nanoseconds{0});
  histogram.add(nanoseconds::max());
  EXPECT_EQ(histogram.percentile(1), nanoseconds::max());
  EXPECT_EQ(histogram.count(), 2U);
  nlohmann::json none = DurationHistogram{};
  EXPECT_TRUE(none.is_null());
}

TEST(DurationHistogram, CountsEachOctaveBetweenTheFirstAndTheLast) {
  DurationHistogram histogram;
  histogram.add(microseconds{1});
  histogram.add(microseconds{3});
  histogram.add(microseconds{3});
  std::uint64_t sum = 0;
  double end = -1;
  const auto octaves = histogram.octaves();
  for (const DurationHistogram::Bin& bin : octaves) {
    if (end >= 0) {
      EXPECT_DOUBLE_EQ(bin.from_us, end);
    }
    EXPECT_LT(bin.from_us, bin.to_us);
    end = bin.to_us;
    sum += bin.count;
  }
  EXPECT_EQ(sum, 3U);
  EXPECT_EQ(octaves.back().count, 2U);
}

TEST(DeadlineMonitor, MissesWhatIsSkippedOrMoreThanATickLate) {
  DeadlineMonitor monitor(microseconds{2000});
  TickTimes times{.waiting = microseconds{700},
                  .queued = microseconds{100},
                  .rendering = microseconds{50},
                  .network = microseconds{100},
                  .output = microseconds{10}};
  for (int i = 0; i < 7; ++i) monitor.add(times, 0);
  monitor.add(times, 2);
  times.queued = microseconds{1840};
  monitor.add(times, 0);  // to the microsecond in time
  times.queued = microseconds{1841};
  monitor.add(times, 0);
  EXPECT_EQ(monitor.counts().reported, 10U);
  EXPECT_EQ(monitor.counts().skipped, 2U);
  EXPECT_EQ(monitor.counts().late, 1U);
  EXPECT_DOUBLE_EQ(monitor.counts().missed_share(), 3.0 / 12);
  EXPECT_EQ(monitor.work().max(), microseconds{160});
  EXPECT_EQ(monitor.answer().max(), microseconds{2001});
  EXPECT_EQ(monitor.whole().max(), microseconds{2701});
}

TEST(DeadlineMonitor, ReportsNoWaitingOfAReplay) {
  DeadlineMonitor monitor(microseconds{2000});
  monitor.add({.waiting = {}, .queued = {}, .rendering = microseconds{5000}}, 0);
  EXPECT_EQ(monitor.counts().late, 0U);
  EXPECT_EQ(monitor.waiting().count(), 0U);
  EXPECT_EQ(monitor.rendering().count(), 1U);
}

}  // namespace
}  // namespace tactile::detect
