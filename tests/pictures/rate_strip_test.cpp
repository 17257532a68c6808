#include "tactile/pictures/rate_strip.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "tactile/pictures/drawing.hpp"

namespace tactile::pictures {
namespace {

CameraTime strip_at_ms(std::int64_t ms) { return camera_time(1000 * ms); }

/// So many events at 100, 101, ... ms, up to 200 ms.
EventCurve burst(std::size_t events_per_ms) {
  EventCurve curve(strip_at_ms(0), 1ms);
  for (int ms = 100; ms < 200; ++ms) {
    std::vector<events::Event> events(events_per_ms);
    for (events::Event& event : events) event.t = strip_at_ms(ms);
    curve.add(events);
  }
  return curve;
}

class RateStripTest : public testing::Test {
 protected:
  cv::Mat sheet = cv::Mat(RateStrip::height + 40, 600, CV_8UC3, paper);
  cv::Rect place{20, 20, 560, RateStrip::height};
};

TEST_F(RateStripTest, DrawsTheRateWhereItIs) {
  const RateStrip strip(strip_at_ms(0), strip_at_ms(400), strip_at_ms(0), place);
  strip.draw(sheet, burst(50), {});
  const auto grey_in = [&](std::int64_t ms) {
    cv::Mat found;
    cv::inRange(sheet.col(strip.column_of(strip_at_ms(ms))), cv::Scalar(160, 160, 160), cv::Scalar(160, 160, 160), found);
    return cv::countNonZero(found);
  };
  EXPECT_LT(grey_in(50), 3);
  EXPECT_GT(grey_in(150), RateStrip::height / 2);
  EXPECT_LT(grey_in(300), 3);
}

TEST_F(RateStripTest, MarksLabelsAboveAndHeldWithinWhatIsShown) {
  const RateStrip strip(strip_at_ms(100), strip_at_ms(200), strip_at_ms(0), place);
  const std::vector<TouchInterval> intervals{{Touch::press, strip_at_ms(0), strip_at_ms(120)},
                                             {Touch::slip, strip_at_ms(180), strip_at_ms(900)},
                                             {Touch::slip, strip_at_ms(1000), strip_at_ms(1100)}};
  strip.draw(sheet, burst(50), intervals);
  const auto row_of_bar = [&](const cv::Scalar& colour, int column) {
    for (int y = 0; y < sheet.rows; ++y) {
      if (cv::norm(cv::Scalar(sheet.at<cv::Vec3b>(y, column)), colour) == 0) return y;
    }
    return -1;
  };
  EXPECT_GT(row_of_bar(touch_colour(Touch::press), strip.column_of(strip_at_ms(119))), 0);
  EXPECT_EQ(row_of_bar(touch_colour(Touch::press), strip.column_of(strip_at_ms(125))), -1);
  EXPECT_GT(row_of_bar(touch_colour(Touch::slip), strip.column_of(strip_at_ms(199))), 0);
  sheet(place).setTo(paper);
  EXPECT_EQ(cv::norm(sheet, cv::Mat(sheet.size(), CV_8UC3, paper)), 0) << "nothing is drawn beside its place";
}

TEST_F(RateStripTest, StaysWithinItsPlaceForAnyTimes) {
  constexpr auto least = std::numeric_limits<std::int64_t>::min(), most = std::numeric_limits<std::int64_t>::max();
  const std::vector<std::pair<std::int64_t, std::int64_t>> spans{
      {0, 1}, {least, most}, {least, least + 1}, {most - 1, most}, {-5, 7}};
  for (const auto& [begin, end] : spans) {
    for (const std::int64_t zero : {least, std::int64_t{0}, most}) {
      sheet.setTo(paper);
      const RateStrip strip(camera_time(begin), camera_time(end), camera_time(zero), place);
      EventCurve curve(camera_time(begin));
      std::vector<events::Event> events(1);
      events[0].t = camera_time(end);
      curve.add(events);
      strip.draw(sheet, curve, std::vector<TouchInterval>{{Touch::slip, camera_time(begin), camera_time(end)}});
      strip.draw_cursor(sheet, camera_time(end), 40ms);
      strip.draw_marks(sheet, std::vector<CameraTime>{camera_time(begin), camera_time(end)});
      sheet(place).setTo(paper);
      EXPECT_EQ(cv::norm(sheet, cv::Mat(sheet.size(), CV_8UC3, paper)), 0) << begin << " to " << end << " from " << zero;
    }
  }
}

}  // namespace
}  // namespace tactile::pictures
