// Public recordings of real cameras, which are not part of this project: TACTILE_RECORDINGS names the folder that holds them.
#include <gtest/gtest.h>

#include "support/error_of.hpp"
#include "support/real_recordings.hpp"
#include "tactile/characterise/characterise.hpp"

namespace tactile::characterise {
namespace {

// The values are those of an independent program in numpy.

TEST(RealSensors, StillSceneOfADvxplorerHasTheKnownNoise) {
  const auto file = test::real_recording("derived/dvxplorer640_libcaer_rollover.aedat4");
  if (file.empty()) GTEST_SKIP() << test::not_tested_without("derived/dvxplorer640_libcaer_rollover.aedat4");
  const Sensor sensor = characterise({file}, {});
  EXPECT_EQ(sensor.events, 334'331U);
  EXPECT_NEAR(sensor.rate_hz.value, 167'167, 5);
  EXPECT_NEAR(sensor.rate_without_hot_hz.value, 136'270, 20);
  EXPECT_EQ(sensor.unusual.hot.value + sensor.unusual.stuck.value, 130);
  EXPECT_EQ(sensor.unusual.stuck.value, 1);
  EXPECT_NEAR(sensor.unusual.hot_share.value, 0.185, 0.0005);
  EXPECT_EQ(sensor.largest.tick.value, 11);
  EXPECT_EQ(sensor.largest.history.value, 205);
  EXPECT_NEAR(sensor.readout.period_us.value, 195.1632, 2e-4);
  EXPECT_FALSE(sensor.background.is_disturbed());
  EXPECT_TRUE(sensor.flicker.lines.empty());
}

TEST(RealSensors, MovingSceneIsRefused) {
  for (const char* name : {"aermanager/dvxplorer_class2_data_sample.aedat4", "faery/davis346.aedat4"}) {
    const auto file = test::real_recording(name);
    if (file.empty()) GTEST_SKIP() << test::not_tested_without(name);
    EXPECT_NE(test::error_of([&] { characterise({file}, {}); }).find("something moves all the time"), std::string::npos) << name;
  }
}

}  // namespace
}  // namespace tactile::characterise
