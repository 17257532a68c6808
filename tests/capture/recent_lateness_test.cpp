#include "tactile/capture/recent_lateness.hpp"

#include <gtest/gtest.h>

#include "support/host_time.hpp"

namespace tactile::capture {
namespace {

using test::host_time;

TEST(RecentLateness, IsTheMostOfTheLastTenthsOfASecond) {
  RecentLateness recent;
  const auto at = [&](std::int64_t ms, std::int64_t late_us) {
    recent.add(host_time(1'000 * ms), microseconds{late_us});
    return recent.most(host_time(1'000 * ms)).count();
  };
  EXPECT_EQ(at(1'000, 5), 5);
  EXPECT_EQ(at(1'050, 900), 900);
  EXPECT_EQ(at(1'110, 7), 900) << "of the window before";
  EXPECT_EQ(at(1'220, 3), 7);
  EXPECT_EQ(at(5'000, 1), 1) << "what was before a silence is over";
  EXPECT_EQ(recent.most(host_time(5'250'000)).count(), 0) << "and during it, too";
}

}  // namespace
}  // namespace tactile::capture
