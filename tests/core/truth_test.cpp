#include "tactile/core/truth.hpp"

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile {
namespace {

TEST(Truth, ComesBackAsItWasWritten) {
  Truth truth;
  truth.intervals.push_back({{Touch::press, camera_time(1'700'000'000'700'123), camera_time(1'700'000'000'900'001)},
                             {},
                             camera_time(1'700'000'000'700'200),
                             true});
  truth.intervals.push_back({{Touch::slip, camera_time(1'700'000'001'300'000), camera_time(1'700'000'001'900'000)},
                             camera_time(1'700'000'001'320'000),
                             {},
                             false,
                             "micro-slip"});
  truth.hot_pixels = {{.x = 3, .y = 479, .hz = 1234.5}, {.x = 639, .y = 0, .hz = 100}};
  truth.dead_pixels = {{.x = 7, .y = 8, .hz = 0}};
  truth.lift_start = camera_time(1'700'000'001'290'000);
  truth.robot_clock = {.offset_us = 1'699'999'900'000'000, .drift_ppm = -37.25, .reference_us = 100'000'000};
  truth.video_clock = {.offset_us = 1'700'000'000'000'017, .drift_ppm = 12.5, .reference_us = 0};
  truth.parameters = {{"object", "fan"}};

  const test::TemporaryFolder folder;
  write_truth(folder / "truth.json", truth);
  const Truth back = read_truth(folder / "truth.json");
  ASSERT_EQ(back.intervals.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(back.intervals[i].interval.touch, truth.intervals[i].interval.touch);
    EXPECT_EQ(back.intervals[i].interval.start, truth.intervals[i].interval.start);
    EXPECT_EQ(back.intervals[i].interval.end, truth.intervals[i].interval.end);
    EXPECT_EQ(back.intervals[i].gross, truth.intervals[i].gross);
    EXPECT_EQ(back.intervals[i].first_event, truth.intervals[i].first_event);
    EXPECT_EQ(back.intervals[i].labelled, truth.intervals[i].labelled);
    EXPECT_EQ(back.intervals[i].what, truth.intervals[i].what);
  }
  EXPECT_EQ(back.lift_start, truth.lift_start);
  EXPECT_EQ(back.robot_clock->offset_us, truth.robot_clock->offset_us);
  EXPECT_EQ(back.robot_clock->drift_ppm, truth.robot_clock->drift_ppm);
  EXPECT_EQ(back.robot_clock->reference_us, truth.robot_clock->reference_us);
  EXPECT_EQ(back.video_clock->offset_us, truth.video_clock->offset_us);
  EXPECT_EQ(back.parameters, truth.parameters);
  EXPECT_EQ(back.hot_pixels, truth.hot_pixels);
  EXPECT_EQ(back.dead_pixels, truth.dead_pixels);
}

TEST(Truth, KnowsNoClockOfWhatWasNotSimulated) {
  const test::TemporaryFolder folder;
  Truth truth;
  truth.video_clock = {.offset_us = 17, .drift_ppm = 0, .reference_us = 0};
  write_truth(folder / "truth.json", truth);
  EXPECT_FALSE(read_truth(folder / "truth.json").robot_clock.has_value());
  EXPECT_EQ(read_truth(folder / "truth.json").video_clock->offset_us, 17);
}

TEST(Truth, RefusesWhatIsNone) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(read_truth(folder / "truth.json"), Error) << "not there";
  const std::string clocks =
      R"("clocks": {"robot": {"offset_us": 0, "drift_ppm": 0, "reference_us": 0}, "video": {"offset_us": 0, "drift_ppm": 0, "reference_us": 0}})";
  const auto read = [&](const std::string& text) {
    write_whole(folder / "truth.json", text);
    return read_truth(folder / "truth.json");
  };
  EXPECT_NO_THROW(read(R"({"intervals": [], )" + clocks + "}"));
  EXPECT_TRUE(read(R"({"intervals": [{"class": "press", "start_us": 5, "end_us": 6, "labelled": true}], )" + clocks + "}")
                  .intervals.at(0)
                  .what.empty())
      << "of an earlier version";
  EXPECT_THROW(read(R"({"intervals": [], "hot_pixels": 3, )" + clocks + "}"), Error);
  EXPECT_THROW(read(R"({"intervals": [], "hot_pixels": [{"x": 3}], )" + clocks + "}"), Error);
  EXPECT_THROW(read("{" + clocks + "}"), Error) << "no intervals";
  EXPECT_THROW(read(R"({"intervals": [], "clocks": {}})"), Error) << "no robot clock";
  EXPECT_THROW(read(R"({"intervals": [{"class": "press", "start_us": 5, "end_us": 5, "labelled": true}], )" + clocks + "}"),
               Error)
      << "an empty interval";
  EXPECT_THROW(read(R"({"intervals": [{"class": "grip", "start_us": 5, "end_us": 6, "labelled": true}], )" + clocks + "}"), Error)
      << "no such class";
}

}  // namespace
}  // namespace tactile
