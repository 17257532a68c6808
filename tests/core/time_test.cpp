#include "tactile/core/time.hpp"

#include <gtest/gtest.h>

namespace tactile {
namespace {

TEST(CameraTime, IsHeldAtItsEnds) {
  EXPECT_EQ(before(CameraTime::min(), 1us), CameraTime::min());
  EXPECT_EQ(after(CameraTime::max(), 1us), CameraTime::max());
  EXPECT_EQ(before(camera_time(10), 3us), camera_time(7));
  EXPECT_EQ(between(CameraTime::min(), CameraTime::max()), microseconds::max());
  EXPECT_EQ(between(camera_time(5), camera_time(2)), -3us);
}

}  // namespace
}  // namespace tactile
