#include "tactile/simulation/simulated_video.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "planned_run.hpp"

namespace tactile::simulation {
namespace {

constexpr double px_per_mm = 1.3;

/// Neither noise nor steps of exposure.
VideoPhysics clean() {
  VideoPhysics physics;
  physics.noise_grey = 0;
  physics.exposure_steps_per_s = 0;
  return physics;
}

struct SimulatedFilm {
  explicit SimulatedFilm(const VideoPhysics& physics, std::uint64_t seed = 1, RunPlan drawn = planned_run())
      : plan(std::move(drawn)), video(object, plan, clocks, physics, Random(seed)) {}

  double seconds(std::size_t i) const { return seconds_of(video.times()[i], clocks.video, clocks); }
  /// The last frame at or before this.
  cv::Mat at(double t_s) {
    std::size_t i = 0;
    while (i + 1 < video.times().size() && seconds(i + 1) <= t_s) ++i;
    return video.draw(i);
  }

  ObjectModel object{.name = "a box", .why = {}, .half_width_mm = 20, .half_height_mm = 15, .reflectivity = 0.6};
  RunPlan plan;
  RunClocks clocks = planned_clocks();
  SimulatedVideo video;
};

bool same(const cv::Mat& a, const cv::Mat& b) { return std::equal(a.datastart, a.dataend, b.datastart, b.dataend); }

/// Mean row of the gripper's bar, darker than the wall behind it.
double row_of_bar(const cv::Mat& frame) {
  double weight = 0, rows = 0;
  for (int y = 0; y < 220; ++y) {
    const double darker = 70.0 - frame.at<std::uint8_t>(y, 100);
    weight += darker;
    rows += darker * y;
  }
  return rows / weight;
}

TEST(SimulatedVideo, TakesItsFramesUnevenlyBeyondBothEndsOfTheCamera) {
  std::int64_t frames = 0, lost = 0;
  double squares = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const SimulatedFilm film(clean(), seed);
    const std::vector<VideoTime>& times = film.video.times();
    EXPECT_EQ(us_of(times.front()), 0);
    EXPECT_NEAR(film.seconds(0), -0.5, 1e-9);
    EXPECT_GT(film.seconds(times.size() - 1), 6.0 - 0.04);
    EXPECT_LT(film.seconds(times.size() - 1), 6.0 + 0.3);
    for (std::size_t i = 1; i < times.size(); ++i) {
      const double step_ms = 1e-3 * static_cast<double>((times[i] - times[i - 1]).count());
      const double periods = std::round(step_ms * 0.03);
      ASSERT_GE(periods, 1);
      lost += std::llround(periods) - 1;
      squares += std::pow(step_ms - periods / 0.03, 2);
      ++frames;
    }
  }
  EXPECT_NEAR(static_cast<double>(lost) / static_cast<double>(frames), 0.01, 0.006);
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(frames)), 0.8 * std::sqrt(2.0), 0.15) << "[ms] both ends of a step jitter";
}

TEST(SimulatedVideo, HasTimesThatAscendHoweverTheyJitter) {
  VideoPhysics physics = clean();
  physics.jitter_ms = 100;
  const SimulatedFilm film(physics);
  for (std::size_t i = 1; i < film.video.times().size(); ++i) ASSERT_LT(film.video.times()[i - 1], film.video.times()[i]);
}

TEST(SimulatedVideo, ShowsMotionInTheFramesThatAreTakenDuringIt) {
  SimulatedFilm film(clean());
  const cv::Mat still = film.video.draw(0);
  ASSERT_EQ(still.rows, 240);
  ASSERT_EQ(still.cols, 320);
  ASSERT_EQ(still.type(), CV_8UC1);
  for (std::size_t i = 0; i < film.video.times().size(); ++i) {
    const double t_s = film.seconds(i);
    const bool before_tap = t_s<0.3, between = t_s> 0.5 && t_s < 1.0;
    const bool in_tap = t_s > 0.33 && t_s<0.47, in_press = t_s> 1.1 && t_s<1.8, in_lift = t_s> 3.55;
    if (before_tap || between) {
      ASSERT_TRUE(same(film.video.draw(i), still)) << t_s;
    } else if (in_tap || in_press || in_lift) {
      ASSERT_FALSE(same(film.video.draw(i), still)) << t_s;
    }
  }
}

TEST(SimulatedVideo, MovesTheGripperWithTheArm) {
  SimulatedFilm film(clean());
  const double before = row_of_bar(film.video.draw(0));
  double lowest = 0;
  for (std::size_t i = 0; i < film.video.times().size(); ++i) {
    const double mm = film.plan.arm_travel_at(film.seconds(i));
    ASSERT_NEAR(before - row_of_bar(film.video.draw(i)), px_per_mm * mm, 0.1) << film.seconds(i);
    lowest = std::min(lowest, mm);
  }
  EXPECT_LT(lowest, -2) << "[mm] a frame falls into a tap";
}

TEST(SimulatedVideo, ClosesTheStageOnTheObjectAndOpensIt) {
  SimulatedFilm film(clean());
  // The wall is seen in the gap between the dark sensor and the bright object.
  const auto gap_px = [&](double t_s) {
    const cv::Mat frame = film.at(t_s);
    double gap = 0;
    for (int x = 112; x < 134; ++x) gap += (frame.at<std::uint8_t>(180, x) - 25) / (70.0 - 25.0);
    return gap;
  };
  const double travel = film.plan.stage_travel_at(1.6) - film.plan.stage_travel_at(0.9);
  EXPECT_GT(travel, 1.0);
  EXPECT_NEAR(gap_px(0.9), px_per_mm * travel, 0.05);
  EXPECT_NEAR(gap_px(1.6), 0, 0.05);
  EXPECT_GT(gap_px(2.4), 0.8);
  EXPECT_NEAR(gap_px(3.4), 0, 0.05);
}

TEST(SimulatedVideo, ShowsAStageThatIsShutFromTheBeginning) {
  RunPlan plan = planned_run();
  plan.presses.erase(plan.presses.begin());
  plan.presses.front().stage_start_s = -3;
  plan.presses.front().contact_s = -2.7;
  SimulatedFilm film(clean(), 1, plan);
  EXPECT_EQ(film.at(0).at<std::uint8_t>(180, 132), 25) << "the sensor";
  EXPECT_EQ(film.at(0).at<std::uint8_t>(180, 136), 170) << "the object";
  EXPECT_TRUE(same(film.at(0), film.at(3)));
}

TEST(SimulatedVideo, ShowsBrightObjectsBright) {
  SimulatedFilm film(clean());
  film.object.reflectivity = 0.2;
  SimulatedVideo dark(film.object, film.plan, film.clocks, clean(), Random(1));
  EXPECT_EQ(dark.draw(0).at<std::uint8_t>(180, 160), 70);
  EXPECT_EQ(film.video.draw(0).at<std::uint8_t>(180, 160), 170);
}

TEST(SimulatedVideo, ChangesAllGreyLevelsAtOnceWithTheExposure) {
  VideoPhysics physics = clean();
  physics.exposure_steps_per_s = 3;
  SimulatedFilm film(physics);
  const std::vector<double>& exposures = film.video.exposures();
  ASSERT_EQ(exposures.size(), film.video.times().size());
  std::size_t steps = 0;
  for (std::size_t i = 0; i < exposures.size(); ++i) {
    if (i > 0 && exposures[i] != exposures[i - 1]) {
      ++steps;
      EXPECT_GE(exposures[i] / exposures[i - 1], 0.9 - 1e-9);
      EXPECT_LE(exposures[i] / exposures[i - 1], 1.1 + 1e-9);
    }
    const cv::Mat frame = film.video.draw(i);
    ASSERT_NEAR(frame.at<std::uint8_t>(10, 10), 70 * exposures[i], 0.51) << "the wall";
    ASSERT_NEAR(frame.at<std::uint8_t>(180, 160), std::min(255.0, 170 * exposures[i]), 0.51) << "the object";
    ASSERT_NEAR(frame.at<std::uint8_t>(235, 10), 105 * exposures[i], 0.51) << "the table";
  }
  EXPECT_GT(steps, 8U);
  EXPECT_LT(steps, 35U);
}

TEST(SimulatedVideo, HasTheStatedNoiseInEveryFrame) {
  VideoPhysics physics = clean();
  physics.noise_grey = 4;
  SimulatedFilm film(physics), quiet(clean());
  const auto noise_between = [](const cv::Mat& a, const cv::Mat& b) {
    double sum = 0, squares = 0;
    for (int y = 0; y < a.rows; ++y) {
      for (int x = 0; x < a.cols; ++x) {
        const double difference = static_cast<double>(a.at<std::uint8_t>(y, x)) - b.at<std::uint8_t>(y, x);
        sum += difference;
        squares += difference * difference;
      }
    }
    const double pixels = 320.0 * 240.0;
    EXPECT_NEAR(sum / pixels, 0, 0.35) << "a few thousand values, each of them often";
    return std::sqrt(squares / pixels);
  };
  const cv::Mat still = quiet.video.draw(0);
  EXPECT_NEAR(noise_between(film.video.draw(0), still), 4, 0.15);
  for (std::size_t i = 1; i < 10; ++i)
    EXPECT_NEAR(noise_between(film.video.draw(i), film.video.draw(i - 1)), 4 * std::sqrt(2.0), 0.2) << i;
}

TEST(SimulatedVideo, IsTheSameForTheSameSeed) {
  SimulatedFilm film({}, 3), again({}, 3), other({}, 4);
  EXPECT_EQ(film.video.times(), again.video.times());
  EXPECT_EQ(film.video.exposures(), again.video.exposures());
  EXPECT_TRUE(same(film.video.draw(7), again.video.draw(7)));
  EXPECT_NE(film.video.times(), other.video.times());
  EXPECT_FALSE(same(film.video.draw(7), other.video.draw(7)));
}

}  // namespace
}  // namespace tactile::simulation
