// Public recordings of real cameras, which are not part of this project: TACTILE_RECORDINGS names the folder that holds them.
#include <gtest/gtest.h>

#include <cstdlib>

#include "tactile/characterise/characterise.hpp"

namespace tactile::characterise {
namespace {

std::optional<std::filesystem::path> recording_named(const std::string& name) {
  const char* folder = std::getenv("TACTILE_RECORDINGS");
  if (folder == nullptr) return std::nullopt;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().filename() == name) return entry.path();
  }
  return std::nullopt;
}

// The values are those of an independent program in numpy.

TEST(RealSensors, StillSceneOfADvxplorerHasTheKnownNoise) {
  const auto file = recording_named("dvxplorer640_libcaer_rollover.aedat4");
  if (!file) GTEST_SKIP() << "TACTILE_RECORDINGS has no dvxplorer640_libcaer_rollover.aedat4";
  const Sensor sensor = characterise({*file}, {});
  EXPECT_EQ(sensor.events, 334'331U);
  EXPECT_NEAR(sensor.rate_hz.value, 167'167, 5);
  EXPECT_NEAR(sensor.rate_without_hot_hz.value, 136'270, 20);
  EXPECT_EQ(sensor.unusual.hot.value + sensor.unusual.stuck.value, 130);
  EXPECT_EQ(sensor.unusual.stuck.value, 1);
  EXPECT_NEAR(sensor.unusual.hot_share.value, 0.185, 0.0005);
  EXPECT_EQ(sensor.largest.tick, 11U);
  EXPECT_EQ(sensor.largest.history, 205U);
  EXPECT_NEAR(sensor.readout.period_us.value, 195.1632, 2e-4);
  EXPECT_FALSE(sensor.background.is_disturbed());
  EXPECT_TRUE(sensor.flicker.lines.empty());
}

TEST(RealSensors, MovingSceneIsSeenAsDisturbed) {
  const auto file = recording_named("dvxplorer_class2_data_sample.aedat4");
  if (!file) GTEST_SKIP() << "TACTILE_RECORDINGS has no dvxplorer_class2_data_sample.aedat4";
  const Sensor sensor = characterise({*file}, {});
  EXPECT_EQ(sensor.unusual.hot.value + sensor.unusual.stuck.value, 49);
  EXPECT_NEAR(sensor.unusual.hot_share.value, 0.077, 0.0005);
  EXPECT_NEAR(sensor.readout.period_us.value, 197.2832, 2e-4);
  EXPECT_TRUE(sensor.background.is_disturbed());
}

}  // namespace
}  // namespace tactile::characterise
