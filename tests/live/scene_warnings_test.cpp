#include "tactile/live/scene_warnings.hpp"

#include <gtest/gtest.h>

namespace tactile::live {
namespace {

constexpr events::SensorSize scene_sensor{100, 100};  // so that 5000 events per second are 0.5 per pixel
constexpr double usual_hz = 5'000;

std::string first_warning(const characterise::Scene& scene, const std::vector<characterise::Scene>& earlier = {}) {
  const std::vector<std::string> warnings = scene_warnings(scene, earlier, scene_sensor);
  return warnings.empty() ? "" : warnings.front();
}

TEST(SceneWarnings, ASensorInGoodLightHasNone) {
  EXPECT_EQ(first_warning({.background_hz = usual_hz, .hot_pixels = 130, .flicker_hz = 60, .flicker_depth = 0.06}), "");
}

TEST(SceneWarnings, NameNoiseDarkHotPixelsAndFlickerWithTheirSize) {
  EXPECT_EQ(first_warning({.background_hz = 25'000}),
            "much noise: 2.50 events per second and pixel while nothing moves; expected 1.5 at most: more light helps");
  EXPECT_EQ(first_warning({.background_hz = 10}),
            "nearly no noise: 0.0010 events per second and pixel; the sensor may be covered or very dark");
  EXPECT_EQ(first_warning({.background_hz = usual_hz, .hot_pixels = 500}),
            "500 hot pixels; expected 400 at most: 'tactile characterise' makes a mask of them");
  EXPECT_EQ(first_warning({.background_hz = usual_hz, .flicker_hz = 100, .flicker_depth = 0.4}),
            "the light flickers at 100 Hz, 40 % of the event rate; a lamp on direct current does not");
}

TEST(SceneWarnings, NameABackgroundThatIsFarFromWhatItWas) {
  const std::vector<characterise::Scene> earlier(3, characterise::Scene{.background_hz = usual_hz});
  EXPECT_EQ(first_warning({.background_hz = 1.9 * usual_hz}, earlier), "");
  EXPECT_EQ(first_warning({.background_hz = 2.05 * usual_hz}, earlier),
            "the background is 10 kev/s, and was 5: did light or focus change?");
  EXPECT_NE(first_warning({.background_hz = 0.4 * usual_hz}, earlier), "");
  EXPECT_EQ(first_warning({.background_hz = 2.1 * usual_hz}, {earlier[0], earlier[1]}), "") << "two scenes are too few";
}

}  // namespace
}  // namespace tactile::live
