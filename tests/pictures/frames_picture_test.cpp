#include "tactile/pictures/frames_picture.hpp"

#include <gtest/gtest.h>

#include "support/drawn_plot.hpp"
#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "windows/made_runs.hpp"

namespace tactile::pictures {
namespace {

using test::drawn;
using test::TemporaryFolder;

TEST(Frames, AreThoseBeforeAndInPressAndSlip) {
  const TemporaryFolder folder;
  const test::LabelledRun run;
  test::make_run(folder / "data", run);
  const auto frames = frames_of(run_folder_at(folder / "data/fan/01"), {});
  ASSERT_EQ(frames.size(), 6U);
  const std::vector<Touch> touches{Touch::none, Touch::press, Touch::press, Touch::none, Touch::slip, Touch::slip};
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].touch, touches[i]);
    // All events of the history are in the raw frame, whatever blocks they were summed over.
    EXPECT_EQ(cv::sum(frames[i].raw)[0], static_cast<double>(frames[i].events));
  }
  EXPECT_TRUE(frames_of({.folder = folder / "data", .object = "x", .run = "01"}, {}).empty());  // not labelled
}

TEST(FramesPlot, ShowsCountsRightWayUpAndRefusesWhatIsNoFrame) {
  TouchFrame frame{.caption = "30 ms into press",
                   .touch = Touch::press,
                   .events = 42,
                   .raw = cv::Mat::zeros(3, 4, CV_32F),
                   .heatmap = cv::Mat::zeros(6, 8, CV_8U)};
  frame.raw.at<float>(0, 1) = 7;  // in the top row, which gnuplot takes last
  const Plot plot = frames_plot("Frames", {frame});
  ASSERT_EQ(plot.tables.size(), 2U);
  EXPECT_EQ(plot.tables[0].columns, 4U);
  EXPECT_EQ(plot.tables[0].values[9], 7);
  const std::string svg = drawn(plot);
  for (const char* words : {"30 ms into press", "42 events", "<image"}) EXPECT_NE(svg.find(words), std::string::npos) << words;
  EXPECT_NE(test::error_of([] { frames_plot("Nothing", {}); }).find("none to draw"), std::string::npos);
  frame.raw = cv::Mat();
  EXPECT_NE(test::error_of([&] { frames_plot("Empty", {frame}); }).find("no pair of pictures"), std::string::npos);
}

}  // namespace
}  // namespace tactile::pictures
